"""Every joint, force and contact against dense NumPy, at random states."""

import numpy as np
import pytest

from reference.mechanism import Reference
from reference.outline import Outline
from reference.random_mechanisms import OUTLINES, compare, joined, loaded


@pytest.mark.filterwarnings("ignore:nothing connects", "ignore:.*at a penetration of")
@pytest.mark.parametrize(
    "kind",
    [
        "revolute",
        "fixed",
        "prismatic",
        "point_on_line",
        "distance",
        "gear",
        "planet",
        "rack",
        "driven angle",
        "driven speed",
        "driven position",
    ],
)
def test_a_joint_of_each_kind_is_that_of_the_reference(kind):
    rng = np.random.default_rng(11)
    for _ in range(5):
        compare(joined(kind, rng), rng)


@pytest.mark.filterwarnings("ignore:nothing connects", "ignore:.*at a penetration of")
@pytest.mark.parametrize(
    "kind",
    [
        "spring",
        "spring by a table",
        "torsion spring",
        "force",
        "force that follows",
        "torque",
        "torque by speed",
    ],
)
def test_a_load_of_each_kind_is_that_of_the_reference(kind):
    rng = np.random.default_rng(12)
    for _ in range(5):
        compare(loaded(kind, rng), rng)


@pytest.mark.filterwarnings("ignore:nothing connects", "ignore:.*at a penetration of")
@pytest.mark.parametrize("kind", ["bore", "disc", "segment"])
def test_a_contact_of_each_kind_is_that_of_the_reference(kind):
    rng, pressed, made = np.random.default_rng(13), 0, 0
    while made < 5:
        mechanism = loaded(kind, rng)
        reference = Reference(mechanism)
        # The centre of the circle must begin outside the material.
        if reference.distance(mechanism.contacts[0], reference.placed) > 0.0:
            made += 1
            pressed += compare(mechanism, rng)[0]
    assert pressed > 10


def test_distances_on_an_outline_are_those_of_its_points():
    """The reference against brute force: the nearest of many points is its least distance."""
    rng = np.random.default_rng(14)
    for kind in OUTLINES:
        mechanism = loaded(kind, rng)
        outline = Outline(mechanism.contacts[0])
        parts = np.linspace(0.0, 1.0, 2001)
        points = np.array([piece.at(part) for piece in outline.pieces for part in parts])
        for point in rng.uniform(-1.5, 1.5, (20, 2)):
            found, _ = outline.places(point)
            if found is None:
                continue
            least = min(distance(point) for sign, distance in found if sign > 0.0)
            assert abs(np.hypot(*(points - point).T).min() - least) < 1e-5


@pytest.mark.filterwarnings("ignore:nothing connects", "ignore:.*at a penetration of")
@pytest.mark.parametrize("kind", list(OUTLINES))
def test_a_circle_on_an_outline_is_that_of_the_reference(kind):
    rng, pressed, made = np.random.default_rng(15), 0, 0
    while made < 6:
        mechanism = loaded(kind, rng)
        reference = Reference(mechanism)
        if not reference.is_in_front(reference.placed[reference.free].ravel()):
            continue
        made += 1
        pressed += compare(mechanism, rng)[0]
    assert pressed > 5
