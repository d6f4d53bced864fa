"""Names on the public face: unknown ones are answered with the nearest, heavy imports wait."""

import dataclasses
import inspect
import subprocess
import sys

import numpy as np
import pytest

import rustchain as rc


@pytest.mark.parametrize(
    ("call", "nearest"),
    [
        (lambda: rc.Sprocket(tooth=17), "teeth"),
        (lambda: rc.Material(youngs_modulus=2e11, poison_ratio=0.3), "elastic_modulus"),
        (lambda: rc.LankaraniNikravesh(dampin=None), "damping"),
        (lambda: rc.Solver(rtoll=1e-6), "rtol"),
        (lambda: rc.paper_drive(pre_tension=25.0), "pretension"),
        (lambda: rc.two_sprocket_drive(centre_distance=0.2), "center_distance"),
        (lambda: rc.Simulation(rc.paper_drive(), forcelaw=rc.Hertz()), "force_law"),
        (lambda: rc.Simulation(rc.paper_drive()).run(duration=1e-3, recrod=()), "record"),
        (lambda: rc.Simulation(rc.paper_drive()).evaluate(position=None), "positions"),
    ],
)
def test_an_unknown_keyword_is_answered_with_the_nearest_name(call, nearest):
    with pytest.raises(TypeError, match=f"'{nearest}'"):
        call()


def test_a_keyword_like_no_other_is_answered_with_all_names():
    with pytest.raises(
        TypeError, match=r"Link\(\) has no argument 'xyz'; known: 'mass', 'inertia'"
    ):
        rc.Link(xyz=1.0)


def test_replace_works_and_knows_the_names_too():
    link = rc.Link(mass=1.0, inertia=2.0)
    assert dataclasses.replace(link, mass=3.0) == rc.Link(mass=3.0, inertia=2.0)
    with pytest.raises(TypeError, match="did you mean 'mass'"):
        dataclasses.replace(link, mas=3.0)


def test_signatures_show_the_parameters():
    assert list(inspect.signature(rc.Tensioner).parameters)[:2] == ["pretension", "sprocket"]
    assert "report_step" in inspect.signature(rc.Simulation.run).parameters


def test_descriptions_are_frozen_and_can_be_hashed():
    drive = rc.paper_drive()
    with pytest.raises(dataclasses.FrozenInstanceError):
        drive.name = "mine"
    assert hash(drive) == hash(rc.paper_drive())


def test_lists_and_arrays_become_tuples():
    rows = np.array([[0.0, 0.0], [0.1, 12.5]])
    assert rc.PrescribedSpeed(rows) == rc.PrescribedSpeed([(0.0, 0.0), (0.1, 12.5)])
    assert rc.PrescribedSpeed(rows).speed == ((0.0, 0.0), (0.1, 12.5))
    assert isinstance(rc.paper_drive().sprockets, tuple)


def test_a_wrong_value_names_its_field():
    with pytest.raises(rc.InvalidInput, match="poisson_ratio"):
        rc.Material(poisson_ratio=-1.5)
    assert issubclass(rc.InvalidInput, ValueError)


def test_a_chain_that_is_not_listed_is_answered_with_the_nearest():
    with pytest.raises(rc.InvalidInput, match="did you mean 'ANSI 40'"):
        rc.two_sprocket_drive(chain="ASA 40", links=60)


def test_a_chain_is_found_in_any_case():
    assert rc.catalogue_chain("ansi 40", links=60).name == "ANSI 40"


def test_a_catalogue_chain_weighs_what_the_maker_says():
    chain = rc.catalogue_chain("ANSI 40", links=60)
    weight = (chain.inner.mass + chain.outer.mass) / (2 * chain.pitch)
    assert weight == pytest.approx(0.41 * 0.45359237 / 0.3048)


def test_a_drive_needs_links_or_a_distance():
    with pytest.raises(rc.InvalidInput, match="links=None and center_distance=None"):
        rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25))


def test_links_and_distance_follow_from_each_other():
    by_links = rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25), links=60)
    distance = by_links.sprockets[1].center[0]
    by_distance = rc.two_sprocket_drive(
        chain="ANSI 40", teeth=(17, 25), center_distance=distance - 1e-4
    )
    assert by_distance.chain.links == 60


def test_the_report_of_a_drive_is_a_table():
    report = rc.paper_drive().check()
    assert report.links == 38
    assert report.teeth == (17, 17)
    assert "centre distance" in str(report)
    assert "133.348699 mm" in str(report)


def test_importing_rustchain_leaves_the_heavy_packages_alone():
    heavy = "{'matplotlib', 'pandas', 'xarray', 'tqdm', 'typer', 'pydantic'}"
    script = f"import sys, rustchain; print(sorted({heavy} & sys.modules.keys()))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_all_public_names_are_there():
    assert all(hasattr(rc, name) for name in rc.__all__)


def test_the_instruction_set_has_a_name():
    assert rc.instruction_set() in {"avx512", "avx2", "neon", "plain"}
