"""Wrong arguments of simulations, their methods and starts, each refused by name."""

import math

import numpy as np
import pytest

import rustchain as rc
from bad_input.fields import DRIVE, TENSIONED
from bad_input.values import INF, NAN, assert_refused

LAWS = "expected a force law such as LankaraniNikravesh() or Hertz()"
SIMULATION = [
    *[("system of the scene", value, "must be a ChainDrive") for value in (None, "paper", 1)],
    ("system of the scene", DRIVE.chain, "must be a ChainDrive"),
    *[
        (argument, value, LAWS)
        for argument in ("force_law", "hinge_law", "tooth_law")
        for value in ("hertz", rc.Hertz, 1, 0, "", False)
    ],
    *[
        ("min_impact_velocity", value, "must be a positive number in m/s")
        for value in (NAN, INF, -1e-3, 0.0)
    ],
    *[("min_impact_velocity", value, "must be a number in m/s") for value in ("1e-3", True, 1j)],
    *[("solver", value, "must be a Solver") for value in ("pece", rc.Solver, 1e-5)],
]


@pytest.mark.parametrize(("argument", "value", "allowed"), SIMULATION)
def test_a_wrong_argument_of_a_simulation_is_refused_by_name(argument, value, allowed):
    name = argument.split()[-1]
    with pytest.raises(rc.InvalidInput) as caught:
        rc.Simulation(**{"scene": DRIVE, name: value})
    assert_refused(caught.value, argument, value, allowed)


BODIES = 40
SHAPES = {
    "a row too few": (lambda a: a[:-1], "39 rows", "each of the 40 bodies"),
    "a row too many": (lambda a: np.vstack([a, a[:1]]), "41 rows", "each of the 40 bodies"),
    "no rows": (lambda a: a[:0], "0 rows", "each of the 40 bodies"),
    "two columns": (lambda a: a[:, :2], "(40, 2)", "(x, y, theta)"),
    "transposed": (lambda a: a.T, "(3, 40)", "(x, y, theta)"),
    "flat": (np.ravel, "(120,)", "(40, 3)"),
    "one row": (lambda a: a[0], "(3,)", "(40, 3)"),
    "a number": (lambda a: 1.0, "", "(40, 3)"),
    "three axes": (lambda a: a[None], "(1, 40, 3)", "(40, 3)"),
    "text": (lambda a: "here", "here", "(40, 3)"),
    "ragged": (lambda a: [[1.0, 2.0], [3.0]], "", "(40, 3)"),
    "complex": (lambda a: a + 1j, "complex", "(40, 3)"),
}
WRONG_NUMBERS = [
    *[(0, column, value, "link_1") for column in range(3) for value in (NAN, INF)],
    (17, 1, -INF, "link_18"),
    (39, 0, NAN, "sprocket_2"),
]


@pytest.fixture(scope="module")
def simulation():
    """A simulation in the middle of its run, to evaluate."""
    simulation = rc.Simulation(TENSIONED)
    simulation.step_to(6e-3)
    return simulation


@pytest.fixture
def beginning():
    """A simulation whose run has just begun."""
    simulation = rc.Simulation(TENSIONED)
    simulation.step_to(5e-4)
    return simulation


@pytest.fixture(scope="module")
def start():
    simulation = rc.Simulation(TENSIONED)
    return {"positions": simulation.positions, "velocities": simulation.velocities}


@pytest.mark.parametrize("argument", ["positions", "velocities"])
@pytest.mark.parametrize("case", SHAPES)
def test_an_array_of_the_wrong_shape_is_refused_by_name(argument, case, start, simulation):
    change, value, allowed = SHAPES[case]
    given = {**start, argument: change(start[argument])}
    for call in (
        lambda: rc.Simulation(TENSIONED, **given),
        lambda: simulation.evaluate(**{argument: given[argument]}),
    ):
        with pytest.raises(rc.InvalidInput) as caught:
            call()
        message = str(caught.value)
        assert message.startswith(argument), message
        assert value in message, message
        assert allowed in message, message


