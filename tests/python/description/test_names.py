"""Names on the public face: unknown ones are answered with the nearest, heavy imports wait."""

import ast
import dataclasses
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc
from rustchain.files.models import makers_of
from rustchain.files.scene import load_scene, save_scene


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


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: rc.Table([0.0, 1.0], [2.0, 3.0]), "Table() takes rows by position, got 2 values"),
        (
            lambda: rc.two_sprocket_drive("ANSI 40", (17, 25), 60),
            "two_sprocket_drive() takes chain, teeth by position, got 3 values; give the others by "
            "name",
        ),
        (
            lambda: rc.Result.hinge_loads(object(), 3),
            "hinge_loads() takes nothing by position, got 1 values; give the others by name",
        ),
    ],
)
def test_too_many_values_are_answered_with_what_is_taken_by_position(call, says):
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == says


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


def test_a_keyword_that_is_a_field_of_what_a_function_returns_is_told_with_the_remedy():
    said = (
        r"'elongation'; it is a field of Chain: dataclasses\.replace\(catalogue_chain\(\.\.\.\), "
    )
    with pytest.raises(TypeError, match=said):
        rc.catalogue_chain("ANSI 40", 60, elongation=0.01)


@pytest.mark.parametrize("function", [rc.sweep, rc.study, rc.loss_map])
def test_a_keyword_that_is_a_field_of_the_scene_is_told_with_the_remedy(function):
    name = function.__name__
    said = rf"'start'; it is a field of the scene: {name}\(rc\.Scene\(drive, start=\.\.\.\)"
    with pytest.raises(TypeError, match=said):
        function(rc.paper_drive(), start="static")


def test_what_a_force_law_takes_from_the_material_is_told():
    with pytest.raises(TypeError, match="'restitution'; it is a field of Material"):
        rc.LankaraniNikravesh(restitution=0.5)
    with pytest.raises(TypeError, match="did you mean 'damping'"):
        rc.LankaraniNikravesh(dampin=None)


def test_a_force_law_of_ones_own_is_refused_with_the_remedy():
    class Own(rc.ForceLaw):
        """A law in Python."""

    for law in (Own, rc.ForceLaw):
        with pytest.raises(rc.InvalidInput, match=r"one of the force laws .*add_callable"):
            law()


def test_laws_of_files_are_those_of_the_package(tmp_path):
    before = makers_of(rc.ForceLaw)

    class Own(rc.Hertz):
        """A law derived from one of the package."""

    assert makers_of(rc.ForceLaw) == before
    path = tmp_path / "drive.toml"
    save_scene(rc.Scene(rc.paper_drive(), force_law=rc.Hertz()), path)
    assert load_scene(path).force_law == rc.Hertz()


def test_an_unknown_attribute_of_a_simulation_is_answered_with_the_nearest_name():
    with pytest.raises(AttributeError, match="did you mean 'velocities'"):
        rc.Simulation(rc.paper_drive()).velocity  # noqa: B018


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


def python(script, *arguments):
    """Return what a script prints in a process of its own."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_importing_rustchain_imports_less_than_importing_numpy():
    """Modules, not times, which differ from machine to machine."""
    count = "import sys; before = {*sys.modules}; import %s; print(*({*sys.modules} - before))"
    own, numpy = (python(count % name).split() for name in ("rustchain", "numpy"))
    assert {n for n in own if n.startswith("rustchain")} == {"rustchain", "rustchain._rustchain"}
    assert len(own) < len(numpy) / 4
    assert "numpy" not in own


def test_type_checkers_see_the_public_names():
    tree = ast.parse(Path(rc.__file__).read_text("utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = [each for node in block.body for each in node.names]
    assert all(each.name == each.asname for each in seen)
    assert sorted(each.name for each in seen) == sorted(dir(rc))


def test_figures_of_many_runs_need_no_import_of_their_own():
    assert python("import rustchain as rc; print(rc.plot.draw_loss_map.__name__)") == (
        "draw_loss_map\n"
    )


def test_json_and_drive_files_are_read_before_any_other_name_is_used(tmp_path):
    """Each class is found, though its module is not imported yet."""
    scene = rc.Scene(rc.paper_drive(), rc.Johnson(friction=rc.Coulomb(0.1)))
    script = "import sys, rustchain as rc; print(rc.Material.from_json(sys.argv[1]) == rc.Scene(\n"
    script += "rc.paper_drive(), rc.Johnson(friction=rc.Coulomb(0.1))))"
    assert python(script, scene.to_json()) == "True\n"
    path = tmp_path / "drive.toml"
    path.write_text(
        '[drive]\ntype = "paper_drive"\n[[run.stop]]\ntype = "JointForceAbove"\nforce = 1'
    )
    script = "import sys, rustchain as rc; print(rc.load_scene(sys.argv[1]).name)"
    assert python(script, path) == "paper\n"


def test_json_of_a_type_that_is_none_is_refused():
    with pytest.raises(rc.InvalidInput, match=r"type = 'Sproket': is no description.*'Sprocket'"):
        rc.ChainDrive.from_json('{"type": "Sproket"}')


def test_all_public_names_are_there():
    assert all(hasattr(rc, name) for name in rc.__all__)


def test_the_instruction_set_has_a_name():
    assert rc.instruction_set() in {"avx512", "avx2", "neon", "plain"}


def test_a_keyword_and_its_other_name_are_not_given_together():
    told = "got 'min_impact_velocity' twice, once by its other name 'min_approach_speed'"
    with pytest.raises(TypeError, match=told):
        rc.Simulation(rc.paper_drive(), min_approach_speed=1e-3, min_impact_velocity=1e-3)
