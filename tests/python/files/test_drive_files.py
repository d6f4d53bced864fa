"""Drive files: all that a script can describe, and errors that say file, line, key and remedy."""

import dataclasses
import inspect
import runpy
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc
from command import rustchain
from drive_files import EXAMPLE, changed, written
from rustchain.description.base import Description
from rustchain.files.scene import SceneFile

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "reference" / "files.md").read_text(encoding="utf-8")


def test_the_example_is_the_drive_of_the_script_that_says_the_same():
    chain = dataclasses.replace(rc.catalogue_chain("ANSI 40", 78), elongation=0.002)
    curve = [(0.0, 0.0), (5.0, -1.0), (10.0, -3.0)]
    drive = rc.chain_drive(
        chain,
        [
            rc.Sprocket(17, motion=rc.PrescribedSpeed([(0.0, 10.0), (0.02, 12.566)])),
            rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(0.0, curve=curve), load_inertia=2e-3),
            rc.Sprocket(13, (0.18, -0.005), side="outside"),
        ],
        name="three shafts",
        adjust=3,
    )
    scene = rc.Scene(drive, rc.Hertz(damping="flores"), solver=rc.Solver(accuracy=1e-9))
    assert rc.load_scene(EXAMPLE) == scene
    file = SceneFile.read(EXAMPLE)
    assert file.scene == scene
    assert file.run == {
        "duration": 0.02,
        "report_step": 1e-4,
        "stop": [rc.ToothForceAbove(5000.0)],
    }
    assert file.out == EXAMPLE.parent / "three_shafts.nc"


def test_the_example_runs_from_the_command_line_and_from_python(tmp_path):
    done = rustchain("run", EXAMPLE, "--duration", 2e-3, "--out", tmp_path / "run.nc")
    assert done.exit_code == 0, done.output
    result = rc.load_result(tmp_path / "run.nc")
    file = SceneFile.read(EXAMPLE)
    assert result.scene == file.scene
    assert len(result.time) == 21
    again = file.changed({}, {}, {"duration": 2e-3, "progress": False})
    same = again.run_simulation(again.simulate())
    np.testing.assert_array_equal(same.final_positions, result.final_positions)


COUNTED = """
[drive]
type = "{maker}"
{links}
[drive.chain]
type = "catalogue_chain"
name = "ANSI 40"
{own}
[[drive.sprockets]]
teeth = 17
[[drive.sprockets]]
teeth = 25
center = [0.4, 0.0]
"""


def test_a_chain_in_a_table_has_the_links_of_its_drive(tmp_path):
    def links(given):
        text = COUNTED.format(maker="chain_drive", links=given, own="seed = 3")
        return rc.load_scene(written(tmp_path, text)).drive.chain

    def worn(given, elongations):
        own = f"elongation = {elongations}"
        text = COUNTED.format(maker="chain_drive", links=given, own=own)
        return rc.load_scene(written(tmp_path, text)).drive.chain

    counted = rc.chain_drive("ANSI 40", [rc.Sprocket(17), rc.Sprocket(25, (0.4, 0.0))]).chain
    fitting = [1e-3 * (k % 2) for k in range(counted.links)]
    assert worn("", fitting).elongation == tuple(fitting)
    with pytest.raises(rc.InvalidInput, match=f"elongation.*{counted.links}"):
        worn("", fitting[2:])
    assert links("").links == counted.links != 100
    assert links("").seed == 3
    assert links("links = 90").links == 90


@pytest.mark.parametrize(
    ("maker", "links", "own", "expected"),
    [
        ("chain_drive", "", 84, "remove it, .* as drive.links; without it they are counted$"),
        ("chain_drive", "links = 84", 84, "remove it, .* as drive.links; without"),
        ("open_chain", "links = 84", 84, "remove it, and give the drive's number as drive.links$"),
    ],
)
def test_links_of_a_chain_that_would_be_ignored_are_refused(tmp_path, maker, links, own, expected):
    path = written(tmp_path, COUNTED.format(maker=maker, links=links, own=f"links = {own}"))
    with pytest.raises(rc.InvalidInput, match=f"line 8, .*drive.chain.links: 84: .*{expected}"):
        rc.load_scene(path)


def test_a_name_that_the_catalogue_lacks_is_told_with_the_other_mistakes(tmp_path):
    text = COUNTED.partition("[drive.chain]")[0].format(maker="chain_drive", links="")
    text += 'chain = "ISO 08C"\nsprockets = [{ teth = 17 }]\n'
    with pytest.raises(rc.InvalidInput) as caught:
        rc.load_scene(written(tmp_path, text))
    first, second = str(caught.value).splitlines()
    assert "line 5, column 1: drive.chain: 'ISO 08C' is not in the catalogue; did you mean" in first
    assert "line 6" in second
    assert "teth: unknown key; did you mean 'teeth'?" in second


