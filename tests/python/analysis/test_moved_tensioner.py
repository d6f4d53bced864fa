"""Places in the wrap of a drive whose tensioner has taken up two pitches of slack."""

import math
import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import rustchain as rc

SPROCKETS = [
    rc.Sprocket(17, (0, 0), rc.PrescribedSpeed(20.0)),
    rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(-2.0), load_inertia=5e-3),
    rc.Sprocket(21, (0.25, 0.22)),
    rc.Sprocket(13, (0.09, 0.10), side="outside"),
]
TEETH = (17, 25, 21, 13)
START = 0.05  # [s]


@cache
def run_of(first, tensioner=True):
    """Return a run of the drive numbered from this sprocket, or with its idler at a fixed place."""
    sprockets = SPROCKETS[first:] + SPROCKETS[:first]
    idler = [sprocket.teeth for sprocket in sprockets].index(21) + 1
    given = {"tensioner": rc.Tensioner(80.0, sprocket=idler)} if tensioner else {"adjust": idler}
    links = None if tensioner else 98
    drive = rc.chain_drive("ANSI 40", sprockets, links=links, **given)
    record = ("hinges", "teeth", "sprockets", "bodies")
    return rc.Simulation(drive, start="static").run(0.2, record=record, progress=False)


def number_of(result, teeth):
    return [sprocket.teeth for sprocket in result.drive.sprockets].index(teeth) + 1


def centroid(result, teeth):
    """Return the place in the wrap at which the load of a sprocket has its mean [pitches]."""
    loads = result.wrap_loads(number_of(result, teeth), start=START)
    mean, place = loads["mean"].fillna(0.0).to_numpy(), loads["position"].to_numpy()
    mean = np.where((place > -1.5) & (place < loads.attrs["wrap"] + 1.5), mean, 0.0)
    return (mean * place).sum() / mean.sum()


def measured(result, teeth):
    """Return the same by the angles of loaded bushings, from the line that meets the circle.

    The chain runs counterclockwise: wheels lie left of the line, those on the outside right of it.
    """
    rows = result.time >= START
    pitch, drive = result.drive.chain.pitch, result.drive
    here = TEETH.index(teeth)
    center, radius = [], []
    for count in (TEETH[here - 1], teeth):
        sprocket = drive.sprockets[number_of(result, count) - 1]
        left = 1.0 if sprocket.side == "inside" else -1.0
        radius.append(left * pitch / (2 * math.sin(math.pi / count)))
        center.append(result.sprocket(number_of(result, count)).center[rows])
    way = center[1] - center[0]
    # Centres are the radii apart across the line.
    tilt = np.arcsin((radius[1] - radius[0]) / np.hypot(*way.T))
    line = np.arctan2(way[:, 1], way[:, 0]) - tilt
    left = math.copysign(1.0, radius[1])
    meeting = line - left * math.pi / 2
    x, y, angle = np.moveaxis(result.array("positions")[rows, : drive.chain.links], -1, 0)
    front = np.stack([x + 0.5 * pitch * np.cos(angle), y + 0.5 * pitch * np.sin(angle)], -1)
    arm = front - center[1][:, None]
    turned = left * (np.arctan2(arm[..., 1], arm[..., 0]) - meeting[:, None])
    place = (turned * teeth / (2 * math.pi) + 2.0) % teeth - 2.0
    on = result.array("tooth_sprocket")[rows] == number_of(result, teeth)
    force = np.where(on, result.array("tooth_force")[rows], 0.0)
    return (force * place).sum() / force.sum()


@pytest.mark.parametrize("teeth", TEETH)
@pytest.mark.parametrize("first", [0, 1, 2, 3])
def test_loads_in_the_wrap_are_where_their_bushings_are(first, teeth):
    """They were up to 1.8 pitches away, by the number of the sprockets."""
    result = run_of(first)
    assert centroid(result, teeth) == pytest.approx(measured(result, teeth), abs=0.05)
    assert centroid(result, teeth) == pytest.approx(centroid(run_of(0), teeth), abs=0.05)


@pytest.mark.parametrize("teeth", TEETH)
def test_of_a_drive_without_tensioner_too(teeth):
    result = run_of(0, tensioner=False)
    assert centroid(result, teeth) == pytest.approx(measured(result, teeth), abs=0.05)


@pytest.mark.parametrize("first", [0, 1])
def test_the_part_of_a_run_has_the_same_places_without_bodies(first):
    whole = run_of(first)
    arrays = {name: array for name, array in whole.arrays.items() if name != "positions"}
    part = replace(whole, arrays=arrays).between(start=0.1)
    for number in (1, 2, 3, 4):
        found, expected = part.wrap_loads(number), whole.wrap_loads(number, start=0.1)
        assert found.attrs == expected.attrs
        np.testing.assert_allclose(found["quantiles"][..., 1], expected["quantiles"][..., 1])


@pytest.mark.parametrize("first", [0, 1, 2, 3])
def test_sections_of_the_path_are_where_bushings_touch_the_sprockets(first):
    """Hinge forces replaced by 1 N where the bushing touches a sprocket: their middle."""
    result = run_of(first)
    steps = np.diff(result.time, prepend=result.time[0])[:, None]
    links = result.drive.chain.links
    for number in (1, 2, 3, 4):
        touching = (result.array("tooth_sprocket") == number) * steps
        made = replace(result, arrays=result.arrays | {"peak_hinge_impulse": touching})
        loads = made.hinge_loads(start=START)
        around = np.exp(2j * math.pi * loads["position"].to_numpy() / links)
        named = (loads["section"] == f"sprocket {number}").to_numpy()
        apart = np.angle(
            (loads["mean"].fillna(0.0).to_numpy() * around).sum() / around[named].sum()
        )
        assert abs(apart) * links / (2 * math.pi) < 0.35


def test_sprockets_that_have_come_together_are_told_by_their_numbers(tmp_path):
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(40.0)),
        rc.Sprocket(25, (0.4, 0.0), rc.AppliedTorque(-8.0), load_inertia=1e-3),
    ]
    tensioner = rc.Tensioner(30.0, damping=100.0, ramp_time=0.02)
    drive = rc.chain_drive("ANSI 40", sprockets, links=86, tensioner=tensioner)
    result = rc.Simulation(drive).run(2e-3, progress=False)
    center = result.array("sprocket_center").copy()
    center[-1, 1] = center[-1, 0] + (0.01, 0.0)
    moved = replace(result, arrays={**result.arrays, "sprocket_center": center})
    for call in (moved.hinge_loads, lambda: moved.wrap_loads(1)):
        with pytest.raises(rc.InvalidInput, match=r"sprockets 1 and 2: their centres are 0\.01 m"):
            call()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        moved.report(tmp_path / "report.html")  # which leaves the figure out
