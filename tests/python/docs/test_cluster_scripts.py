"""The scripts in examples/cluster/ run, on stand-ins for SLURM and Ray and under a real MPI."""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3] / "examples" / "cluster"
SHORTER = {
    "on_slurm": [
        ("range(0, 200, 5)", "[50.0, 60.0]"),
        ("range(5, 45)", "[12.0]"),
        ("duration=0.5", "duration=0.11"),
    ],
    "on_mpi": [("duration=0.02", "duration=5e-3")],
    "on_ray": [("duration=0.02", "duration=5e-3")],
}
STAND_INS = {
    "dask_jobqueue": """
from dask.distributed import LocalCluster

class SLURMCluster(LocalCluster):
    def __init__(self, *, cores, processes, memory, walltime, queue):
        super().__init__(n_workers=1, threads_per_worker=1, dashboard_address=None)

    def adapt(self, *, minimum_jobs, maximum_jobs):
        assert minimum_jobs <= maximum_jobs
""",
    "ray": """
from concurrent.futures import ThreadPoolExecutor

pool = ThreadPoolExecutor(1)

class Reference:
    def __init__(self, future):
        self._future = future

    def future(self):
        return self._future

def init():
    pass

def remote(num_cpus):
    def made(function):
        class Task:
            @staticmethod
            def remote(*given):
                return Reference(pool.submit(function, *given))
        return Task
    return made
""",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", [path.stem for path in sorted(ROOT.glob("*.py"))])
def test_a_script_for_a_cluster_runs(name, tmp_path):
    for module, text in STAND_INS.items():
        (tmp_path / f"{module}.py").write_text(text)
    text = (ROOT / f"{name}.py").read_text(encoding="utf-8")
    for long, short in SHORTER[name]:
        assert long in text
        text = text.replace(long, short)
    (tmp_path / f"{name}.py").write_text(text)
    called = [sys.executable, f"{name}.py"]
    if name == "on_mpi":
        launcher = shutil.which(
            "mpiexec", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        )
        if importlib.util.find_spec("mpi4py") is None or launcher is None:
            pytest.skip("no MPI here")
        called = [launcher, "-n", "3", sys.executable, "-m", "mpi4py.futures", f"{name}.py"]
    paths = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": paths, "TMPDIR": str(tmp_path)}
    done = subprocess.run(called, capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert done.returncode == 0, done.stderr
    cases = 2 if name == "on_slurm" else 8
    assert f"{cases} of {cases} cases finished, 0 failed" in done.stdout
    assert len((tmp_path / "sweep.csv").read_text().splitlines()) == 1 + cases
    assert len(list((tmp_path / "runs").glob("*.nc"))) == cases


@pytest.mark.parametrize("path", sorted(ROOT.glob("*.py")), ids=lambda path: path.stem)
def test_a_script_names_the_package_as_the_index_has_it(path):
    text = path.read_text(encoding="utf-8")
    assert 'pip install "rustchain-dynamics[' in text
    assert 'pip install "rustchain[' not in text
