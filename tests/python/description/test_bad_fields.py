"""Wrong values of the fields of descriptions, each refused by name."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc
from bad_input.fields import DRIVE, FIELDS, GOOD, TENSIONED
from bad_input.values import INF, NAN, assert_refused, shown


def fields_of(description):
    return {f.name: getattr(description, f.name) for f in dataclasses.fields(description)}


CASES = [
    pytest.param(kind, field, value, allowed, id=f"{kind}.{field}={str(value)[:24]}")
    for kind, fields in FIELDS.items()
    for field, wrong in fields.items()
    for value, allowed in wrong
]


@pytest.mark.parametrize(("kind", "field", "value", "allowed"), CASES)
def test_a_wrong_value_of_a_field_is_refused_by_name(kind, field, value, allowed):
    with pytest.raises(rc.InvalidInput) as caught:
        replace(GOOD[kind], **{field: value})
    assert_refused(caught.value, f"{kind}.{field}", shown(value), allowed)


def test_the_table_has_every_field_of_every_description():
    def below(cls):
        return {cls} | {each for child in cls.__subclasses__() for each in below(child)}

    public = {cls for cls in below(rc.Material.__mro__[1]) if getattr(rc, cls.__name__, 0) is cls}
    # Tested by their simulations and runs.
    public -= {rc.Scene, rc.JointForceAbove, rc.ContactForceAbove}
    public -= {rc.ForceLaw, rc.StopCondition}  # only their subclasses can be made
    # Signals have their own test; contact laws are checked when a mechanism is put together.
    public -= below(rc.LinearContact.__mro__[1])
    assert {cls.__name__ for cls in public} == set(FIELDS) == set(GOOD)
    for cls in public:
        assert {f.name for f in dataclasses.fields(cls)} == set(FIELDS[cls.__name__])


@pytest.mark.parametrize("kind", GOOD)
def test_an_unknown_keyword_is_refused_with_the_nearest_name(kind):
    good = fields_of(GOOD[kind])
    if not good:
        with pytest.raises(TypeError, match=r"Free\(\) has no argument 'speed'"):
            rc.Free(speed=1.0)
    for field in good:
        with pytest.raises(TypeError, match=rf"{kind}\(\) has no argument .*'{field}'"):
            type(GOOD[kind])(**good, **{f"{field}x": 1.0})


@pytest.mark.parametrize("kind", [kind for kind in GOOD if kind != "Free"])
def test_a_missing_or_surplus_argument_names_its_type(kind):
    good = GOOD[kind]
    with pytest.raises(TypeError, match=rf"^{kind}\(\) takes .* by position, got \d+ values"):
        type(good)(*fields_of(good).values(), 1.0)


VECTORS = [
    ("Sprocket", "center", "(x)", (NAN, 0.0), "must be a finite number in m"),
    ("Sprocket", "center", "(y)", (0.0, INF), "must be a finite number in m"),
    ("Sprocket", "center", "(x)", ("1", 0.0), "must be a number in m"),
    ("Sprocket", "center", "(y)", (0.0, None), "must be a number in m"),
    ("ChainDrive", "gravity", "(x)", (NAN, 0.0), "must be a finite number in m/s^2"),
    ("ChainDrive", "gravity", "(y)", (0.0, -INF), "must be a finite number in m/s^2"),
    ("ChainDrive", "gravity", "(y)", (0.0, "g"), "must be a number in m/s^2"),
    ("Tensioner", "direction", "(x)", (None, 1.0), "must be a number"),
    ("Tensioner", "pivot", "(x)", (NAN, 1.0), "must be a finite number"),
    ("Tensioner", "pivot", "(y)", (1.0, INF), "must be a finite number"),
]


@pytest.mark.parametrize(("kind", "field", "axis", "value", "allowed"), VECTORS)
def test_a_wrong_coordinate_is_refused_by_name(kind, field, axis, value, allowed):
    with pytest.raises(rc.InvalidInput) as caught:
        replace(GOOD[kind], **{field: value})
    wrong = value[("(x)", "(y)").index(axis)]
    assert_refused(caught.value, f"{kind}.{field} {axis}", wrong, allowed)


TABLES = [
    ((), "()", "needs at least one row (time, value)"),
    ((1.0, 2.0), None, "must be one number, or rows of (time, value)"),
    (((0.0, 1.0), (1.0,)), "(1.0,)", "each row must be (time, value)"),
    (((0.0, 1.0, 2.0),), "(0.0, 1.0, 2.0)", "each row must be (time, value)"),
    ((("0", 1.0),), "'0'", "must be a number in s"),
    (((0.0, "1"),), "'1'", "must be a number in {unit}"),
    (((NAN, 1.0),), "NaN", "must be a finite number in s"),
    (((0.0, INF),), "inf", "must be a finite number in {unit}"),
    (((0.0, 1.0), (0.0, 2.0)), "0 s after 0 s", "times must increase"),
    (((0.0, 1.0), (0.5, 2.0), (0.25, 2.0)), "0.25 s after 0.5 s", "times must increase"),
]


@pytest.mark.parametrize(
    ("motion", "field", "unit"),
    [(rc.PrescribedSpeed, "speed", "rad/s"), (rc.AppliedTorque, "torque", "N m")],
)
@pytest.mark.parametrize(("rows", "value", "allowed"), TABLES)
def test_a_wrong_table_is_refused_by_name_and_row(motion, field, unit, rows, value, allowed):
    with pytest.raises(rc.InvalidInput) as caught:
        motion(rows)
    message = str(caught.value)
    assert message.startswith(f"{motion.__name__}.{field}")
    assert allowed.format(unit=unit) in message
    assert value is None or f" = {value}: " in message


@pytest.mark.parametrize("given", [np.array([20.0]), np.array([20.0, 30.0]), [20.0]])
def test_numbers_in_a_row_are_told_as_they_were_given(given):
    for motion, where, expected in (
        (rc.PrescribedSpeed, "speed", "one number, or rows of (time, value)"),
        (rc.AppliedTorque, "torque", "one number, or rows of (time, value)"),
        (rc.AppliedTorque, "curve", "rows of (speed, value)"),
    ):
        with pytest.raises(rc.InvalidInput) as caught:
            motion(**{where: given})
        said = f"{motion.__name__}.{where} = {given!r}: must be {expected}"
        assert str(caught.value) == said


@pytest.mark.parametrize("teeth", [4, 1001])
def test_teeth_beyond_a_profile_are_told_its_range(teeth):
    says = f"Sprocket.teeth = {teeth}: must be between 5 and 1000, the range of AnsiTooth$"
    with pytest.raises(rc.InvalidInput, match=says):
        rc.Sprocket(teeth)


def test_what_is_no_curve_is_told_every_form():
    says = r"curve = 'x': must be a number in N m, or rows \(speed, value\), or a Table$"
    with pytest.raises(rc.InvalidInput, match=says):
        rc.AppliedTorque(curve="x")


def test_a_pivot_that_does_not_tighten_is_told_with_the_direction_of_its_arm():
    pair = rc.two_sprocket_drive("ANSI 40", teeth=(17, 25), links=60, speed=10.0)
    x, y = pair.sprockets[1].center
    tensioner = rc.Tensioner(25.0, pivot=(x + 0.2, y))
    with pytest.raises(rc.InvalidInput) as caught:
        replace(pair, tensioner=tensioner).check()
    assert str(caught.value) == (
        f"Tensioner.pivot = ({x + 0.2}, {y:g}): must tighten the chain: its arm moves sprocket 2 "
        "along (0.0000, -1.0000), which takes up 0.000 of its displacement; along (1.0000, 0.0000) "
        "it takes up 1.996"
    )


def sprockets(**changes):
    return [replace(sprocket, **changes) for sprocket in DRIVE.sprockets]


HINGE = DRIVE.chain.hinge
COMBINATIONS = {
    "bore no larger than pin": (
        lambda: replace(HINGE, pin_radius=2.245e-3),
        "ClearanceHinge.bore_radius",
        2.245e-3,
        "must be larger than the pin's, 0.002245 m",
    ),
    "bore inside the bushing's wall": (
        lambda: replace(DRIVE.chain, bushing_radius=2.2e-3),
        "Chain.bushing_radius",
        2.2e-3,
        "must be larger than the bore's, 0.002245 m",
    ),
    "bushings overlap": (
        lambda: replace(DRIVE.chain, bushing_radius=6.35e-3),
        "Chain.bushing_radius",
        6.35e-3,
        "must be below half the pitch, 0.00635 m",
    ),
    "no tolerance at all": (
        lambda: rc.Solver(rtol=1e-6, atol=0.0),
        "Solver.atol",
        0.0,
        "must be positive: coordinates and speeds pass through zero, where rtol allows no error",
    ),
    "two speeds": (
        lambda: rc.Sprocket(teeth=17, motion=rc.PrescribedSpeed(1.0), initial_speed=2.0),
        "Sprocket.initial_speed",
        2.0,
        "must be absent when the motion is a PrescribedSpeed",
    ),
    "a tensioner on no sprocket": (
        lambda: replace(DRIVE, tensioner=rc.Tensioner(25.0, sprocket=3)),
        "Tensioner.sprocket",
        3,
        "1 to 2",
    ),
    "a tensioner counted from 0": (
        lambda: replace(DRIVE, tensioner=rc.Tensioner(25.0, sprocket=0)),
        "Tensioner.sprocket",
        0,
        "1 to 2",
    ),
    "a tensioner on a floating sprocket": (
        lambda: replace(TENSIONED, sprockets=sprockets(bearing="floating")),
        "Tensioner.sprocket",
        2,
        'a tensioner moves one with bearing="fixed"',
    ),
    "a tooth cut for a roller as large as the pitch": (
        lambda: rc.Simulation(
            replace(DRIVE, sprockets=sprockets(profile=rc.AnsiTooth(roller_diameter=0.02)))
        ),
        "AnsiTooth.roller_diameter",
        0.02,
        "must be",
    ),
    "a seat too narrow for the bushing": (
        lambda: rc.Simulation(
            replace(DRIVE, sprockets=sprockets(profile=rc.AnsiTooth(roller_diameter=0.0078)))
        ),
        "AnsiTooth.roller_diameter",
        0.0078,
        "must be",
    ),
}


@pytest.mark.parametrize("case", COMBINATIONS)
def test_values_that_do_not_go_together_are_refused_by_name(case):
    build, name, value, allowed = COMBINATIONS[case]
    with pytest.raises(rc.InvalidInput) as caught:
        build()
    assert_refused(caught.value, name, value, allowed)


@pytest.mark.parametrize("number", [0, 1])
def test_a_drive_has_two_sprockets_at_least(number):
    with pytest.raises(rc.InvalidInput, match=rf"ChainDrive.sprockets = {number} .*at least two"):
        replace(DRIVE, sprockets=DRIVE.sprockets[:1] * number)


def test_a_sprocket_that_is_none_is_refused_by_its_place():
    with pytest.raises(rc.InvalidInput, match=r"ChainDrive.sprockets.2 = 17: must be a Spro"):
        replace(DRIVE, sprockets=[DRIVE.sprockets[0], 17])


def test_a_law_without_an_elastic_part_is_refused():
    with pytest.raises(rc.InvalidInput, match="ForceLaw"):
        rc.ForceLaw()


def test_values_at_the_ends_of_their_ranges_are_taken():
    rc.Material(poisson_ratio=0.0, restitution=0.0)
    rc.Material(poisson_ratio=0.5, restitution=1.0)
    rc.Solver(rtol=0.0, max_step=INF, max_order=1)
    rc.Solver(atol=1e-15, max_order=12)
    rc.Solver(rtol=1e-15, accuracy=1e-4)
    rc.Tensioner(pretension=0.0, ramp_time=0.0, damping=0.0)
    rc.Sprocket(teeth=5, initial_speed=-1.0)
    rc.Sprocket(teeth=np.int64(1000), mass=np.float32(0.5), center=np.zeros(2))
    replace(DRIVE.chain, links=4)
