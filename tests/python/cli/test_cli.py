"""The command line: files and figures made, errors said in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import rustchain as rc
from command import rustchain
from cores import CoreAround, cores_within
from rustchain.cli import main
from rustchain.cli.common import LAWS


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "new" / "run.nc"
    done = rustchain(
        "run", "paper", "--duration", 2e-3, "--pretension", 25, "--law", "enhanced-cylinder",
        "--rtol", 1e-6, "--atol", 1e-6, "--report-step", 5e-4, "--record", "hinges,teeth,energy",
        "--out", path,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    return path


def test_a_run_leaves_a_file_with_all_that_was_asked_for(file):
    result = rc.load_result(file)
    assert result.success
    assert len(result.time) == 5
    assert result.drive == rc.paper_drive(pretension=25.0)
    assert result.hinge_law == rc.EnhancedCylinder()
    assert (result.solver.rtol, result.solver.atol) == (1e-6, 1e-6)
    assert set(result.groups) == {"hinges", "teeth", "energy"}


def test_plot_leaves_the_figures(file, tmp_path):
    done = rustchain("plot", file, "--out", tmp_path / "figures", "--hinges", "6,11")
    assert done.exit_code == 0, done.output
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    assert {"drive.png", "tooth_force.png", "orbit.png", "energy.png"} <= names


def test_plot_draws_the_polar_loads_of_the_teeth(tmp_path):
    rustchain("run", "paper", "--duration", 1e-2, "--out", tmp_path / "run.nc")
    done = rustchain("plot", tmp_path / "run.nc", "polar_tooth_loads", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert (tmp_path / "polar_tooth_loads.png").stat().st_size > 10_000


def test_plot_leaves_out_what_was_not_recorded(tmp_path):
    path = tmp_path / "run.nc"
    rustchain("run", "paper", "--duration", 1e-3, "--record", "teeth", "--out", path)
    done = rustchain("plot", path, "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert "hinges were not recorded" in done.output
    assert (tmp_path / "tooth_force.png").exists()
    assert not (tmp_path / "orbit.png").exists()


@pytest.mark.parametrize("name", LAWS)
def test_every_name_of_a_law_is_that_law(name):
    law = LAWS[name]
    plain = {
        "lankarani-nikravesh": ("hertz", "lankarani-nikravesh"),
        "enhanced-cylinder": ("enhanced-cylinder", "lankarani-nikravesh"),
        "enhanced-cylinder-2015": ("enhanced-cylinder", "lankarani-nikravesh"),
    }
    assert (law.elastic, law.damping) == plain.get(name, (name, None))
    assert getattr(law, "coefficients", "2010") == ("2015" if "2015" in name else "2010")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "papre"), "did you mean 'paper'"),
        (("run", "paper", "--record", "hinges,teth"), "did you mean 'teeth'"),
        (("run", "paper", "--duration", -1), "error: "),
        (("run", "paper", "--rtol", -1), "rtol"),
        (("run", "paper", "--law", "hertzz"), "error: --law: 'hertzz' is no law; did you mean"),
        (("plot", "no-such-file.nc"), "no-such-file.nc"),
    ],
)
def test_an_error_is_said_without_a_traceback(arguments, message, tmp_path):
    out = ("--out", tmp_path / "out") if arguments[0] == "run" else ()
    done = rustchain(*arguments, *out)
    assert done.exit_code in (1, 2)
    assert message in done.output
    assert "Traceback" not in done.output
    assert isinstance(done.exception, SystemExit)


def test_numbers_out_of_range_are_answered_with_the_range(file, tmp_path):
    done = rustchain("plot", file, "--out", tmp_path, "--hinges", "6,99")
    assert done.exit_code == 1
    assert "numbered 1 to 38" in done.output


def test_a_place_that_cannot_be_written_is_told_before_anything_runs(tmp_path, monkeypatch):
    def never(*arguments, **keywords):
        pytest.fail("it ran")

    monkeypatch.setattr(rc.Simulation, "run", never)
    taken = tmp_path / "taken"
    taken.write_text("a file")
    for out, message in (
        (taken / "run.nc", f"the folder {taken} cannot be made (there is a file of that name)"),
        (tmp_path / f"{'long' * 80}.nc", "cannot be written"),
        (tmp_path, "is a folder; name a file in it"),
    ):
        done = rustchain("run", "paper", "--out", out)
        assert done.exit_code == 1
        assert message in done.output
    done = rustchain("plot", taken, "--format", "doc")
    assert "--format = doc: expected png, pdf or svg" in done.output
    assert done.exit_code == 2


def test_a_look_at_the_place_leaves_what_is_there(tmp_path, monkeypatch):
    def fails(*arguments, **keywords):
        raise rc.InvalidInput("refused")

    monkeypatch.setattr(rc.Simulation, "run", fails)
    old = tmp_path / "old.nc"
    old.write_text("of before")
    for path in (old, tmp_path / "new.nc"):
        assert rustchain("run", "paper", "--out", path).exit_code == 1
    assert old.read_text() == "of before"
    assert not (tmp_path / "new.nc").exists()


def test_a_short_chain_is_drawn_without_a_word_on_its_hinges(tmp_path):
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=4)
    rc.Simulation(drive).run(1e-3, progress=False).save(tmp_path / "run.nc")
    done = rustchain("plot", tmp_path / "run.nc", "--out", tmp_path)
    assert done.exit_code == 0, done.output
    assert (tmp_path / "orbit.png").exists()


class Interrupted(CoreAround):
    """A core that is interrupted after a slice."""

    def advance(self, budget):
        self.core.advance(0.0)
        raise KeyboardInterrupt


def test_ctrl_c_saves_what_there_is(tmp_path):
    with cores_within(Interrupted):
        done = rustchain("run", "paper", "--out", tmp_path / "run.nc")
    assert done.exit_code == 130
    assert rc.load_result(tmp_path / "run.nc").status == "interrupted"


def test_a_stored_result_that_was_interrupted_is_shown_without_the_code_of_ctrl_c(tmp_path):
    out = tmp_path / "run.nc"
    with cores_within(Interrupted):
        rustchain("run", "paper", "--out", out, "--record", "hinges,teeth,sprockets,bodies,energy")
        ran = rustchain("report", "paper", "-o", tmp_path / "paper.html")
    shown = rustchain("report", out, "-o", tmp_path / "run.html")
    assert rc.load_result(out).status == "interrupted"
    assert (ran.exit_code, shown.exit_code) == (130, 0), shown.output


def test_a_run_is_written_to_the_name_of_its_drive_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rc.save_scene(rc.Scene(rc.paper_drive()), "my_drive.toml")
    for name, path in (("my_drive.toml", "my_drive.nc"), ("paper", "paper.nc")):
        for said in (False, True):
            done = rustchain("run", name, "--duration", 1e-3)
            assert done.exit_code == 0, done.output
            assert rc.load_result(path).success
            assert (f"{path}: was there and has been replaced" in done.output) == said
    done = rustchain("run", "paper", "--duration", -1)
    assert "replaced" not in done.output
    assert not (tmp_path / "run.nc").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="pipes end otherwise there")
@pytest.mark.parametrize("command", ["catalogue", "schema"])
def test_a_pipe_whose_reader_has_ended_is_no_error(command):
    reading, writing = os.pipe()
    os.close(reading)
    called = [sys.executable, "-m", "rustchain", command]
    done = subprocess.run(called, stdout=writing, stderr=subprocess.PIPE, text=True)
    os.close(writing)
    assert done.stderr == ""


@pytest.mark.skipif(sys.platform == "win32", reason="pipes end otherwise there")
def test_a_run_whose_output_has_no_reader_ends_well(tmp_path):
    out = tmp_path / "run.nc"
    out.write_text("of before")
    reading, writing = os.pipe()
    os.close(reading)
    called = [sys.executable, "-m", "rustchain", "run", "paper", "--duration", "1e-3", "-o", out]
    done = subprocess.run(called, stdout=writing, stderr=subprocess.PIPE, text=True)
    os.close(writing)
    assert done.returncode == 0, done.stderr
    assert rc.load_result(out).success


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="has no device that is full")
@pytest.mark.parametrize("asked", ["catalogue", "--help", "--version"])
def test_a_standard_output_that_is_full_is_told_by_name(asked):
    with Path("/dev/full").open("w") as full:
        called = [sys.executable, "-m", "rustchain", asked]
        done = subprocess.run(called, stdout=full, stderr=subprocess.PIPE, text=True)
    told = "error: the standard output cannot be written (No space left on device); write it"
    assert (done.returncode, done.stderr.startswith(told)) == (1, True), done.stderr
    assert done.stderr.count("\n") == 1


def test_ctrl_c_before_the_commands_are_imported_has_the_code_of_ctrl_c(monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.delitem(sys.modules, "rustchain.cli.app")
    monkeypatch.setattr("builtins.__import__", interrupt)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 130


@pytest.mark.parametrize(
    ("command", "option", "value", "said"),
    [
        ("run", "--duration", "nan", "--duration = NaN: must be a positive number in s"),
        ("run", "--report-step", "0", "--report-step = 0: must be a positive number in s"),
        ("run", "--memory", "1 cow", "--memory = '1 cow': expected a size such as"),
        ("run", "--record", "teth", "--record: 'teth' is no group; did you mean 'teeth'?"),
        ("run", "--set", "duration=-1", "--set duration = -1: must be a positive number in s"),
        ("check", "--set", "duration=-1", "--set duration = -1: must be a positive number in s"),
        ("report", "--duration", "nan", "--duration = NaN: must be a positive number in s"),
        ("animate", "--duration", "nan", "--duration = NaN: must be a positive number in s"),
        ("sweep", "--set", "duration=-1", "--set duration = -1: must be a positive number in s"),
    ],
)
def test_an_option_that_is_refused_is_told_in_place_of_a_line_of_the_file(
    command, option, value, said, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    rc.save_scene(rc.Scene(rc.paper_drive()), "drive.toml")
    run = '\n[run]\nduration = 1e-3\nreport_step = 1e-4\nmemory = "1 MB"\nrecord = ["teeth"]\n'
    with Path("drive.toml").open("a") as file:
        file.write(run)
    Path("sweep.toml").write_text(
        'drive = "drive.toml"\n[axes]\nspeed = [1]\n[run]\nduration = 1e-3'
    )
    name = "sweep.toml" if command == "sweep" else "drive.toml"
    done = rustchain(command, name, option, value)
    assert done.exit_code == 1
    assert f"error: {said}" in done.output


@pytest.mark.parametrize("name", ["drive.toml", "folder"])
def test_a_schema_replaces_no_drive_file(name, tmp_path):
    path = tmp_path / name
    (tmp_path / "folder").mkdir()
    (tmp_path / "drive.toml").write_text("[drive]")
    done = rustchain("schema", "-o", path)
    assert done.exit_code == 1
    assert "take drive.json" in done.output or "is a folder" in done.output
    assert (tmp_path / "drive.toml").read_text() == "[drive]"


def test_the_version_is_printed():
    assert rustchain("--version").output == f"rustchain {rc.__version__}\n"


def test_the_package_runs_as_a_module_like_the_command():
    said = subprocess.run(
        [sys.executable, "-m", "rustchain", "--version"], capture_output=True, text=True, check=True
    )
    assert said.stdout == f"rustchain {rc.__version__}\n"


@pytest.mark.parametrize(
    ("command", "kind"),
    [("run", "drive"), ("check", "drive"), ("fmu", "drive"), ("sweep", "sweep")],
)
def test_a_result_in_place_of_a_drive_is_called_so(file, tmp_path, monkeypatch, command, kind):
    monkeypatch.chdir(tmp_path)
    rc.load_result(file).save("saved.nc")
    for result in (file, "saved.nc"):  # streamed and not
        done = rustchain(command, result)
        assert done.exit_code == 1
        assert f"is a result file; expected a {kind} file; rustchain plot" in done.output


def test_a_drive_file_in_place_of_a_result_is_called_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rc.save_scene(rc.Scene(rc.paper_drive()), "my.toml")
    with pytest.raises(rc.InvalidInput, match="is a TOML file; expected a result"):
        rc.load_result("my.toml")
    done = rustchain("plot", "my.toml")
    assert done.exit_code == 1
    assert "my.toml: is a TOML file; expected a result, as rustchain run" in done.output


def test_the_usage_of_plot_names_its_figures_once():
    assert "[[" not in rustchain("plot", "--help").output
