"""A rich scene of every kind, saved under way: other threads of a new process go on to its bits."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import extremes
import rustchain as rc

UNTIL, REST, STEP = 2e-3, 1e-3, 1e-5  # [s]
THREADS = 3

# Several simulations go on at once from one file, each in a thread of its own.
CHILD = """
import sys
from concurrent.futures import ThreadPoolExecutor
import numpy as np
import rustchain as rc

saved, left, duration, step, threads = sys.argv[1:]
simulations = [rc.Simulation.load_state(saved) for _ in range(int(threads))]
with ThreadPoolExecutor(len(simulations)) as pool:
    results = list(pool.map(
        lambda s: s.run(float(duration), float(step), progress=False), simulations))
for k, (simulation, result) in enumerate(zip(simulations, results)):
    simulation.save_state(f"{left}{k}.npz")
    np.savez(f"{left}{k}.rows.npz", **result.arrays)
"""


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("make", extremes.RICH, ids=lambda make: make.__name__)
def test_threads_of_a_new_process_go_on_to_the_same_bits(make, tmp_path):
    simulation = rc.Simulation(make())
    simulation.run(UNTIL, progress=False)
    simulation.step_to(UNTIL + 1.7e-7)  # inside a step
    saved, left = tmp_path / "state.npz", tmp_path / "left"
    simulation.save_state(saved)
    threads = {"OMP_NUM_THREADS": "3", "RAYON_NUM_THREADS": "3"}
    arguments = map(str, (saved, left, REST, STEP, THREADS))
    child = subprocess.run(
        [sys.executable, "-c", CHILD, *arguments],
        capture_output=True,
        text=True,
        env={**os.environ, **threads},
    )
    assert child.returncode == 0, child.stderr
    result = simulation.run(REST, STEP, progress=False)
    end = simulation.state()["snapshot"]
    for k in range(THREADS):
        rows = np.load(Path(f"{left}{k}.rows.npz"))
        assert set(rows) == set(result.arrays)
        for name, values in result.arrays.items():
            np.testing.assert_array_equal(rows[name], values, err_msg=name, strict=True)
        loaded = rc.Simulation.load_state(f"{left}{k}.npz")
        assert loaded.state()["snapshot"] == end


def test_a_mechanism_whose_driver_changes_the_described_speeds_is_loaded(tmp_path):
    mechanism = rc.Mechanism()
    mechanism.add_body("crank", 0.3, 1e-4, (0.025, 0.0, 0.0))  # described at rest
    mechanism.add_revolute("main", "ground", "crank", at=(0.0, 0.0))
    mechanism.add_driver("motor", "ground", "crank", speed=50.0)
    simulation = rc.Simulation(mechanism)
    simulation.step_to(1e-3)
    simulation.save_state(tmp_path / "state.npz")
    loaded = rc.Simulation.load_state(tmp_path / "state.npz")
    for one in (simulation, loaded):
        one.step_to(3e-3)
    assert loaded.state()["snapshot"] == simulation.state()["snapshot"]
