"""Export: the files of an FMU, and calls that are refused."""

import shutil
import zipfile
from dataclasses import replace
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu

import rustchain as rc
from command import rustchain
from fmi.master import opened
from rustchain.fmi import export


def test_fmpy_finds_no_problem(fmu):
    assert validate_fmu(str(fmu)) == []


@pytest.mark.parametrize("name", ["a\x01b", "\ufffe", "\ud800"])
def test_a_name_with_a_character_that_xml_cannot_contain_is_readable(name, drive, tmp_path):
    path = tmp_path / "drive.fmu"
    rc.export_fmu(replace(drive, name=name), path)
    assert "_" in fmpy.read_model_description(str(path)).modelName


def test_the_description_has_names_units_and_values_at_the_start(fmu, version, drive):
    description = fmpy.read_model_description(str(fmu))
    assert description.fmiVersion == version
    variables = {each.name: each for each in description.modelVariables}
    inputs = {name: each for name, each in variables.items() if each.causality == "input"}
    assert {name: (float(each.start), each.unit) for name, each in inputs.items()} == {
        "sprocket_1.set_speed": (12.566, "rad/s"),
        "sprocket_2.set_torque": (-2.0, "N.m"),
        "tensioner.set_force": (drive.check().tension_force, "N"),
    }
    outputs = [each.name for each in description.modelVariables if each.causality == "output"]
    assert outputs == [
        *(f"sprocket_{i}.{name}" for i in (1, 2) for name in ("angle", "speed", "torque")),
        "strand_upper.tension",
        "strand_lower.tension",
        "hinges.largest_force",
        "teeth.largest_force",
    ]
    capabilities = description.coSimulation
    assert capabilities.canGetAndSetFMUstate
    assert capabilities.canSerializeFMUstate
    assert capabilities.canHandleVariableCommunicationStepSize
    assert not capabilities.needsExecutionTool
    assert not capabilities.canBeInstantiatedOnlyOncePerProcess
    assert not capabilities.providesDirectionalDerivative


def test_an_fmu_begins_on_the_tooth_surfaces_of_a_static_start(tmp_path):
    hoist = rc.load_scene(Path(__file__).parents[3] / "examples" / "hoist_load.toml")
    scene = replace(hoist, force_law=rc.Hertz())
    rc.export_fmu(scene, tmp_path / "hoist.fmu")
    simulation = rc.Simulation(scene)
    with opened(tmp_path / "hoist.fmu") as master:
        master.initialize().step(0.0, 1e-5)
        (largest,) = master.get("teeth.largest_force")
    assert largest == pytest.approx(simulation.evaluate().tooth_force.max(), rel=0.01)


def test_equal_scenes_make_equal_files(drive, fmus, tmp_path):
    again = tmp_path / fmus["2.0"].name
    rc.export_fmu(rc.Scene(drive), again)
    assert again.read_bytes() == fmus["2.0"].read_bytes()


def test_the_library_is_without_python(library):
    content = library.read_bytes()
    assert b"fmi2DoStep" in content
    assert b"fmi3DoStep" in content
    assert b"PyObject" not in content


def test_an_fmu_has_the_chosen_inputs_and_outputs_alone(drive, tmp_path):
    path = tmp_path / "7-chosen.fmu"
    chosen = {"inputs": ["sprocket_2.set_torque"], "outputs": ["sprocket_2.speed"]}
    rc.export_fmu(drive, path, **chosen)
    assert validate_fmu(str(path)) == []
    names = [each.name for each in fmpy.read_model_description(str(path)).modelVariables]
    assert names == ["sprocket_2.set_torque", "sprocket_2.speed"]
    with zipfile.ZipFile(path) as archive:
        assert any("fmu_7_chosen" in name for name in archive.namelist())


@pytest.mark.parametrize(
    "chosen",
    [
        {"inputs": [], "outputs": ["sprocket_2.speed"]},
        {"inputs": ["sprocket_1.set_speed"], "outputs": []},
    ],
)
def test_inputs_alone_and_outputs_alone_are_valid(drive, tmp_path, version, chosen):
    path = tmp_path / "few.fmu"
    rc.export_fmu(drive, path, version=version, **chosen)
    assert validate_fmu(str(path)) == []


