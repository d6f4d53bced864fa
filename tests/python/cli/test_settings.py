"""Options that commands share: --set, --json, --quiet; exit codes, completion, figures by name."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import rustchain as rc
from command import rustchain
from rustchain.cli.app import app
from rustchain.cli.common import scene_file
from rustchain.plot import Plots

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "examples" / "three_shafts.toml"
COMMANDS = {
    "run",
    "check",
    "plot",
    "animate",
    "report",
    "sweep",
    "study",
    "catalogue",
    "schema",
    "fmu",
}


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.nc"
    done = rustchain("run", "paper", "--duration", 2e-3, "--out", path, "--record", "hinges")
    assert done.exit_code == 0, done.output
    return path


def test_any_field_is_set_by_its_name_in_a_sweep(tmp_path):
    path = tmp_path / "run.nc"
    done = rustchain("run", "paper", "--out", path, *_options(COMPLETE))
    assert done.exit_code == 0, done.output
    result = rc.load_result(path)
    drive = result.drive
    assert (drive.tensioner.pretension, drive.chain.material.restitution) == (25, 0.5)
    assert (drive.sprockets[1].mass, drive.gravity) == (2.0, (0.0, -1.62))
    assert drive.name == "the moon's drive"
    assert result.scene.force_law == rc.Hertz(damping="flores")
    assert (result.scene.start, result.scene.tooth_law) is not None
    assert result.scene.start == "static"
    assert result.solver.rtol == 1e-6
    assert (len(result.time), set(result.groups)) == (3, {"teeth"})


COMPLETE = [
    "duration=1e-3", "report_step=5e-4", "pretension=25", "chain.material.restitution=0.5",
    "sprockets.2.mass=2", "gravity=[0.0, -1.62]", "rtol=1e-6", "start=static",
    "force_law={type='Hertz', damping='flores'}", "record=['teeth']", "tooth_law=none",
    "name=the moon's drive",
]  # fmt: skip


def _options(settings):
    return [part for setting in settings for part in ("--set", setting)]


@pytest.mark.parametrize(
    ("setting", "field", "value"),
    [
        ("chain=ISO 08B", "chain", rc.catalogue_chain("ISO 08B", 38)),
        ('chain="ISO 08B"', "chain", rc.catalogue_chain("ISO 08B", 38)),
        (
            "chain={type='catalogue_chain', name='ISO 08B', links=38}",
            "chain",
            rc.catalogue_chain("ISO 08B", 38),
        ),
        ("force_law=Hertz", "force_law", rc.Hertz()),
        ("hinge_law=Johnson", "hinge_law", rc.Johnson()),
        ("name=Hertz", "name", "Hertz"),
        ("name=", "name", ""),
    ],
)
def test_a_chain_and_a_law_are_set_by_their_names(setting, field, value):
    scene = scene_file("paper", [setting]).scene
    assert getattr(scene.drive if field in ("chain", "name") else scene, field) == value


def test_settings_take_the_place_of_what_a_file_says():
    done = rustchain("check", EXAMPLE, "--set", "sprockets.2.teeth=23", "--set", "duration=0.5",
                     "--json")  # fmt: skip
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["report"]["teeth"] == [17, 23, 13]
    assert told["duration"] == 0.5
    assert len(told["bodies"]) == 81


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("pretensoin=3", "--set: 'pretensoin' is no parameter; did you mean 'pretension'?"),
        ("chain.pich=3", "did you mean 'chain.pitch'?"),
        ("restitution=3", "did you mean 'chain.material.restitution'?"),
        ("pretension", "--set pretension: is no setting; expected name=value"),
        ("=3", "expected name=value"),
        (
            "force_law={type='Hertzz'}",
            "force_law.type: 'Hertzz' is not known; did you mean 'Hertz'",
        ),
        ("force_law={type='Hertz', dampin='a'}", "force_law.dampin: unknown key; did you"),
        ("chain.links=abc", "Chain.links = 'abc': must be a whole number"),
        ("start=statc", "start = 'statc': must be 'generated' or 'static'"),
        ("tensioner.damping=1", "cannot be changed, for drive.tensioner is None"),
        ("sprockets.4.teeth=20", "sprockets.4: does not exist; expected a number from 1 to 2"),
        ("guides.1.length=0.1", "guides.1: does not exist, for drive.guides is empty"),
        ("sprockets.1.motion.torque=1", "motion.torque: does not exist; known: 'speed'"),
        *[
            (
                f"{name}=-3",
                "drive.sprockets.2.motion is a Free; set the whole of it, "
                "sprockets.2.motion={torque=-3}",
            )
            for name in ("torque", "sprockets.2.motion.torque")
        ],
        (
            "center_distance=0.3",
            "it is an argument of two_sprocket_drive, no field of the drive; change it in the "
            "drive file",
        ),
        ("record=[", "record = '[': is no value of TOML"),
        ("chain=ISO 8B", "chain: 'ISO 8B' is not in the catalogue; did you mean 'ISO 08B'?"),
        ("force_law=Linear", "--set: force_law: 'stiffness' is missing: it must be given"),
    ],
)
@pytest.mark.parametrize("command", ["run", "check", "study", "animate", "report"])
def test_a_setting_that_is_none_is_told_with_the_nearest_name(command, setting, said, tmp_path):
    done = rustchain(command, "paper", "--set", setting)
    assert done.exit_code == (2 if "name=value" in said else 1)
    assert said in done.output
    assert "Traceback" not in done.output


def test_a_setting_that_is_given_twice_is_told():
    done = rustchain("check", "paper", "--set", "speed=3", "--set", "speed=4")
    assert "--set: 'speed' is there twice; give it once" in done.output
    assert done.exit_code == 2


def test_each_command_says_its_exit_codes_and_has_help():
    listed = rustchain("--help").output
    for command in COMMANDS:
        assert re.search(rf"^  {command} ", listed, re.MULTILINE)
        said = " ".join(rustchain(command, "--help").output.split())
        assert "Exit codes: 0 done; 1 error; 2 wrong command line; 3 cases" in said
    assert {each.name or each.callback.__name__ for each in app.registered_commands} == COMMANDS
    assert rustchain("rum", "paper").exit_code == 2
    assert rustchain("run").exit_code == 2


@pytest.mark.parametrize(("columns", "widest"), [(70, 68), (200, 118)])
def test_help_is_as_wide_as_the_terminal_up_to_lines_that_can_be_read(columns, widest):
    called = [sys.executable, "-m", "rustchain", "study", "--help"]
    done = subprocess.run(
        called, capture_output=True, text=True, env=os.environ | {"COLUMNS": str(columns)}
    )
    assert widest - 12 < max(map(len, done.stdout.splitlines())) <= widest


def test_json_is_one_document_and_quiet_is_nothing(file, tmp_path):
    calls = {
        "run": ("run", "paper", "--duration", 1e-3, "--out", tmp_path / "a.nc"),
        "check": ("check", "paper"),
        "plot": ("plot", file, "--out", tmp_path),
        "study": ("study", "paper", "--runs", 2, "--duration", 4e-3, "--burn-in", 2e-3),
    }
    calls["study"] += ("--out", tmp_path / "study.csv")
    found = {}
    for name, call in calls.items():
        done = rustchain(*call, "--json")
        assert done.exit_code == 0, done.output
        found[name] = json.loads(done.stdout)
        quiet = rustchain(*call, "--quiet")
        assert (quiet.exit_code, quiet.output) == (0, "")
    assert found["run"]["status"] == "finished"
    assert found["run"]["rows"] == 11
    assert found["check"]["report"]["links"] == 38
    assert str(tmp_path / "tension.png") in found["plot"]["figures"]
    assert "not recorded" in found["plot"]["left_out"]["energy"]
    assert len(found["study"]["statistics"]) > 5
    sizes = json.loads(rustchain("catalogue", "--json").stdout)["chains"]
    assert [size["pitch"] for size in sizes if size["name"] == "ANSI 40"] == [0.0127]
    assert json.loads(rustchain("catalogue", "ansi40", "--json").stdout)["chain"]["pitch"] == 0.0127


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("rustchain ", COMMANDS),
        ("rustchain run pa", {"paper"}),
        ("rustchain run paper --set chain.material.rest", {"chain.material.restitution="}),
        ("rustchain run paper --set preten", {"pretension="}),
        ("rustchain check paper --set chain.hi", {"chain.hinge=", "chain.hinge."}),
        ("rustchain sweep sweep.toml --executor pro", {"processes"}),
    ],
)
def test_the_shell_completes_commands_drives_and_settings(typed, offered, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = typed.split(" ")
    environment = {
        "_RUSTCHAIN_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(words) - 1),
    }
    done = rustchain(prog_name="rustchain", env=environment)
    assert offered <= set(done.stdout.split()), done.output
    if len(offered) == 1:
        assert set(done.stdout.split()) == offered


def test_a_figure_that_is_named_must_be_drawn(file, tmp_path):
    done = rustchain("plot", file, "tension", "orbit", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert {path.name for path in tmp_path.iterdir()} == {"tension.png", "orbit.png"}
    done = rustchain("plot", file, "energy", "--out", tmp_path)
    assert done.exit_code == 1
    assert "the energy balance was not recorded" in done.output
    done = rustchain("plot", file, "tensoin", "--out", tmp_path)
    assert "did you mean 'tension'" in done.output


def pendulum():
    mechanism = rc.Mechanism()
    mechanism.add_body("rod", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "rod", at=(0.0, 0.0))
    return mechanism


def test_plot_swallows_no_error(file, tmp_path, monkeypatch):
    def broken(self, **_):
        raise RuntimeError("a defect")

    monkeypatch.setattr(Plots, "tension", broken)
    done = rustchain("plot", file, "--out", tmp_path)
    assert isinstance(done.exception, RuntimeError)
    empty = tmp_path / "empty.nc"
    assert rustchain("run", "paper", "--duration", 1e-3, "--record", "", "--out", empty).exit_code
    rc.Simulation(pendulum()).run(1e-3, record=("energy",), progress=False).save(empty)
    done = rustchain("plot", empty, "motion", "--out", tmp_path)
    assert done.exit_code == 1
    assert "recorded" in done.output


def test_settings_reach_into_mechanisms(tmp_path):
    path = tmp_path / "pendulum.toml"
    rc.save_scene(rc.Scene(pendulum()), path)
    out = tmp_path / "run.nc"
    settings = ["--set", "bodies.1.mass=3", "--set", "gravity.2=-1.62", "--duration", "1e-3"]
    done = rustchain("run", path, *settings, "--out", out)
    assert done.exit_code == 0, done.output
    changed = rc.load_result(out).scene.system
    assert (changed.bodies[0].mass, changed.gravity) == (3.0, (0.0, -1.62))
    done = rustchain("check", path, "--set", "bodies.1.mas=3")
    assert "did you mean 'bodies.1.mass'?" in done.output
    done = rustchain("check", path, "--set", "simulation.start=static")
    assert "'simulation.start' is no parameter; did you mean 'start'?" in done.output


def test_plot_draws_what_a_mechanism_has(tmp_path):
    rc.Simulation(pendulum()).run(1e-2, progress=False).save(tmp_path / "run.nc")
    done = rustchain("plot", tmp_path / "run.nc", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    names = {path.name for path in tmp_path.glob("*.png")}
    assert {"motion.png", "paths.png", "energy.png"} <= names
    assert "contact_force.png: left out" in done.output
    done = rustchain("plot", tmp_path / "run.nc", "--hinges", "6")
    assert "a mechanism has none" in done.output


def test_a_result_without_bodies_cannot_be_animated(tmp_path):
    rustchain("run", "paper", "--duration", 1e-3, "--out", tmp_path / "run.nc")
    done = rustchain("animate", tmp_path / "run.nc", "--out", tmp_path / "run.gif")
    assert done.exit_code == 1
    assert "run.nc: bodies were not recorded; give the drive file" in done.output
    assert "--record hinges,teeth,sprockets,bodies,energy" in done.output


def test_a_drive_or_a_result_is_animated(tmp_path):
    path = tmp_path / "drive.gif"
    short = ("--fps", 10, "--slow-motion", 100, "--width", 200)
    done = rustchain("animate", "paper", "--duration", 4e-3, "--out", path, *short)
    assert done.exit_code == 0, done.output
    assert path.read_bytes()[:6] == b"GIF89a"
    run = tmp_path / "run.nc"
    rustchain("run", "paper", "--duration", 4e-3, "--record", "bodies", "--out", run)
    done = rustchain("animate", run, "--out", tmp_path / "run.gif", "--no-forces", *short)
    assert done.exit_code == 0, done.output
    done = rustchain("animate", run, "--set", "speed=3")
    assert "has been run; --set and --duration are for a drive" in done.output


def test_a_drive_or_a_result_is_reported(tmp_path):
    path = tmp_path / "drive.html"
    done = rustchain("report", "paper", "--duration", 4e-3, "-o", path, "--set", "pretension=25")
    assert done.exit_code == 0, done.output
    assert "<html" in path.read_text(encoding="utf-8")[:500]
    run = tmp_path / "run.nc"
    rustchain("run", "paper", "--duration", 4e-3, "--out", run)
    done = rustchain("report", run, "--out", tmp_path / "run.html", "--json")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["file"] == str(tmp_path / "run.html")
    done = rustchain("report", run, "--out", tmp_path / "run.pdf")
    assert done.exit_code == 1
    assert ".html" in done.output


def test_the_command_in_a_terminal_of_its_own(tmp_path):
    called = [sys.executable, "-m", "rustchain"]
    done = subprocess.run(
        [*called, "run", "paper", "--set", "duration=1e-3", "--json"],
        capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["file"] == "paper.nc"
    assert rc.load_result(tmp_path / "paper.nc").success
    wrong = subprocess.run(
        [*called, "check", "papre"], capture_output=True, text=True, cwd=tmp_path
    )
    assert (wrong.returncode, wrong.stdout) == (1, "")
    assert wrong.stderr.startswith("error: drive = 'papre': is no file")


def test_check_tells_each_warning_once_those_of_laws_too():
    settings = ("--set", "gravity=[0,-9810]", "--set", 'force_law={type="Linear",stiffness=0.001}')
    done = rustchain("check", "paper", *settings)
    assert done.output.count("gravity = 9810 m/s^2") == 1
    assert done.output.count("force_law.stiffness = 0.001 N/m") == 1
    found = json.loads(rustchain("check", "paper", "--json", *settings).stdout)
    assert [text.partition(" = ")[0] for text in found["report"]["warnings"]] == [
        "gravity",
        "force_law.stiffness",
    ]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("report", "paper", "-o", "report.pdf"), "ends in '.pdf'; expected .html"),
        (("report", "paper", "--breaking-load", -3), "report(breaking_load): got -3"),
        (("report", "paper", "--start", 3), "--start = 3: the run ends at 2 s"),
        (("animate", "paper", "-o", "film.avi"), "expected .gif, .mp4 or .html"),
        (("animate", "paper", "--fps", -1), "animate(fps): got -1.0"),
        (("animate", "paper", "--fps", 0.001), "a GIF has at least 0.00153 a second"),
        (("animate", "paper", "--camera", "sproket_1"), "did you mean 'sprocket_1'?"),
        (("animate", "paper", "--start", 3), "--start = 3: the run ends at 2 s"),
    ],
)
def test_what_follows_a_run_is_checked_before_it(arguments, told, tmp_path, monkeypatch):
    def run(*_, **__):
        raise AssertionError

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(rc.Simulation, "run", run)
    done = rustchain(*arguments)
    assert done.exit_code == 1, done.output
    assert told in " ".join(done.output.split())


def test_a_result_without_an_ending_is_known_by_its_content(file, tmp_path):
    for name in ("run", "run_25.5"):
        path = tmp_path / name
        path.write_bytes(Path(file).read_bytes())
        done = rustchain("report", path, "-o", tmp_path / "report.html")
        assert done.exit_code == 0, done.output


def test_numbers_of_hinges_for_figures_that_have_none_are_refused(file, tmp_path):
    done = rustchain("plot", file, "tension", "--hinges", "6", "--out", tmp_path)
    assert done.exit_code == 2
    assert "--hinges = 6: tension takes none; leave it out" in done.output


def test_plot_draws_guides_and_bodies_where_there_are_some(tmp_path):
    drive = rc.two_sprocket_drive("ANSI 40", (17, 17), links=38, speed=20.0, torque=-3.0)
    rail = rc.GuideRail((0.07, 0.0435), (0.0, -1.0), length=0.08)
    drive = replace(drive, guides=[rail], hinges="ideal")
    record = ("hinges", "teeth", "sprockets", "bodies", "energy")
    rc.Simulation(drive).run(0.02, record=record, progress=False).save(tmp_path / "run.nc")
    done = rustchain("plot", tmp_path / "run.nc", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    drawn = {path.stem for path in tmp_path.glob("*.png")}
    new = {"guide_loads", "joint_loads", "motion", "paths", "spectrum", "strand_motion"}
    assert new <= drawn, done.output


def test_a_quiet_check_prints_the_warnings_alone(tmp_path):
    sprockets = [
        rc.Sprocket(17, motion=rc.PrescribedSpeed(10.0)),
        rc.Sprocket(25, (0.3, 0.0), rc.AppliedTorque(-2.0)),
    ]
    drive = rc.chain_drive("ISO 08B", sprockets)
    (warning,) = drive.check().warnings
    rc.save_scene(rc.Scene(drive), tmp_path / "slack.toml")
    quiet = rustchain("check", tmp_path / "slack.toml", "--quiet")
    assert (quiet.exit_code, quiet.output) == (0, f"warning: {warning}\n")
