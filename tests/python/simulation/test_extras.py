"""The base install needs NumPy alone; what an extra has is named with its pip command."""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from rustchain.extras import MODULES
from rustchain.names import DISTRIBUTION

HEAVY = ("matplotlib", "xarray", "h5netcdf", "h5py", "pandas", "scipy", "tqdm", "typer", "dask")

BLOCKED = """
import sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {blocked}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Blocked())
import rustchain as rc
drive = rc.paper_drive(25.0)
result = rc.Simulation(drive).run(duration=2e-4, progress=True)
"""


def python(code, *arguments):
    return subprocess.run(
        [sys.executable, *arguments, "-c", textwrap.dedent(code)],
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_import_loads_no_package_of_an_extra():
    code = "import rustchain, sys; print(*{name.split('.')[0] for name in sys.modules})"
    loaded = python(code)
    assert loaded.returncode == 0, loaded.stderr
    assert not set(HEAVY) & set(loaded.stdout.split())


@pytest.mark.parametrize(
    ("call", "extra"),
    [
        ("result.plot.tension()", "plot"),
        ("result.save('run.nc')", "io"),
        ("result.to_xarray()", "io"),
        ("result.to_pandas()", "io"),
        ("result.hinge_loads()", "io"),
        ("rc.load_result(sys.executable)", "io"),
        ("rc.sweep(drive, {'pretension': [25.0]}, len, duration=1e-4).to_pandas()", "io"),
    ],
)
def test_a_missing_extra_is_named_with_its_pip_command(call, extra):
    ended = python(BLOCKED.format(blocked=set(HEAVY)) + call)
    assert "rustchain.errors.MissingExtra: " in ended.stderr, ended.stderr
    assert f'pip install "rustchain-dynamics[{extra}]"' in ended.stderr


def test_scipy_alone_is_named_with_the_extra_analysis():
    ended = python(BLOCKED.format(blocked={"scipy"}) + "result.spectrum('hinge_force')")
    assert 'pip install "rustchain-dynamics[analysis]"' in ended.stderr, ended.stderr


def test_the_command_names_its_extra_without_a_traceback():
    code = BLOCKED.format(blocked={"typer"}) + "from rustchain.cli import main; main()"
    ended = python(code)
    assert ended.returncode == 1
    assert ended.stderr.splitlines()[-1] == (
        "error: typer is not installed; it belongs to the extra 'cli': "
        'pip install "rustchain-dynamics[cli]"'
    )
    assert "Traceback" not in ended.stderr


def test_the_base_install_runs_and_says_what_it_did():
    shown = "print(result.status, result.hinge(6)); print(result.summary(), result.efficiency())"
    ended = python(BLOCKED.format(blocked=set(HEAVY)) + shown)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.startswith("finished")
    assert "hinge_force_largest" in ended.stdout


@pytest.fixture
def project():
    tomllib = pytest.importorskip("tomllib")  # Python 3.11
    text = (Path(__file__).parents[3] / "pyproject.toml").read_text("utf-8")
    return tomllib.loads(text)["project"]


def test_the_pip_command_names_the_distribution(project):
    assert project["name"] == DISTRIBUTION
    assert {extra for _, extra in MODULES.values()} <= set(project["optional-dependencies"])


def test_the_extra_of_all_has_what_each_extra_has(project):
    extras = project["optional-dependencies"]
    everything = set(extras.pop("all"))
    assert everything == {package for packages in extras.values() for package in packages}


def test_a_notebook_without_ipywidgets_warns_of_nothing():
    code = BLOCKED.format(blocked={"ipywidgets"}).replace(
        "import rustchain as rc",
        "from types import SimpleNamespace as Space\n"
        "kernel = Space(config={'IPKernelApp': {}})\n"
        "sys.modules['IPython'] = Space(get_ipython=lambda: kernel)\n"
        "sys.modules['ipykernel.zmqshell'] = Space()\n"
        "import rustchain as rc",
    )
    done = python(code, "-W", "always")
    assert done.returncode == 0, done.stderr
    assert "IProgress" not in done.stderr
