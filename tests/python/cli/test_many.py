"""The commands of many runs: what Python gives, tables, stores, failures counted, Ctrl-C."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy import stats

import rustchain as rc
from command import rustchain
from rustchain.files.scene import SceneFile
from rustchain.files.sweep import SweepFile, check_figures, measure_of
from rustchain.sweeps.axes import RUN_FIELDS, case_of, check_names
from rustchain.sweeps.cases import cases_of

GRID = """
drive = "paper"
measure = ["tension_upper", "tooth_force_largest"]
burn_in = 1e-3

[axes]
pretension = [0, 25]
"speed, rtol" = [[10.0, 1e-5], [12.0, 1e-6]]
force_law = [{ type = "Hertz" }, { type = "Johnson" }]

[run]
duration = 5e-3
"""

FAILING = """
drive = "paper"
measure = ["tension_upper"]
[[cases]]
"chain.material.elastic_modulus" = 1e300
[[cases]]
pretension = 25
[run]
duration = 5e-3
"""

FUNCTION = """
LIMIT = 0.0

def peak(result):
    return {"peak": float(result.peaks.tooth_force.max()), "high": bool(LIMIT < 1.0)}

def begin(result):
    return float(result.time[0])
"""


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sweep.toml").write_text(GRID)
    (tmp_path / "failing.toml").write_text(FAILING)
    (tmp_path / "measures.py").write_text(FUNCTION)


def of_python(**keywords):
    def measure(result):
        found = result.summary(start=1e-3)
        return {name: found[name] for name in ("tension_upper", "tooth_force_largest")}

    axes = {
        "pretension": [0, 25],
        ("speed", "rtol"): [(10.0, 1e-5), (12.0, 1e-6)],
        "force_law": [rc.Hertz(), rc.Johnson()],
    }
    return rc.sweep(rc.paper_drive(), axes, measure, duration=5e-3, progress=False, **keywords)


def test_a_sweep_file_gives_the_numbers_of_the_same_call_in_python():
    expected = of_python().to_pandas()
    for arguments in ((), ("--executor", "threads:2", "--out", "other.csv")):
        done = rustchain("sweep", "sweep.toml", *arguments)
        assert done.exit_code == 0, done.output
        assert "8 of 8 cases finished, 0 failed: " in done.output
    for name in ("sweep.csv", "other.csv"):
        table = pd.read_csv(name, index_col="case")
        assert list(table.columns) == list(expected.columns)
        for column in expected:
            assert list(table[column]) == list(expected[column])
    done = rustchain("sweep", "sweep.toml", "--out", "new/table.nc", "--set", "rtol=1e-7", "--json")
    assert done.exit_code == 2
    assert "--set: 'rtol' is varied by the sweep file" in done.output
    done = rustchain("sweep", "sweep.toml", "--out", "new/table.nc", "--json")
    told = json.loads(done.stdout)
    assert (told["finished"], told["failed"], told["file"]) == (8, 0, "new/table.nc")
    data = xr.load_dataset("new/table.nc", engine="h5netcdf")
    assert dict(data.sizes) == {"pretension": 2, "sample": 2, "force_law": 2}
    np.testing.assert_array_equal(
        data["tension_upper"].to_numpy().ravel(), expected["tension_upper"]
    )


def test_a_store_is_gone_on_with_and_other_settings_are_other_cases():
    written = []
    for setting in ([], [], ["--set", "chain.material.restitution=0.5"]):
        done = rustchain("sweep", "sweep.toml", "--store", "runs", *setting)
        assert done.exit_code == 0, done.output
        written.append({path: path.stat().st_mtime_ns for path in Path("runs").iterdir()})
    assert written[0] == written[1]
    assert [len(files) for files in written] == [8, 8, 16]


def test_the_error_of_a_function_is_told_with_its_line(tmp_path):
    (tmp_path / "measures.py").write_text("def peak(result):\n    found = {}\n    found['peak']\n")
    (tmp_path / "short.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:peak"\n[axes]\nduration = [1e-3]\n'
    )
    for executor in ("threads", "threads", "processes:1"):
        store = ("--store", "runs") if executor == "threads" else ()
        done = rustchain("sweep", "short.toml", *store, "--executor", executor)
        assert done.exit_code == 3
        assert "{'duration': 0.001}: KeyError: 'peak' (measures.py, line 3)" in done.output
        assert pd.read_csv("short.csv")["error"][0] == "KeyError: 'peak' (measures.py, line 3)"


def test_a_store_finds_the_same_function_in_another_folder(tmp_path, monkeypatch):
    text = 'drive = "paper"\nmeasure = "measures.py:peak"\n[axes]\nduration = [1e-3]\n'
    for folder, function in (("one", FUNCTION), ("two", FUNCTION), ("two", FUNCTION + "\n")):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "short.toml").write_text(text)
        (tmp_path / folder / "measures.py").write_text(function)
        monkeypatch.chdir(tmp_path / folder)
        done = rustchain("sweep", f"../{folder}/short.toml", "--store", tmp_path / "runs")
        assert done.exit_code == 0, done.output
        same = function == FUNCTION
        assert len(list((tmp_path / "runs").iterdir())) == (1 if same else 2)


def test_samples_and_a_function_of_a_file(tmp_path):
    (tmp_path / "many.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:peak"\n'
        "[samples]\ncount = 4\nseed = 2\nmethod = 'sobol'\n[samples.distributions]\n"
        '"chain.material.elastic_modulus" = { uniform = [2e11, 1e10] }\n'
        '"chain.seed" = { randint = { low = 0, high = 1000 } }\n'
        "[axes]\nduration = [4e-3, 5e-3]\n"
    )
    done = rustchain("sweep", "many.toml", "--executor", "processes:2", "--store", "runs")
    assert done.exit_code == 0, done.output
    table = pd.read_csv("many.csv", index_col="case")
    laws = {
        "chain.material.elastic_modulus": stats.uniform(2e11, 1e10),
        "chain.seed": stats.randint(0, 1000),
    }
    expected = rc.sweep(
        rc.paper_drive(),
        {"duration": [4e-3, 5e-3]} | rc.samples(laws, 4, seed=2, method="sobol"),
        lambda result: {"peak": result.peaks.tooth_force.max(), "high": True},
        progress=False,
    ).to_pandas()
    assert list(table.columns) == list(expected.columns)
    assert (table == expected).all(axis=None)
    (tmp_path / "many.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:begin"\nburn_in = 2e-3\n'
        "[axes]\nduration = [4e-3]\n"
    )
    assert rustchain("sweep", "many.toml").exit_code == 0
    assert pd.read_csv("many.csv")["value"][0] == pytest.approx(2e-3)


def test_the_sweep_file_of_the_page_is_read(tmp_path):
    page = (Path(__file__).parents[3] / "docs" / "reference" / "files.md").read_text("utf-8")
    _, block = re.findall(r"^```toml\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    (tmp_path / "page.toml").write_text(block)
    rc.save_scene(rc.two_sprocket_drive("ANSI 40", links=60, torque=-1.0), "my_drive.toml")
    found = SweepFile.read(tmp_path / "page.toml", SceneFile.read)
    axes, cases = cases_of(found.axes)
    assert (len(axes), len(cases)) == (4, 3 * 2 * 2 * 64)
    check_names(found.scene.scene, dict.fromkeys(RUN_FIELDS), cases)
    scene, _ = case_of(found.scene.scene, dict.fromkeys(RUN_FIELDS), cases[-1])
    assert scene.force_law == rc.Johnson()
    assert scene.drive.sprockets[1].motion.torque == -1.0
    assert found.scene.run["duration"] == 0.5


def test_tables_and_stored_cases_are_no_results_and_their_readers_are_told():
    assert rustchain("sweep", "sweep.toml", "--out", "table.nc", "--store", "runs").exit_code == 0
    case = next(Path("runs").iterdir())
    done = rustchain("plot", "table.nc")
    assert "table.nc: is a table of a sweep or study, not a result: xarray.open" in done.output
    for command in ("plot", "report", "animate"):
        done = rustchain(command, case)
        assert done.exit_code == 1
        told = f"{case}: is a stored case of a sweep, without a result: load_sweep reads its folder"
        assert told in done.output


def test_failed_cases_are_counted_told_and_repeated_on_demand():
    for more in ((), (), ("--retry",)):
        done = rustchain("sweep", "failing.toml", "--store", "runs", *more)
        assert done.exit_code == 3
        assert "1 of 2 cases finished, 1 failed: failing.csv" in done.output
        assert (
            "case 0 {'chain.material.elastic_modulus': 1e+300}: SimulationError: step size"
            in done.output
        )
        assert "warning" not in done.output
        table = pd.read_csv("failing.csv", index_col="case")
        assert table["error"][0].startswith("SimulationError: step size fell to")
        assert pd.isna(table["error"][1])
        assert pd.isna(table["tension_upper"][0])
    assert rustchain("sweep", "failing.toml", "--store", "runs", "-o", "all.nc").exit_code == 3
    data = xr.load_dataset("all.nc", engine="h5netcdf")
    assert str(data["error"].values[0]).startswith("SimulationError: step size fell to")
    told = json.loads(rustchain("sweep", "failing.toml", "--json").stdout)
    assert told["errors"]["0"].startswith("SimulationError: step size fell")


@pytest.mark.filterwarnings("default")
def test_arrays_of_different_length_leave_the_table_complete(tmp_path):
    (tmp_path / "measures.py").write_text(
        "def times(result):\n    return {'time': result.time, 'end': result.time[-1]}\n"
    )
    (tmp_path / "times.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:times"\n[axes]\nduration = [1e-3, 2e-3]\n'
    )
    done = rustchain("sweep", "times.toml")
    assert done.exit_code == 0, done.output
    assert "warning: measure: 'time' has shape (11,) in one case and (21,)" in done.output
    table = pd.read_csv("times.csv")
    assert list(table["end"]) == [1e-3, 2e-3]
    assert list(table["time_20"].isna()) == [True, False]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('mesure = "x"', "line 2, column 1: mesure: unknown key; did you mean 'measure'?"),
        ("burn_in = true", "line 2, column 1: burn_in: True: must be a number"),
        ("axes = 3", "line 2, column 1: axes: 3: must be a table"),
        ("cases = [3]", "line 2, column 10: cases.1: 3: must be a table"),
        ("[axes]\nrtol = 1e-5", "line 3, column 1: axes.rtol: 1e-05: must be a list of values"),
        ("[axes]\npretensoin = [1]", "line 3, column 1: axes.pretensoin: axes: 'pretensoin' is no"),
        ('[axes]\nforce_law = [{type="Hert"}]', "column 15: axes.force_law.1.type: 'Hert' is not"),
        ('[axes]\n"rtol, atol" = [[1e-5]]', "line 3, column 1: axes.rtol, atol: axes[('rtol', "
         "'atol')]: got the row (1e-05,); expected 2 values"),
        ("[run]\nduraton = 1", "line 3, column 1: run.duraton: unknown key; did you mean"),
        ("[samples]\ncount = 2", "samples: 'distributions' is missing"),
        ("[samples]\ncount = 2\nmethod='sobl'\n[samples.distributions]\nrtol={norm=[1,2]}",
         "did you mean 'sobol'"),
        ("[samples]\ncount = 2\n[samples.distributions]\nrtol={nrm=[1,2]}",
         "line 5, column 7: samples.distributions.rtol.nrm: is no distribution; did you mean"),
        ("[samples]\ncount = 2\n[samples.distributions]\nrtol=3", "such as { norm = [mean, dev"),
        ("[samples]\ncount = 2\ndistributions = 3", "error: bad.toml, line 4, column 1: samples."),
        *[(f"[samples]\ncount=2\n[samples.distributions]\nrtol={{norm={given}}}", f"norm: {told}: "
           "expected a list or table of numbers: loc, scale\n")
          for given, told in (("3", "3"), ("[1, 2, 3]", "[1, 2, 3]"), ("['a', 1]", "['a', 1]"),
                              ("{mean=3}", "{'mean': 3}"), ("[true]", "[True]"))],
        ("[samples]\ncount=2\n[samples.distributions]\nrtol={triang={loc=1}}",
         "triang: {'loc': 1}: expected a list or table of numbers: c, loc, scale"),
        ("[samples]\ncount=2\n[samples.distributions]\nrtol={randint=[1, 9, 0, 1]}",
         "expected a list or table of numbers: low, high, loc\n"),
        ("[samples]\ncount=2\n[samples.distributions]\nrtol={norm=[1, -1]}",
         "line 2, column 2: samples: 'rtol' has values that are not finite"),
        ('measure = "measures.py:peek"\n[axes]\nrtol=[1]', "has no function 'peek'; did you mean"),
        ('measure = "none.py:peak"\n[axes]\nrtol=[1]', "measure: none.py: cannot be read"),
        ("measure = 3\n[axes]\nrtol=[1]", "measure = 3: expected names of figures"),
        ('measure = ["tension_upper", "efficiensy"]\n[axes]\nrtol=[1]',
         "line 2, column 1: measure: 'efficiensy' is no figure of a summary; did you mean "
         "'efficiency'?"),
        ("burn_in = 1.0", "has no axes, samples or cases; expected one of them"),
        ("[axes]\npretension=[1]\nbogus=[1]", "line 4, column 1: axes.bogus: axes: 'bogus' is no"),
        ("cases=[{rtol=1e-5, bogus=1}]\n[run]\nduration=1", "column 20: cases.1.bogus: axes"),
        ("[axes]\nrtol=[1]\n[samples]\ncount=2\n[samples.distributions]\nbogus={norm=[1,2]}",
         "line 7, column 1: samples.distributions.bogus: axes: 'bogus' is no parameter"),
        ('[axes]\nspeed=[1]\n"rtol, bogus"=[[1, 2]]',
         "line 4, column 1: axes.rtol, bogus: axes: 'bogus' is no parameter"),
        ("[axes]\nspeed=[1]\npretension=[-1]",
         "line 4, column 1: axes.pretension: Tensioner.pretension = -1: must be"),
        ("[axes]\nspeed=[1]\n[run]\nduration=-1", "line 5, column 1: run.duration: duration = -1"),
        ("[axes]\nrtol=[1]\n[[cases]]\nrtol=1", "cases: stand in place of axes and samples"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_sweep_file_is_told_with_its_place(text, said, tmp_path):
    (tmp_path / "bad.toml").write_text(f'drive = "paper"\n{text}\n')
    done = rustchain("sweep", "bad.toml")
    assert done.exit_code == 1
    assert said in done.output
    assert "Traceback" not in done.output


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("burn_in = 2.0\n[axes]\nrtol=[1e-5]", "line 2, column 1: burn_in: 2.0: must be from 0"),
        ("burn_in = -1\n[axes]\nrtol=[1e-5]", "burn_in: -1: must be from 0 to less than the dur"),
        ("burn_in = nan\n[axes]\nrtol=[1e-5]", "burn_in: nan: must be from 0"),
        ("burn_in = 0.1\n[axes]\nduration=[0.1, 1.0]", "less than the duration, 0.1 s"),
        ('burn_in = 0.1\n[axes]\n"duration, rtol"=[[0.1, 1e-5]]', "less than the duration, 0.1 s"),
        ('measure = "transmission_error_3"\n[axes]\nrtol=[1e-5]',
         "line 2, column 1: measure: 'transmission_error_3' is no figure of this drive; did you"),
        ('measure = "ripple_1"\n[axes]\nrtol=[1e-5]', "'ripple_1' is no figure of this drive; did"),
        ('measure = ["tension_upper-1"]\n[axes]\nrtol=[1e-5]',
         "'tension_upper-1' is no figure of this drive"),
    ],
)  # fmt: skip
def test_what_no_case_can_be_measured_by_is_told_before_a_run(text, said, tmp_path, monkeypatch):
    monkeypatch.setattr("rustchain.sweeps.sweep.run_here", lambda *_: pytest.fail("it ran"))
    (tmp_path / "bad.toml").write_text(f'drive = "paper"\n{text}\n')
    done = rustchain("sweep", "bad.toml")
    assert done.exit_code == 1
    assert said in done.output
    if "burn_in" not in text:
        done = rustchain("study", "paper", "--measure", re.findall(r"'(\w.*?)' is", said)[0])
        assert "is no figure of this drive" in done.output


def test_a_burn_in_counts_against_the_durations_of_the_cases(tmp_path):
    (tmp_path / "short.toml").write_text(
        'drive = "paper"\nmeasure = "tension_upper"\nburn_in = 2e-3\n'
        "[axes]\nduration = [4e-3]\n[run]\nduration = 1e-3\n"
    )
    done = rustchain("sweep", "short.toml")
    assert done.exit_code == 0, done.output
    found = rc.study(
        rc.paper_drive(), runs=2, duration=1e-3, burn_in=2e-3, axes={"duration": [4e-3]},
        progress=False,
    )  # fmt: skip
    assert found.sweep.success


def test_each_figure_of_a_summary_is_known_before_a_run():
    four = [rc.Sprocket(17, center) for center in ((0, 0), (0.3, 0), (0.3, 0.3), (0, 0.3))]
    four[0] = replace(four[0], motion=rc.PrescribedSpeed(12.0))
    four[1] = replace(four[1], motion=rc.AppliedTorque(-0.1))
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(1.0))
    hung = rc.open_chain("ANSI 40", ends, 30, [rc.Sprocket(17, (0.1, 0.1))])
    drives = [rc.paper_drive(25.0), rc.chain_drive("ANSI 40", four, adjust=3), hung]
    mechanism = rc.paper_drive().to_mechanism()
    for system in (*drives, rc.paper_drive(hinges="ideal"), mechanism):
        names = list(rc.Simulation(system).run(5e-3, progress=False).summary())
        measure = measure_of(names, 0.0, Path())
        assert measure.names == tuple(names)
        check_figures(measure, rc.Simulation(system).scene, ())


def test_named_figures_of_a_run_with_tooth_jumps_are_kept_but_for_those_of_a_seated_chain():
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, torque=-1.0, pretension=50.0)
    result = rc.Simulation(drive).run(2e-3, progress=False)
    measure = measure_of(["tension_upper", "efficiency", "transmission_error_2"], 0.0, Path())
    seated = measure(result)
    at = tuple(np.array([value]) for value in (1e-3, 2, -1))
    found = measure(replace(result, jumps=at))
    assert found["tension_upper"] == seated["tension_upper"]
    assert np.isnan([found["efficiency"], found["transmission_error_2"]]).all()


def test_several_mistakes_and_a_drive_that_is_missing_are_told_at_once(tmp_path):
    (tmp_path / "bad.toml").write_text('drive = "non.toml"\nmesure = 3\n[axes]\nrtol = 1\n')
    lines = rustchain("sweep", "bad.toml").output.splitlines()
    assert len(lines) == 3
    assert "drive: 'non.toml': is no file" in lines[0]
    (tmp_path / "bad.toml").write_text("[axes]\nrtol = [1e-5]\n")
    assert "'drive' is missing" in rustchain("sweep", "bad.toml").output
    told = rustchain("sweep", "none.toml").output
    assert "cannot be read" in told
    assert "give the path of a sweep file" in told


@pytest.mark.parametrize(
    ("executor", "said"),
    [
        ("procs", "--executor = 'procs': is none; did you mean 'processes'?"),
        ("threads:none", "expected a number of workers behind the colon"),
        ("processes:0", "expected a number of workers behind the colon"),
        ("dask", "has no address; expected dask:tcp://host:8786"),
    ],
)
def test_an_executor_that_is_none_is_told(executor, said):
    done = rustchain("sweep", "sweep.toml", "--executor", executor)
    assert done.exit_code == 2
    assert said in done.output


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("study", "paper", "--axis", "rtol=[1e-5]", "--axis", "rtol=[1e-4]"),
         "--axis: 'rtol' is there twice"),
        (("study", "paper", "--axis", "rtol=[1e-5]", "--set", "rtol=1e-4"),
         "--set: 'rtol' is varied by --axis; remove one of them"),
        (("study", "paper", "--axis", "pretension=0,25"), "pretension=[0,25]"),
        (("study", "paper", "--quiet"), "--quiet: leaves nothing of a study; give --out"),
        (("study", "paper", "--retry"), "--retry: runs stored cases again, and there is no store"),
        (("sweep", "sweep.toml", "--retry"), "--retry: runs stored cases again, and there is no"),
        (("sweep", "cases.toml", "--set", "rtol=1e-4"), "'rtol' is varied by the sweep file"),
    ],
)  # fmt: skip
def test_options_that_contradict_each_other_are_refused_before_a_run(
    arguments, said, tmp_path, monkeypatch
):
    monkeypatch.setattr("rustchain.sweeps.sweep.run_here", lambda *_: pytest.fail("it ran"))
    (tmp_path / "cases.toml").write_text('drive = "paper"\n[[cases]]\nrtol = 1e-5\n')
    done = rustchain(*arguments)
    assert done.exit_code == 2
    assert said in done.output


def test_a_table_of_another_kind_is_refused_before_anything_runs(monkeypatch):
    monkeypatch.setattr("rustchain.sweeps.sweep.run_here", lambda *_: pytest.fail("it ran"))
    done = rustchain("sweep", "sweep.toml", "--out", "table.xlsx")
    assert "tables are written as .csv or .nc; take table.csv" in done.output


def test_a_study_gives_the_statistics_of_python(tmp_path):
    arguments = ("study", "paper", "--runs", 3, "--duration", 6e-3, "--burn-in", 4e-3)
    done = rustchain(*arguments, "--axis", "pretension=[0, 25]", "--measure", "tension_upper",
                     "--measure", "tooth_force_p99", "--store", "runs", "--out", "study.csv",
                     "--json")  # fmt: skip
    assert done.exit_code == 0, done.output
    study = rc.study(
        rc.paper_drive(), runs=3, duration=6e-3, burn_in=4e-3, axes={"pretension": [0, 25]},
        progress=False,
    )  # fmt: skip
    rows = {(r["measure"], r["pretension"]): r for r in json.loads(done.stdout)["statistics"]}
    assert len(rows) == 4
    table = study.to_pandas()
    for key, row in rows.items():
        for name in ("mean", "low", "high", "count"):
            assert row[name] == table.loc[key, name]
    written = pd.read_csv("study.csv", index_col=["measure", "pretension"])
    assert written.loc[("tension_upper", 25), "mean"] == table.loc[("tension_upper", 25), "mean"]
    assert len(list((tmp_path / "runs").iterdir())) == 6
    shown = rustchain(*arguments, "--measure", "measures.py:peak", "--out", "study.nc")
    assert shown.exit_code == 0, shown.output
    assert re_row("peak", shown.output) is not None
    assert "peak" in xr.load_dataset("study.nc", engine="h5netcdf")
    wrong = rustchain(*arguments, "--measure", "tension_uper")
    assert wrong.exit_code == 1
    assert "did you mean 'tension_upper'" in wrong.output


def re_row(name, text):
    return next((line for line in text.splitlines() if line.startswith(name)), None)


@pytest.mark.parametrize("executor", ["threads", "processes:2"])
def test_ctrl_c_keeps_what_is_done_and_the_command_goes_on(executor, tmp_path):
    (tmp_path / "long.toml").write_text(
        'drive = "paper"\nmeasure = "measures.py:peak"\n[axes]\n'
        "duration = [1e-3, 2e-3, 3e-3, 1000.0]\n[run]\nreport_step = 1e-3\n"
    )
    called = [sys.executable, "-m", "rustchain", "sweep", "long.toml", "--store", "runs"]
    called += ["--executor", executor]
    code = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    code += f"import sys; sys.argv = {called[2:]!r}\nfrom rustchain.cli import main; main()"
    running = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    runs = tmp_path / "runs"
    while running.poll() is None and len(list(runs.glob("*.nc"))) < 3:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate()
    assert running.returncode == 130, err
    assert "interrupted: 3 of 4 cases finished, 0 failed: long.csv" in out
    assert "the same command goes on with what is in runs" in out
    assert "Traceback" not in err
    table = pd.read_csv("long.csv", index_col="case")
    assert list(table["peak"].isna()) == [False, False, False, True]
    (tmp_path / "long.toml").write_text(
        (tmp_path / "long.toml").read_text().replace("1000.0", "4e-3")
    )
    done = rustchain(*called[3:])
    assert "4 of 4 cases finished" in done.output
    assert len(list(runs.glob("*.nc"))) == 4


def interrupted(*_):
    raise KeyboardInterrupt
    yield


def test_an_interrupted_sweep_leaves_the_table_of_before(monkeypatch):
    assert rustchain("sweep", "sweep.toml").exit_code == 0
    before = Path("sweep.csv").read_bytes()
    monkeypatch.setattr("rustchain.sweeps.sweep.run_here", interrupted)
    done = rustchain("sweep", "sweep.toml")
    assert done.exit_code == 130
    assert "sweep.csv: is kept as it was" in done.output
    assert "interrupted: 0 of 8 cases finished, 0 failed: sweep.partial.csv" in done.output
    assert Path("sweep.csv").read_bytes() == before
    assert len(pd.read_csv("sweep.partial.csv")) == 8


def _runs(pid):
    """Return whether a process is there and has not ended."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="children are read from /proc")
