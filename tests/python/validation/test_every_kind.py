"""One short run of each force law, corrector and kind of scene, for `make check`."""

import numpy as np
import pytest

import rustchain as rc

LAWS = [
    rc.LankaraniNikravesh(),
    rc.Hertz(),
    rc.Hertz(damping="flores"),
    rc.Johnson(damping="lankarani-nikravesh"),
    rc.EnhancedCylinder(),
    rc.Esdu78035(damping="lankarani-nikravesh"),
    rc.HertzCylinder(damping="lankarani-nikravesh"),
    rc.LiuConformal(damping="lankarani-nikravesh"),
    rc.Linear(stiffness=1e8),
    rc.Radzimovsky(damping="lankarani-nikravesh"),
]


def _two_sprockets(**keywords):
    return rc.two_sprocket_drive(chain="ANSI 40", teeth=(17, 25), links=60, speed=20.0, **keywords)


def _bouncing_pin():
    mechanism = rc.Mechanism()
    mechanism.add_body("pin", 0.1, 1e-5, velocity=(-0.05, 0.09, 0.0))
    mechanism.add_clearance_joint("joint", "ground", "pin", 0.0101, 0.01, rc.SurfaceContact())
    return mechanism


SCENES = {
    "clearance": _two_sprockets,
    "tensioner": lambda: _two_sprockets(pretension=50.0),
    "ideal hinges": lambda: _two_sprockets(hinges="ideal"),
    "open chain": lambda: rc.open_chain(
        "ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.1, 0.0))), 12
    ),
    "mechanism": _bouncing_pin,
}


# A law of bores says that it holds for hinges only.
@pytest.mark.filterwarnings("ignore::rustchain.RangeWarning")
@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{type(law).__name__} {law.damping}")
def test_a_run_with_each_force_law_closes_its_energy_balance(law):
    # Without damping the residual of this run is at the limit of the warning at 1e-10 m.
    solver = rc.Solver(accuracy=1e-11 if law.damping is None else 1e-10)
    simulation = rc.Simulation(_two_sprockets(), force_law=law, solver=solver)
    result = simulation.run(0.006, progress=False)
    assert result.status == "finished"
    exchanged = np.abs(result.energy.external_work).max() + np.ptp(result.energy.kinetic)
    assert np.abs(result.energy.residual).max() < 0.05 * exchanged


@pytest.mark.parametrize("method", ["auto", "pece", "newton"])
@pytest.mark.parametrize("kind", SCENES)
def test_each_kind_of_scene_runs_with_each_corrector(kind, method):
    simulation = rc.Simulation(SCENES[kind](), solver=rc.Solver(method=method))
    result = simulation.run(0.004, report_step=1e-3, progress=False)
    assert result.status == "finished"
    assert result.time[-1] == pytest.approx(0.004)
    assert np.isfinite(simulation.positions).all()
