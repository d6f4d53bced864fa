"""A sweep on a Ray cluster, whose tasks are made an executor of Python's.

pip install "rustchain-dynamics[all]" ray
python on_ray.py
"""

from __future__ import annotations

from concurrent.futures import Executor, Future

import ray

import rustchain as rc


class RayExecutor(Executor):
    """Hands each call to Ray as a task of one core."""

    def __init__(self) -> None:
        self._call = ray.remote(num_cpus=1)(lambda function, *given: function(*given))

    def submit(self, function, /, *given) -> Future:
        """Return the future of a call."""
        return self._call.remote(function, *given).future()


if __name__ == "__main__":
    ray.init()  # or ray.init("ray://head:10001")
    axes = {"pretension": range(0, 100, 25), "speed": [10.0, 12.0]}
    found = rc.sweep(
        rc.paper_drive(),
        axes,
        lambda result: float(result.peaks.tooth_force.max()),
        duration=0.02,
        executor=RayExecutor(),
        store="runs/",
    )
    print(found.message)
    found.to_pandas().to_csv("sweep.csv")