@pytest.mark.parametrize("argument", ["positions", "velocities"])
@pytest.mark.parametrize(("body", "column", "value", "name"), WRONG_NUMBERS)
def test_a_number_that_is_none_is_refused_by_body(
    argument, body, column, value, name, start, simulation
):
    given = {key: array.copy() for key, array in start.items()}
    given[argument][body, column] = value
    for call in (
        lambda: rc.Simulation(TENSIONED, **given),
        lambda: simulation.evaluate(**{argument: given[argument]}),
    ):
        with pytest.raises(rc.InvalidInput) as caught:
            call()
        assert_refused(caught.value, f"{argument} of {name}", value, "must be finite")


def test_positions_need_velocities(start):
    with pytest.raises(rc.InvalidInput, match="velocities = None: must be given when positions"):
        rc.Simulation(TENSIONED, positions=start["positions"])
    with pytest.raises(rc.InvalidInput, match="velocities = None: must be given when positions"):
        rc.Simulation(rc.paper_drive(hinges="ideal"), positions=start["positions"])


SPROCKETS = [rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)), rc.Sprocket(17, (0.3, 0.0))]
GUIDED = rc.chain_drive(
    "ANSI 40", SPROCKETS, adjust=2, guides=[rc.GuideRail((0.15, 0.06), (0.0, 1.0), 0.1)]
)
HANGING = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(1.0, 1e-3)), 8)


