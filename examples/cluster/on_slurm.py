"""A sweep on a cluster that SLURM manages, through dask-jobqueue.

    pip install "rustchain-dynamics[all]" dask-jobqueue
    python on_slurm.py

SLURM starts jobs of eight workers as they are needed and ends them when the sweep is done. When
this script is ended, start it again: what is in the store is not run again.
"""

from dask.distributed import Client
from dask_jobqueue import SLURMCluster

import rustchain as rc


def measure(result: rc.Result) -> dict[str, float]:
    """Return what is kept of a case."""
    return {
        "force": float(result.peaks.tooth_force.max()),
        "efficiency": result.summary(start=0.1)["efficiency"],
    }


if __name__ == "__main__":
    drive = rc.two_sprocket_drive("ANSI 40", links=78, torque=-1.0)
    axes = {"pretension": range(0, 200, 5), "speed": range(5, 45)}  # 1600 cases
    # Names of queue and account are the cluster's own.
    with (
        SLURMCluster(
            cores=8, processes=8, memory="16 GB", walltime="02:00:00", queue="normal"
        ) as cluster,
        Client(cluster) as client,
    ):
        cluster.adapt(minimum_jobs=1, maximum_jobs=20)
        found = rc.sweep(drive, axes, measure, duration=0.5, executor=client, store="runs/")
    print(found.message)
    found.to_pandas().to_csv("sweep.csv")
