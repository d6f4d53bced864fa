"""Scenes with extreme numbers: refused by name, or ended where a run makes no progress."""

import time
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc


def drive(torque=-5.0, pretension=100.0, speed=20.0):
    return rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=speed, torque=torque, pretension=pretension
    )


def driven_by(initial_speed=None, curve=None):
    plain = drive()
    motion = rc.AppliedTorque(1.0, curve=curve)
    driver = replace(plain.sprockets[0], motion=motion, initial_speed=initial_speed)
    return replace(plain, sprockets=(driver, plain.sprockets[1]))


def hung(anchor, mass=1.0):
    return rc.open_chain("ANSI 40", (anchor, rc.LoadedEnd(mass)), 8)


def carrying(carried):
    plain = drive()
    return replace(plain, chain=replace(plain.chain, carried=carried))


def guided(force):
    plain = drive()
    arm = rc.GuideArm((0.0, 0.08), force)
    blade = rc.GuideRail((0.1, 0.1), (0.0, -1.0), 0.05, radius=0.2, end_radius=0.01, arm=arm)
    return replace(plain, guides=[blade])


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
    "a lubricant of 1e9 Pa s": lambda: rc.Simulation(
        drive(), hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(viscosity=1e9))
    ),
    "steps of a picosecond": lambda: rc.Simulation(drive(), solver=rc.Solver(max_step=1e-12)),
}


@pytest.mark.filterwarnings("ignore:hinge_law.film.viscosity")
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
        (r"sprockets.2.motion.torque = 1000000000", lambda: drive(torque=-1e9)),
        ("Tensioner.pretension = 1000000000", lambda: drive(pretension=1e9)),
        ("ChainDrive.gravity = 1000000000", lambda: replace(drive(), gravity=(0.0, -1e9))),
        (r"sprockets.1.motion.speed = 1000000000", lambda: drive(speed=1e9)),
        (r"motion.speed = 200000:", lambda: drive(speed=((0.0, 1.0), (1.0, -2e5)))),
        (r"motion.curve \(torque\) = 1000000", lambda: driven_by(curve=((0.0, 1e6), (9.0, 0.0)))),
        (r"motion.curve \(speed\) = 90000", lambda: driven_by(curve=((0.0, 1.0), (9e4, 0.0)))),
        (r"sprockets.1.initial_speed = -90000", lambda: driven_by(initial_speed=-9e4)),
        (
            r"ends.1.velocity = 2000",
            lambda: hung(rc.AnchoredEnd((0.0, 0.0), velocity=(0.0, 2e3))),
        ),
        (r"ends.2.mass = 1000000000", lambda: hung(rc.AnchoredEnd((0.0, 0.0)), mass=1e9)),
        (r"Chain.carried \(sum of masses\) = 1000000000", lambda: carrying([(1, 1e9)])),
        (r"Chain.carried \(sum of masses\) = 1000000000", lambda: carrying([(3, 1e9)])),
        (r"ChainDrive.guides.1.arm.force = 1000000000", lambda: guided(1e9)),
    ],
)
def test_a_load_that_no_chain_bears_is_refused_by_its_name(field, scene):
    with pytest.raises(rc.InvalidInput, match=field + ".*expected at most .*check the unit"):
        scene().check()


def test_loads_far_above_what_chains_break_at_are_allowed():
    drive(torque=-1e3, pretension=1e5).check()
    # A hundredth of what is refused: the mass on one link is that of one link only.
    carrying([(1, 1e3)]).check()


def test_the_greatest_speed_is_that_of_the_chain():
    radius = 0.5 * 0.0127 / np.sin(np.pi / 17)
    drive(speed=999.0 / radius).check()
    with pytest.raises(rc.InvalidInput, match=r"at most 2\.9e4 rad/s, a chain speed of 1000 m/s"):
        drive(speed=1001.0 / radius).check()


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_a_run_at_an_absurd_speed_is_refused_before_it_begins(hinges):
    with pytest.raises(rc.InvalidInput, match=r"motion\.speed = 1000000000"):
        rc.Simulation(replace(drive(speed=1e9), hinges=hinges))


def test_what_is_set_while_a_drive_runs_holds_to_the_bounds_of_its_description():
    simulation = rc.Simulation(drive(torque=-1.0))
    simulation.step_to(1e-4)
    before = simulation.state()["snapshot"]
    for call, message in (
        (lambda: simulation.set_speed(1, 1e9), "speed of sprocket_1 = 1000000000: expected at"),
        (
            lambda: simulation.set_speed(1, [(0.0, 1.0), (1.0, -3e4)]),
            "speed of sprocket_1 = 30000: expected at most 2.9e4 rad/s",
        ),
        (lambda: simulation.set_torque(2, -1e9), "torque of sprocket_2 = 1000000000: expected at"),
    ):
        with pytest.raises(rc.InvalidInput, match=message):
            call()
        assert simulation.state()["snapshot"] == before
    simulation.set_speed(1, 100.0)
    simulation.set_torque(2, -5.0)


def test_a_guide_is_no_sprocket_whose_speed_is_set():
    idler = rc.SmoothIdler(0.01, (0.0, -0.5))
    simulation = rc.Simulation(replace(drive(), guides=[idler]))
    with pytest.raises(rc.InvalidInput, match="sprockets are numbered 1 to 2"):
        simulation.set_speed(3, 1.0)


@pytest.mark.parametrize(("row", "column"), [(0, 1), (-1, 2)])
def test_a_start_of_ones_own_holds_to_the_bounds_of_speeds(row, column):
    calm = rc.Simulation(drive(torque=-1.0))
    velocities = calm.velocities.copy()
    velocities[row, column] = 1e6
    name = "sprocket_2" if row else "link_1"
    with pytest.raises(
        rc.InvalidInput, match=f"velocities of {name} = .*1000000.*expected at most"
    ):
        rc.Simulation(calm.drive, positions=calm.positions, velocities=velocities)


def test_a_count_beyond_every_bound_is_refused_as_too_large():
    with pytest.raises(rc.InvalidInput, match="links = 38000000000: must be at most"):
        replace(rc.paper_drive().chain, links=38_000_000_000)


def test_a_chain_a_thousand_times_too_long_is_refused_before_its_links_are_fitted():
    plain = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60)
    first = replace(plain.sprockets[0], eccentricity=5e-5)
    chain = replace(plain.chain, links=60_000, pitch_spread=1e-5)
    spans = []
    for wheel in (plain.sprockets[0], first):
        drive = replace(plain, chain=chain, sprockets=(wheel, plain.sprockets[1]))
        begin = time.process_time()
        with pytest.raises(rc.InvalidInput, match="would bow out"):
            drive.check()
        spans.append(time.process_time() - begin)
    # 34 s with the eccentric wheel when the links were fitted for each of its 12 rotations.
    centred, eccentric = spans
    assert eccentric < 4.0 * centred


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


def test_a_refused_static_start_says_that_nothing_holds_an_open_chain():
    ends = rc.LoadedEnd(5.0), rc.LoadedEnd(2.0)
    hoist = rc.open_chain("ANSI 40", ends, 40, [rc.Sprocket(17, (0.0, 0.0))])
    with pytest.raises(rc.InvalidInput, match="nothing holds the chain") as caught:
        rc.Simulation(hoist, start="static")
    assert "nearer to rest" not in str(caught.value)
    held = replace(hoist.sprockets[0], motion=rc.PrescribedSpeed(0.0))
    assert rc.Simulation(replace(hoist, sprockets=(held,)), start="static").rest