def test_links_of_both_tables_of_a_drive_of_two_sprockets_must_agree(tmp_path):
    text = """
[drive]
type = "two_sprocket_drive"
links = 60
[drive.chain]
name = "ANSI 40"
links = {own}
"""
    assert rc.load_scene(written(tmp_path, text.format(own=60))).drive.chain.links == 60
    with pytest.raises(rc.InvalidInput, match=r"line 7, .*drive.chain.links: 62: is not used"):
        rc.load_scene(written(tmp_path, text.format(own=62)))


def test_options_take_the_place_of_what_the_file_says(tmp_path):
    text = """
[drive]
type = "paper_drive"
[simulation]
hinge_law = { type = "Johnson" }
solver = { rtol = 1e-6, max_step = 5e-5 }
"""
    path, out = written(tmp_path, text), tmp_path / "run.nc"
    for options, law, tolerances in [
        ((), rc.Johnson(), (1e-6, None, 1e-10)),
        (("--law", "hertz"), rc.Hertz(), (1e-6, None, 1e-10)),
        (("--accuracy", 1e-9), rc.Johnson(), (None, None, 1e-9)),
        (("--atol", 1e-5), rc.Johnson(), (None, 1e-5, 1e-10)),
    ]:
        done = rustchain("run", path, "--duration", 2e-4, "--out", out, *options)
        assert done.exit_code == 0, done.output
        result = rc.load_result(out)
        assert result.hinge_law == law
        solver = result.solver
        assert (solver.rtol, solver.atol, solver.accuracy) == tolerances
        assert solver.max_step == 5e-5


def test_a_result_goes_where_the_file_says_relative_to_the_file(tmp_path):
    text = '[drive]\ntype = "paper_drive"\n[run]\nduration = 1e-3\nout = "results/run.nc"\n'
    done = rustchain("run", written(tmp_path, text), "--no-energy", "--record", "teeth")
    assert done.exit_code == 0, done.output
    assert rc.load_result(tmp_path / "results" / "run.nc").groups == ("teeth",)


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_direction_that_slackens_has_its_line(tmp_path, command):
    text = COUNTED.partition("[drive.chain]")[0].format(maker="chain_drive", links="")
    text += """chain = "ANSI 40"
sprockets = [{ teeth = 17 }, { teeth = 15, center = [0.2, -0.075] },
             { teeth = 25, center = [0.4, 0.0] }]
[drive.tensioner]
sprocket = 2
pretension = 80.0
direction = [0.0, 1.0]
[run]
duration = 1e-3
"""
    path = written(tmp_path, text)
    done = rustchain(command, path)
    assert done.exit_code == 1
    assert f"{path}, line 11, column 1: drive.tensioner: Tensioner.direction = " in done.output


def test_a_stop_condition_ends_a_run_well(tmp_path):
    path = changed(tmp_path, "force = 5000.0", "force = 1.0")
    done = rustchain("run", path)
    assert done.exit_code == 0, done.output
    assert "stopped at t = " in done.output
    assert rc.load_result(tmp_path / "three_shafts.nc").status == "stopped"


def test_check_shows_the_layout_and_refuses_what_would_not_run(tmp_path):
    done = rustchain("check", EXAMPLE)
    assert done.exit_code == 0, done.output
    assert "78 links of 12.7000 mm" in done.output
    assert "ready to run: 81 bodies, 0.02 s" in done.output
    path = changed(tmp_path, "[simulation]", "[simulation]\nmin_impact_velocity = -1.0")
    done = rustchain("check", path)
    assert done.exit_code == 1
    assert "drive.toml, line 33, column 1: simulation: min_impact_velocity = -1" in done.output


def test_a_table_of_a_spreadsheet_has_a_mark_at_its_beginning(tmp_path):
    path = changed(tmp_path, "duration = 0.02", "duration = 0.01")
    table = tmp_path / "machine.csv"
    plain = rc.load_scene(path).drive
    table.write_text(table.read_text(), encoding="utf-8-sig")
    assert rc.load_scene(path).drive == plain