@pytest.mark.parametrize(
    ("drive", "body", "column", "message"),
    [
        (rc.paper_drive(), "sprocket_1", 0, r"must be \(0, 0\): its bearing is fixed"),
        (rc.paper_drive(), "sprocket_2", 1, r"must be \(0.133348\d+, 0\): its bearing is fixed"),
        (rc.paper_drive(hinges="ideal"), "sprocket_2", 0, "its bearing is fixed"),
        (TENSIONED, "sprocket_2", 1, "its tensioner leads it past there"),
        (GUIDED, "guide_1", 0, "it is held there"),
        (GUIDED, "guide_1", 2, "rad: it does not turn"),
        (HANGING, "end_1", 1, r"must be \(0, 0\): it is anchored there"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_positions_that_move_what_is_held_in_its_place_are_refused(drive, body, column, message):
    simulation = rc.Simulation(drive)
    row = simulation.body_names.index(body)
    for off in (1e-9, 1e-4):
        positions = simulation.positions.copy()
        positions[row, column] += off
        given = {"positions": positions, "velocities": simulation.velocities}
        if off < 1e-8:  # the rounding of a file
            rc.Simulation(drive, **given)
            continue
        with pytest.raises(rc.InvalidInput, match=f"positions of {body} = .*{message}"):
            rc.Simulation(drive, **given)


def test_an_arm_a_whole_turn_away_from_its_stops_is_refused():
    arm = rc.GuideArm(pivot=(0.06, 0.06), force=40.0)
    blade = rc.GuideRail((0.15, 0.06), (0.0, -1.0), 0.1, radius=0.3, arm=arm)
    drive = rc.chain_drive("ANSI 40", SPROCKETS, adjust=2, guides=[blade])
    simulation = rc.Simulation(drive)
    positions = simulation.positions.copy()
    positions[-1, 2] += 2.0 * np.pi
    with pytest.raises(rc.InvalidInput, match=r"positions of guide_1 = .* rad: must be .* rad, le"):
        rc.Simulation(drive, positions=positions, velocities=simulation.velocities)


def test_positions_that_the_supports_allow_are_taken(start):
    positions = start["positions"].copy()
    positions[39, 0] -= 1e-6  # along the slide
    simulation = rc.Simulation(TENSIONED, positions=positions, velocities=start["velocities"])
    np.testing.assert_array_equal(simulation.positions, positions)


@pytest.mark.parametrize(
    ("body", "velocity", "message"),
    [
        (38, (1e-6, 0.0, 4 * math.pi), r"velocities of sprocket_1 = \(0.000001, 0\): .*fixed"),
        (38, (0.0, -1.0, 4 * math.pi), r"velocities of sprocket_1 = \(0, -1\): .*fixed"),
        (38, (0.0, 0.0, 12.0), r"velocities of sprocket_1 = 12: .*prescribed: must be 12.566"),
        (
            39,
            (0.0, 1e-3, 12.0),
            r"velocities of sprocket_2 = \(0, 0.001\): its tensioner permits displacement along",
        ),
    ],
)
def test_velocities_that_the_supports_do_not_allow_are_refused(body, velocity, message, start):
    velocities = start["velocities"].copy()
    velocities[body] = velocity
    with pytest.raises(rc.InvalidInput, match=message):
        rc.Simulation(TENSIONED, positions=start["positions"], velocities=velocities)


def test_velocities_that_the_supports_allow_are_taken(start):
    velocities = start["velocities"].copy()
    velocities[39] = 0.01, 0.0, 11.0  # along the slide
    simulation = rc.Simulation(TENSIONED, positions=start["positions"], velocities=velocities)
    np.testing.assert_array_equal(simulation.velocities, velocities)


# --- methods and functions

CALLS = {
    "duration": lambda s, value: s.run(value, progress=False),
    "report_step": lambda s, value: s.run(1e-4, report_step=value, progress=False),
    "record": lambda s, value: s.run(1e-4, record=value, progress=False),
    "energy": lambda s, value: s.run(1e-4, energy=value, progress=False),
    "t": lambda s, value: s.step_to(value),
    "time": lambda s, value: s.evaluate(time=value),
}
ARGUMENTS = [
    *[("duration", value, "must be a positive number in s") for value in (NAN, INF, -1.0, 0.0)],
    ("duration", 1e300, "must be at most 1e9 s"),
    *[("duration", value, "must be a number in s") for value in ("1", None, True, 1j)],
    *[("report_step", value, "must be a positive number in s") for value in (NAN, INF, -1e-4, 0)],
    *[("report_step", value, "must be a number in s") for value in ("1", None, True, 1j)],
    ("report_step", 1e-20, "more than 1e9 reports"),
    *[("energy", value, "must be True or False") for value in ("no", 2)],
    *[("t", value, "must be a number in s") for value in ("1", None, True, 1j)],
    *[("t", value, "must not lie before the present time, 0.0005 s") for value in (0.0, 4.9e-4)],
    ("t", 1e300, "must be at most 1e9 s after the present time, 0.0005 s"),
    *[("t", value, "must be a finite number in s") for value in (NAN, INF, -INF)],
    *[("time", value, "must be a number in s") for value in ("1", True, 1j)],
    *[("time", value, "must be a finite number in s") for value in (NAN, INF)],
]


def test_values_of_numpy_that_are_no_number_or_no_truth_are_refused(simulation):
    with pytest.raises(rc.InvalidInput, match="t = True: must be a number in s"):
        simulation.step_to(np.True_)
    for value in (np.array([1, 2, 3]), np.array([True, False]), np.array([])):
        with pytest.raises(rc.InvalidInput, match=r"energy = array\(.*must be True or False"):
            simulation.run(1e-4, energy=value, progress=False)
    for number in (2**31, 10**30, np.uint64(2**63)):
        with pytest.raises(rc.InvalidInput, match="sprockets are numbered 1 to 2"):
            simulation.set_torque(number, 1.0)


@pytest.mark.parametrize(("argument", "value", "allowed"), ARGUMENTS)
def test_a_wrong_argument_is_refused_before_any_step(argument, value, allowed, beginning):
    before = beginning.state()
    with pytest.raises(rc.InvalidInput) as caught:
        CALLS[argument](beginning, value)
    assert_refused(caught.value, argument, value, allowed)
    after = beginning.state()
    assert after["time"] == before["time"]
    assert after["snapshot"] == before["snapshot"]


@pytest.mark.parametrize(
    ("record", "message"),
    [
        (("hinge",), "'hinge' is no group; did you mean 'hinges'"),
        ("tooth", "'tooth' is no group; did you mean 'teeth'"),
        (("hinges", "x"), "'x' is no group; known: 'hinges', 'teeth', 'sprockets', 'bodies'"),
        ((1,), "1 is no group; known: 'hinges'"),
        (1, "record"),
    ],
)
def test_an_unknown_group_is_refused_with_the_nearest(record, message, beginning):
    with pytest.raises(rc.InvalidInput, match=message) as caught:
        CALLS["record"](beginning, record)
    assert str(caught.value).startswith("record")
