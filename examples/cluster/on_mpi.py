"""A sweep in an MPI job: one process hands out the cases, the others run them.

pip install "rustchain-dynamics[all]" mpi4py
mpiexec -n 9 python -m mpi4py.futures on_mpi.py
"""

from mpi4py.futures import MPIPoolExecutor

import rustchain as rc


def measure(result: rc.Result) -> dict[str, float]:
    """Return what is kept of a case."""
    return {
        "force": float(result.peaks.tooth_force.max()),
        "tension": float(result.strand("upper").tension.mean()),
    }


if __name__ == "__main__":
    axes = {"pretension": range(0, 100, 25), "speed": [10.0, 12.0]}
    with MPIPoolExecutor() as executor:
        found = rc.sweep(
            rc.paper_drive(), axes, measure, duration=0.02, executor=executor, store="runs/"
        )
    print(found.message)
    found.to_pandas().to_csv("sweep.csv")