TABLES = {
    "ToothLine": "{ start = [0.0, 0.0], end = [1e-3, 0.0] }",
    "ToothArc": "{ start = [0.0, 0.0], end = [1e-3, 1e-3], center = [0.0, 1e-3] }",
}
PIECES = f"pieces = [{TABLES['ToothLine']}, {TABLES['ToothArc']}]"
FORMS = {
    "AnsiTooth": 'tip = "cut"',
    "IsoTooth": 'gap = "maximum"',
    "StraightTooth": "flank_angle = 0.3",
    "CustomTooth": PIECES,
}
MOTIONS = {"PrescribedSpeed": "speed = 1.0", "AppliedTorque": "torque = 1.0", "Free": ""}
STOPS = {
    "HingeForceAbove": "force = 1.0",
    "ToothForceAbove": "force = 1.0",
    "StrandSlack": "",
    "ToothJump": "",
    "TimeReached": "time = 1.0",
}
LAWS = {law.__name__: "" for law in rc.ForceLaw.__subclasses__()} | {"Linear": "stiffness = 1e8"}
PLAIN = """
[drive]
type = "ChainDrive"
sprockets = [
  {{ teeth = 17, motion = {motion}, profile = {form} }},
  {{ teeth = 17, center = [0.1334, 0.0] }},
]
tensioner = {{ pretension = 25.0 }}

[drive.chain]
type = "Chain"
pitch = 0.0127
links = 38
inner = {{ mass = 6e-3, inertia = 2e-7 }}
outer = {{ mass = 8e-3, inertia = 1e-7 }}
hinge = {{ pin_radius = 2.22e-3, bore_radius = 2.245e-3, length = 0.011 }}
bushing_radius = 3.96875e-3
tooth_contact_length = 0.007
material = {{ restitution = 0.7 }}

[simulation]
hinge_law = {law}
solver = {{ accuracy = 1e-9 }}

[run]
stop = [{stop}]
"""


def filled(**chosen):
    chosen = {"motion": "Free", "form": "AnsiTooth", "law": "Hertz", "stop": "StrandSlack"} | chosen
    of = MOTIONS | FORMS | LAWS | STOPS
    tables = {
        place: ", ".join(filter(None, [f'{{ type = "{kind}"', of[kind]])) + " }"
        for place, kind in chosen.items()
    }
    return PLAIN.format(**tables)


@pytest.mark.parametrize(
    ("place", "kind"),
    [
        *(("motion", kind) for kind in MOTIONS),
        *(("form", kind) for kind in FORMS),
        *(("law", kind) for kind in LAWS),
        *(("stop", kind) for kind in STOPS),
    ],
)
def test_every_class_of_description_can_be_written(tmp_path, place, kind):
    path = written(tmp_path, filled(**{place: kind}))
    if kind == "CustomTooth":  # its pieces are read, and make no tooth
        with pytest.raises(rc.InvalidInput, match=r"CustomTooth\.pieces"):
            rc.load_scene(path)
        return
    file = SceneFile.read(path)
    scene = file.scene
    first = scene.drive.sprockets[0]
    found = {
        "motion": first.motion,
        "form": first.profile,
        "law": scene.hinge_law,
        "stop": file.run["stop"][0],
    }
    assert type(found[place]) is getattr(rc, kind)
    assert isinstance(scene.drive.chain.material, rc.Material)
    assert isinstance(scene.drive.tensioner, rc.Tensioner)


@pytest.mark.parametrize("ending", ["toml", "json"])
def test_a_written_scene_is_read_back_with_every_character_and_every_bit(tmp_path, ending):
    """DEL is the control character that TOML forbids and JSON takes."""
    drive = rc.two_sprocket_drive(teeth=(17, 25), links=60, speed=1.0 / 3.0, torque=-0.1 - 0.2)
    name = 'a\x7f\x01\t\n"b" \\ # \' \u2028 \u00e9'
    drive = dataclasses.replace(drive, name=name, gravity=(1e-300, -9.81 - 2e-15))
    undamped = rc.LankaraniNikravesh(damping=None)  # which is not the default
    scene = rc.Scene(drive, force_law=undamped)
    path = tmp_path / f"scene.{ending}"
    rc.save_scene(scene, path)
    assert rc.load_scene(path) == scene
    assert rc.load_scene(path).drive.name == name


def test_the_smallest_impact_velocity_has_its_former_name_too(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text('[drive]\ntype = "paper_drive"\n[simulation]\nmin_approach_speed = 2e-3\n')
    assert rc.load_scene(path).min_impact_velocity == 2e-3


def test_the_page_has_every_class_and_every_field():
    public = [getattr(rc, name) for name in rc.__all__]
    classes = [each for each in public if isinstance(each, type) and issubclass(each, Description)]
    parts = {
        *("Mechanism", "Scene", "LinearContact", "SurfaceContact", "HuntCrossley"),
        *("ForceLaw", "StopCondition"),
    }
    for kind in classes:
        if kind.__name__ in parts:
            continue
        assert f"`{kind.__name__}`" in PAGE, kind
        for field in dataclasses.fields(kind):
            assert f"`{field.name}`" in PAGE, (kind, field.name)
    for function in (rc.chain_drive, rc.two_sprocket_drive, rc.paper_drive, rc.catalogue_chain):
        for name in inspect.signature(function).parameters:
            assert f"`{name}`" in PAGE, (function, name)


def test_the_tables_of_the_page_are_those_that_its_script_writes():
    script = runpy.run_path(str(ROOT / "docs" / "reference" / "files_page.py"))
    assert PAGE.endswith(script["tables"]()), "run docs/reference/files_page.py"
