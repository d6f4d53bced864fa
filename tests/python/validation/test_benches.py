"""Options of the benchmark scripts: a wrong one ends with its name, before anything runs."""

import os
import subprocess
import sys

import pytest

import numpy_reference
import pages
import rustchain as rc
from provenance import ROOT, provenance
from work_precision import peers

SCRIPTS = (
    "exudyn_validation",
    "features",
    "ideal_drive",
    "ideal_drive_peer",
    "lanes_of_drives",
    "mechanism_peers",
    "numpy_reference",
    "practical",
    "robustness",
    "work_precision",
)


def call(script, *options):
    """Return the exit status of a script and the last line that it prints."""
    done = subprocess.run(
        [sys.executable, "-P", ROOT / "benches" / f"{script}.py", *options],
        capture_output=True,
        encoding="utf-8",
        check=False,
        timeout=60.0,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "COLUMNS": "100"},
    )
    return done.returncode, done.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize("script", SCRIPTS)
def test_an_option_that_does_not_exist_ends_the_script(script):
    status, message = call(script, "--tset")
    assert status == 2
    assert message == f"{script}.py: error: unrecognized arguments: --tset"


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("features --write --test", "error: --write needs all"),
        ("practical --write --test", "error: --write needs all"),
        ("robustness --write --test", "error: --write needs all"),
        ("practical --only nothing", "error: --only 'nothing': no such scene; one of "),
        ("robustness --only nothing", "error: --only 'nothing': no such scene; one of "),
        ("work_precision --only nothing", "error: --only 'nothing': no such scene; one of "),
        ("robustness --write --accuracy 1e-9", "needs the default solver"),
        ("robustness --accuracy -1", "Solver.accuracy"),
        ("work_precision --redraw --only long", "--redraw runs nothing"),
    ],
)
def test_options_that_exclude_each_other_end_the_script(command, told):
    status, message = call(*command.split())
    assert status == 2
    assert told in message


def test_other_solvers_that_are_missing_are_named_with_the_remedy(monkeypatch, tmp_path):
    monkeypatch.setattr(peers, "HERE", tmp_path)
    with pytest.raises(SystemExit, match="is missing; `make reference-solvers`"):
        peers.load()


def test_a_page_without_marks_is_refused():
    page = "# Page\n\n<!-- table -->\n\nold\n\n<!-- end of table -->\n"
    assert pages.put(page, "table", ["new"]) == page.replace("old", "new")
    with pytest.raises(SystemExit, match="no marks <!-- sweep --> and"):
        pages.put(page, "sweep", ["new"])


def test_a_measurement_has_its_machine_and_revision():
    assert f"instructions {rc.instruction_set()}, revision " in provenance()


def test_the_time_of_an_evaluation_is_that_of_a_whole_run():
    """It was the least of forty estimates from a few timed steps, which scatter by ten."""
    times = [numpy_reference.package_time(rc.paper_drive()) for _ in range(3)]
    assert max(times) < 3.0 * min(times)
