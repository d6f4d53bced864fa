"""Scenes with extreme numbers: refused by name, or ended where a run makes no progress."""

from dataclasses import replace

import pytest

import rustchain as rc


def drive(torque=-5.0, pretension=100.0):
    return rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=20.0, torque=torque, pretension=pretension
    )


def with_link_mass(mass):
    """Links of `mass` [kg], with an inertia to match."""
    plain = drive()
    chain = plain.chain
    links = {
        name: replace(getattr(chain, name), mass=mass, inertia=1e-4 * mass)
        for name in ("inner", "outer")
    }
    return replace(plain, chain=replace(chain, **links))


HOPELESS = {
    "links of a microgram": lambda: rc.Simulation(with_link_mass(1e-9)),
    "a lubricant of 1e9 Pa s": lambda: rc.Simulation(drive(), hinge_film=rc.Film(viscosity=1e9)),
    "steps of a picosecond": lambda: rc.Simulation(drive(), solver=rc.Solver(max_step=1e-12)),
}


@pytest.mark.parametrize("scene", HOPELESS)
def test_a_run_that_would_take_a_billion_steps_ends_with_an_error(scene):
    simulation = HOPELESS[scene]()
    with pytest.raises(rc.SimulationError, match=r"more than 1e9 steps") as caught:
        simulation.run(1.0, energy=False, progress=False)
    error = caught.value
    assert 0.0 < error.step_size < 1e-9
    assert error.result.status == "failed"
    # What is refused is the time that is left, not the scene.
    simulation.step_to(simulation.time + 10.0 * error.step_size)


def test_steps_of_a_microsecond_are_slow_and_legal():
    simulation = rc.Simulation(drive(), solver=rc.Solver(max_step=1e-6))
    result = simulation.run(0.12, report_step=1e-3, energy=False, progress=False)
    assert result.status == "finished"
    assert result.stats["steps"] > 1e5


@pytest.mark.parametrize(
    ("field", "scene"),
    [
        (r"sprockets\[1\].motion.torque = 1000000000", lambda: drive(torque=-1e9)),
        ("Tensioner.pretension = 1000000000", lambda: drive(pretension=1e9)),
        ("ChainDrive.gravity = 1000000000", lambda: replace(drive(), gravity=(0.0, -1e9))),
    ],
)
def test_a_load_that_no_chain_bears_is_refused_by_its_name(field, scene):
    with pytest.raises(rc.InvalidInput, match=field + ".*expected at most .*check the unit"):
        scene().check()


def test_loads_far_above_what_chains_break_at_are_allowed():
    drive(torque=-1e3, pretension=1e5).check()


def test_a_heavy_chain_under_little_tension_comes_to_rest():
    heavy = rc.two_sprocket_drive("ISO 24B", (52, 10), links=159, pretension=14.7)
    rest = rc.Simulation(heavy, start="static").rest
    assert rest["residual"] < 1e-6 * rest["largest_force"]


def test_a_refused_static_start_names_the_torque_that_nothing_holds():
    plain = rc.paper_drive()
    turned = replace(plain.sprockets[0], motion=rc.AppliedTorque(1.0))
    loose = replace(plain, sprockets=(turned, plain.sprockets[1]))
    with pytest.raises(rc.InvalidInput, match="nothing holds the torque on sprocket 1") as caught:
        rc.Simulation(loose, start="static")
    assert "tension" not in str(caught.value)