def test_workers_end_with_a_command_that_is_killed_and_it_goes_on(tmp_path):
    file = tmp_path / "long.toml"
    file.write_text(
        'drive = "paper"\nmeasure = "measures.py:peak"\n[axes]\n'
        "duration = [1e-3, 1000.0]\n[run]\nreport_step = 1e-3\n"
    )
    called = ["sweep", "long.toml", "--store", "runs", "--executor", "processes:2"]
    running = subprocess.Popen(
        [sys.executable, "-m", "rustchain", *called], stderr=subprocess.DEVNULL
    )
    while running.poll() is None and not list((tmp_path / "runs").glob("*.nc")):
        time.sleep(0.05)
    tasks = Path(f"/proc/{running.pid}/task").glob("*/children")
    workers = [int(pid) for task in tasks for pid in task.read_text().split()]
    assert len(workers) >= 2
    running.kill()
    running.wait()
    end = time.monotonic() + 30.0
    while any(map(_runs, workers)) and time.monotonic() < end:
        time.sleep(0.1)
    left = [pid for pid in workers if _runs(pid)]
    for pid in left:
        os.kill(pid, signal.SIGKILL)
    assert left == []
    file.write_text(file.read_text().replace("1000.0", "2e-3"))
    assert "2 of 2 cases finished" in rustchain(*called).output