def test_all_kinds_of_drives_are_exported(tmp_path, version):
    """Three sprockets, bristles, rollers as bodies, film, guide, damaged teeth, open chains."""
    ring = rc.chain_drive(
        "ISO 08B",
        [
            rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(rc.Table([(0.0, 10.0), (1.0, 20.0)]))),
            rc.Sprocket(25, (0.3, 0.0), rc.AppliedTorque(-1.0)),
            rc.Sprocket(13, (0.15, -0.12)),
        ],
    )
    pair = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=20.0, rollers="bodies")
    rail = rc.GuideRail((0.5 * pair.sprockets[1].center[0], -0.053), (0.0, 1.0), 0.05)
    ends = (rc.AnchoredEnd((-0.16, -0.02), velocity=(0.0, -0.1)), rc.LoadedEnd(5.0))
    wheel = rc.Sprocket(17, motion=rc.PrescribedSpeed(8.0), damaged_teeth=[(3, 0.5)])
    hoists = [
        rc.open_chain("ANSI 40", ends, 60, [wheel], hinges=hinges)
        for hinges in ("clearance", "ideal")
    ]
    scenes = [
        rc.Scene(ring, rc.Johnson(friction=rc.LuGre(0.1, 0.1))),
        rc.Scene(rc.paper_drive(25.0), start="static"),
        rc.Scene(replace(pair, guides=[rail]), hinge_law=rc.Hertz(film=rc.LubricantFilm(0.1))),
        *map(rc.Scene, hoists),
    ]
    for scene in scenes:
        path = tmp_path / "drive.fmu"
        rc.export_fmu(scene, path, version=version)
        assert validate_fmu(str(path)) == []
        with opened(path) as master:
            master.initialize().step(0.0, 2e-4)
            simulation = rc.Simulation(scene)
            simulation.step_to(2e-4)
            first = simulation.body_names.index("sprocket_1")
            names = [f"sprocket_{i + 1}.angle" for i in range(len(scene.drive.sprockets))]
            assert (master.get(*names) == simulation.positions[first:][: len(names), 2]).all()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inputs": ["sprocket_3.set_speed"]}, "inputs: 'sprocket_3.set_speed' is not one"),
        ({"inputs": ["sprocket_1.set_torque"]}, "did you mean"),
        ({"outputs": ["sprocket_1.sped"]}, "did you mean 'sprocket_1.speed'"),
        ({"outputs": ["sprocket_1.speed"] * 2}, "is there twice"),
        ({"outputs": "sprocket_1.speed"}, "outputs"),
        ({"inputs": [], "outputs": []}, "at least one variable"),
        ({"version": "1.0"}, "version"),
        ({"path": "drive.zip"}, "expected the name of an FMU, drive.fmu"),
    ],
)
def test_wrong_arguments_are_refused(drive, tmp_path, change, message):
    path = tmp_path / change.pop("path", "drive.fmu")
    with pytest.raises(rc.InvalidInput, match=message):
        rc.export_fmu(drive, path, **change)
    assert not list(tmp_path.iterdir())


def test_mechanisms_are_refused(drive, tmp_path):
    with pytest.raises(rc.InvalidInput, match="a mechanism; expected a drive"):
        rc.export_fmu(rc.Scene(drive.to_mechanism()), tmp_path / "drive.fmu")


def test_without_the_library_the_error_says_what_to_do(drive, tmp_path, monkeypatch):
    monkeypatch.setattr(export, "__file__", str(tmp_path / "export.py"))
    with pytest.raises(rc.MissingExtra, match="make fmu"):
        rc.export_fmu(drive, tmp_path / "drive.fmu")


def test_the_command_exports_a_file_and_a_state(tmp_path, version):
    file = tmp_path / "my_drive.toml"
    rc.save_scene(rc.Scene(rc.paper_drive(25.0)), file)
    out = tmp_path / "new" / "drive.fmu"
    told = rustchain("fmu", file, "--fmi", version, "-o", out)
    assert told.exit_code == 0, told.output
    assert validate_fmu(str(out)) == []

    simulation = rc.Simulation(rc.paper_drive(25.0))
    simulation.step_to(1e-3)
    simulation.save_state(tmp_path / "state.npz")
    told = rustchain("fmu", tmp_path / "state.npz", "--fmi", version, "-o", out, "--json")
    assert told.exit_code == 0, told.output
    with opened(out) as master:
        master.initialize(1e-3).step(1e-3, 1e-3)
        simulation.step_to(1e-3 + 1e-3)
        assert master.get("sprocket_2.angle") == simulation.positions[-1, 2]

    for arguments, message in (
        (["papre"], "did you mean 'paper'"),
        (["paper", "--inputs", "sprocket_9.set_speed"], "sprocket_9.set_speed"),
        ([str(tmp_path / "state.npz"), "--set", "pretension=1"], "--set is for a drive"),
    ):
        told = rustchain("fmu", *arguments, "-o", tmp_path / "none.fmu")
        assert told.exit_code == 1
        assert message in told.output
        assert "Traceback" not in told.output
    told = rustchain("fmu", "paper", "--fmi", 4, "-o", tmp_path / "none.fmu")
    assert told.exit_code == 2
    assert told.output == "error: --fmi = 4: expected 2.0 or 3.0\n"


def test_a_scene_of_another_fmu_is_refused(fmu, version, tmp_path):
    with pytest.raises(Exception, match="nstantiate"), opened(fmu, token="{another}"):
        pass
    damaged = tmp_path / "drive.fmu"
    shutil.copy(fmu, damaged)
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(damaged, "w") as copy:
        for name in archive.namelist():
            content = archive.read(name)
            if name.endswith("scene.bin"):
                content = content[:100] + bytes([content[100] ^ 1]) + content[101:]
            copy.writestr(name, content)
    with pytest.raises(Exception, match="nstantiate"), opened(damaged):
        pass
