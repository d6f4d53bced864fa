"""A notebook: drive, simulation, result and sweep, each figure once, and a progress widget."""

import os
import subprocess
import sys

import nbformat
import pytest

CELLS = {
    "drive": "import rustchain as rc\ndrive = rc.paper_drive(25.0)\ndrive",
    "report": "drive.check()",
    "result": "simulation = rc.Simulation(drive)\nresult = simulation.run(duration=5e-3)\nresult",
    "summary": "result.summary()",
    "figure": "result.plot.tension()",
    "axes": (
        "import matplotlib.pyplot as plt\n"
        "figure, ax = plt.subplots()\n"
        "drawn = result.plot.tension(ax=ax)"
    ),
    "figure after pyplot": "result.plot.tension()",
    "sweep": (
        "sweep = rc.sweep(drive, {'pretension': [25.0, 50.0]},"
        " lambda r: r.peaks.hinge_force.max(), duration=2e-3)\n"
        "sweep"
    ),
}
WIDGET = "application/vnd.jupyter.widget-view+json"


EXECUTE = """
import sys
import nbclient, nbformat
from jupyter_client.manager import AsyncKernelManager

notebook = nbformat.read(sys.argv[1], 4)
manager = AsyncKernelManager()
manager.kernel_spec.argv[0] = sys.executable  # whatever kernels this machine has installed
nbclient.NotebookClient(notebook, km=manager, timeout=120).execute()
nbformat.write(notebook, sys.argv[1])
"""


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    cells = [nbformat.v4.new_code_cell(source) for source in CELLS.values()]
    path = tmp_path_factory.mktemp("notebook") / "drive.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=cells), path)
    # In a process of its own: the sockets of a kernel's client close when they are collected.
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", EXECUTE, path],
        cwd=path.parent,
        env=os.environ | {"TMPDIR": str(path.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    notebook = nbformat.read(path, 4)
    return {name: cell.outputs for name, cell in zip(CELLS, notebook.cells, strict=True)}


def shown(outputs, name, kind):
    """Return what a cell shows of a kind of content."""
    return [one["data"][kind] for one in outputs[name] if kind in one.get("data", {})]


@pytest.mark.parametrize("name", ["figure", "axes", "figure after pyplot"])
def test_a_figure_is_shown_once(outputs, name):
    assert len(shown(outputs, name, "image/png")) == 1


@pytest.mark.parametrize("name", ["drive", "report", "result", "summary", "sweep"])
def test_a_table_is_shown_without_a_second_picture(outputs, name):
    (html,) = (html for html in shown(outputs, name, "text/html") if "<table" in html)
    assert html.count("image/png") == (name != "summary")
    assert shown(outputs, name, "image/png") == []


@pytest.mark.parametrize("name", ["result", "sweep"])
def test_progress_is_a_widget(outputs, name):
    assert len(shown(outputs, name, WIDGET)) == 1


def test_nothing_is_written_to_the_error_stream(outputs):
    streams = [one for cell in outputs.values() for one in cell if one.get("name") == "stderr"]
    assert streams == []
