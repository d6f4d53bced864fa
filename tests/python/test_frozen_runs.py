"""Final bits and counts of short runs, held against stored ones.

A change of structure leaves them as they are. A change that moves values writes them anew, with
``python tests/python/test_frozen_runs.py``, and says in its commit by how much and why.
"""

import hashlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc

STORED = Path(__file__).parents[1] / "data" / "frozen_runs.json"
# Instructions with fused multiply-add give the same bits; without it, roundings differ. NEON was
# compared with the C library of Linux only.
FUSED = ("avx512", "avx2", *(["neon"] if sys.platform == "linux" else []))


def _geared(**keywords):
    return rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25), links=60, speed=50.0, **keywords)


def _idler():
    sprockets = [rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)), rc.Sprocket(17, (0.3, 0.0))]
    idler = rc.SmoothIdler(0.02, (0.15, -0.0586))
    return rc.chain_drive("ANSI 40", sprockets, adjust=2, guides=[idler])


def _hanging():
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.1, 0.0)))
    return rc.open_chain("ANSI 40", ends, 12)


def _pin_in_bore():
    mechanism = rc.Mechanism()
    mechanism.add_body("pin", 0.1, 1e-5, velocity=(-0.05, 0.09, 0.0))
    mechanism.add_clearance_joint("joint", "ground", "pin", 0.0101, 0.01, rc.SurfaceContact())
    return mechanism


def _paper(pretension, method):
    solver = rc.Solver(method=method)
    return lambda: rc.Simulation(rc.paper_drive(pretension=pretension), solver=solver)


SCENES = {
    "paper 25 N auto": _paper(25.0, "auto"),
    **{
        f"paper {pretension:g} N {method}": _paper(pretension, method)
        for pretension in (0.0, 100.0)
        for method in ("auto", "pece", "newton")
    },
    **{
        type(law).__name__: lambda law=law: rc.Simulation(_geared(), force_law=law)
        for law in (rc.Hertz(), rc.Johnson(damping="flores"), rc.EnhancedCylinder())
    },
    "Coulomb": lambda: rc.Simulation(
        _geared(pretension=25.0), force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    ),
    "LuGre": lambda: rc.Simulation(
        _geared(pretension=25.0), force_law=rc.LankaraniNikravesh(friction=rc.LuGre(0.12, 0.1))
    ),
    "film": lambda: rc.Simulation(
        _geared(pretension=25.0), hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    ),
    "elastic plates": lambda: rc.Simulation(_geared(pretension=25.0, plates="elastic")),
    "rollers": lambda: rc.Simulation(_geared(pretension=25.0, rollers="bodies")),
    "rollers, Coulomb": lambda: rc.Simulation(
        _geared(pretension=25.0, rollers="bodies"),
        force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)),
    ),
    "smooth idler": lambda: rc.Simulation(_idler()),
    "open chain": lambda: rc.Simulation(_hanging()),
    "ideal hinges": lambda: rc.Simulation(_geared(hinges="ideal")),
    "pin in bore": lambda: rc.Simulation(_pin_in_bore()),
}

# The first contacts of the published start come after 4 ms. Some rare contacts come later.
LONGER = [name for name in SCENES if name.startswith("paper")] + ["pin in bore", "smooth idler"]
DURATIONS = {**dict.fromkeys(LONGER, 0.007), "paper 25 N auto": 0.06}


def outcome(name):
    """Return a hash of the final state and the energies, and the counts of a run."""
    simulation = SCENES[name]()
    result = simulation.run(DURATIONS.get(name, 0.002), report_step=1e-4, progress=False)
    energy = result.energy
    bits = hashlib.sha256()
    for values in (simulation.positions, simulation.velocities, energy.dissipated, energy.residual):
        bits.update(np.ascontiguousarray(values).tobytes())
    stats = result.stats
    return {"bits": bits.hexdigest()[:16], "steps": stats["steps"], "rejected": stats["rejected"]}


@pytest.mark.skipif(rc.instruction_set() not in FUSED, reason="bits of fused multiply-add")
@pytest.mark.parametrize("name", SCENES)
def test_a_short_run_ends_with_the_stored_bits_and_counts(name):
    assert outcome(name) == json.loads(STORED.read_text())[name]


if __name__ == "__main__":
    found = {name: outcome(name) for name in SCENES}
    STORED.write_text(json.dumps(found, indent=1) + "\n")
