"""Wrong values: every field of every description and every argument, refused by name."""

import contextlib
import dataclasses
import math
import re
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

NAN, INF = math.nan, math.inf

DRIVE = rc.paper_drive()
TENSIONED = rc.paper_drive(pretension=25.0)
ROLLER = rc.paper_drive(rollers="bodies").chain.roller


def fields_of(description):
    return {f.name: getattr(description, f.name) for f in dataclasses.fields(description)}


# One good description of each type.
GOOD = {
    type(description).__name__: description
    for description in (
        rc.Material(),
        rc.Link(mass=1.0, inertia=1.0),
        rc.ClearanceHinge(pin_radius=2.22e-3, bore_radius=2.245e-3, length=0.011),
        DRIVE.chain,
        rc.AnsiTooth(),
        rc.IsoTooth(),
        rc.StraightTooth(flank_angle=0.4),
        rc.CustomTooth([rc.ToothLine((0.0, 0.03), (0.001, 0.03))]),
        rc.ToothLine((0.0, 0.03), (0.001, 0.03)),
        rc.ToothArc((0.0, 0.03), (0.001, 0.031), (0.0, 0.031)),
        rc.PrescribedSpeed(1.0),
        rc.AppliedTorque(1.0),
        rc.Free(),
        rc.Sprocket(teeth=17),
        rc.Tensioner(pretension=25.0),
        rc.GuideArm((0.0, 0.0), 10.0),
        rc.GuideRail((0.1, 0.0), (0.0, 1.0), length=0.1, radius=0.3),
        rc.SmoothIdler(0.02, (0.0, 0.0)),
        rc.Anchor((0.0, 0.0)),
        rc.Load(2.0),
        rc.LooseEnd(),
        DRIVE,
        rc.LankaraniNikravesh(),
        rc.Hertz(),
        rc.Johnson(),
        rc.EnhancedCylinder(),
        rc.HertzCylinder(),
        rc.Radzimovsky(),
        rc.Esdu78035(),
        rc.LiuConformal(),
        rc.Linear(stiffness=1e8),
        rc.Coulomb(0.1, "ambrosio"),
        rc.LuGre(0.2, 0.1),
        rc.Film(0.1),
        ROLLER,
        rc.Solver(),
        rc.HingeForceAbove(1.0),
        rc.ToothForceAbove(1.0),
        rc.StrandSlack(),
        rc.TimeReached(1.0),
    )
}

# What a field may hold, in words for the table below: wrong values and what the message allows.
NO_NUMBER = ["1", b"1", None, True, (1.0, 2.0), [], 1 + 2j, object, np.array([1.0])]
NO_OPTION = [value for value in NO_NUMBER if value is not None]
POSITIVE = [NAN, INF, -INF, -1.0, -1, 0.0, 0, np.float32("nan")]
NOT_NEGATIVE = [NAN, INF, -INF, -1.0, -1, -1e-300]
FINITE = [NAN, INF, -INF]
NO_COUNT = ["17", None, True, 17.0, 17.5, NAN, -1, 2**40, 10**400, (17,)]
NO_VECTOR = [None, 1.0, "ab", (), (1.0,), (1.0, 2.0, 3.0), [[1.0, 2.0]], np.zeros(3)]
NO_TEXT = [None, 1, 1.5, True, ("a",), b"a", object]
NO_WORD = [1, True, "", "none", ("kept",), b"kept", NAN]


def positive(unit):
    return [
        *[(value, f"must be a positive number in {unit}") for value in POSITIVE],
        *[(value, f"must be a number in {unit}") for value in NO_NUMBER],
    ]


def optional_positive(unit):
    return [case for case in positive(unit) if case[0] is not None]


def not_negative(unit):
    return [
        *[(value, f"must be zero or a positive number in {unit}") for value in NOT_NEGATIVE],
        *[(value, f"must be a number in {unit}") for value in NO_NUMBER],
    ]


def within(low, high, *outside):
    return [
        *[(value, f"must be between {low} and {high}") for value in (*FINITE, *outside)],
        *[(value, "must be a number") for value in NO_NUMBER],
    ]


def count(low, high, *outside):
    return [
        *[(value, f"must be between {low} and {high}") for value in outside],
        *[(value, "must be a whole number") for value in NO_COUNT],
    ]


def vector(unit):
    return [(value, f"must be two numbers (x, y) in {unit}") for value in NO_VECTOR]


def word(*allowed):
    text = " or ".join(f'"{each}"' if each else "None" for each in allowed)
    return [
        (value, f"must be {text}") for value in [*NO_WORD, *([] if None in allowed else [None])]
    ]


def instance(kind, *others):
    wrong = [1.0, "x", (), object, *others]
    return [(value, f"must be a {kind}") for value in wrong]


def table(unit):
    return [
        *[(value, f"must be a finite number in {unit}") for value in FINITE],
        *[(value, f"must be a number in {unit}") for value in ("1", None, True, 1 + 2j, object)],
    ]


TEXT = [(value, "must be text") for value in NO_TEXT]
SEAT = word("bottom-diameter", "pitch-circle")
DAMPING = word(
    "hunt-crossley",
    "lankarani-nikravesh",
    "herbert-mcwhannell",
    "lee-wang",
    "flores",
    "gonthier",
    "hu-guo",
    "zhiying-qishao",
    None,
)
NUMBER_OR_NONE = [
    (value, "must be a whole number from 1 on, or None")
    for value in ("17", True, 17.0, NAN, -1, 0, (17,))
]
REGIONS = word("kept", "sharp")
LAW = {
    "damping": DAMPING,
    "regions": REGIONS,
    "friction": instance("Coulomb or a LuGre", rc.Hertz()),
    "film": instance("Film", rc.Hertz()),
}
COEFFICIENT = [
    *[
        (value, "must be a positive number; for no friction, leave the law out")
        for value in POSITIVE
    ],
    *[(value, "must be a number in newton a newton") for value in NO_NUMBER],
]

LINKS_OF_END = [
    *[(value, "must be a whole number") for value in NO_COUNT if value is not None],
    (0, "must be one at least"),
]
FIELDS = {
    "Material": {
        "elastic_modulus": positive("Pa"),
        "poisson_ratio": within(0, 0.5, -0.1, 0.5000001),
        "restitution": within(0, 1, -1e-9, 1.1),
    },
    "Link": {"mass": positive("kg"), "inertia": positive("kg m^2")},
    "ClearanceHinge": {
        "pin_radius": positive("m"),
        "bore_radius": positive("m"),
        "length": positive("m"),
    },
    "Chain": {
        "pitch": positive("m"),
        "links": [
            *[(value, "must be a whole number") for value in NO_COUNT],
            *[(value, "must be between 4 and 1000000") for value in (0, 2)],
        ],
        "inner": instance("Link", None, DRIVE.chain.material),
        "outer": instance("Link", None, DRIVE.chain.hinge),
        "hinge": instance("ClearanceHinge", None, DRIVE.chain.inner),
        "bushing_radius": positive("m"),
        "tooth_contact_length": positive("m"),
        "material": instance("Material", None, DRIVE.chain.inner),
        "name": TEXT,
        "offset": instance("Link", DRIVE.chain.hinge),
        "strands": count(1, 24, 0, 25),
        "elongation": [
            *[(value, "must be between -0.02 and 0.1") for value in (*FINITE, -0.03, 0.2)],
            *[(value, "must be a number") for value in ("1", None, True, 1 + 2j, object)],
        ],
        "pitch_spread": within(0, 0.01, -1e-9, 0.011),
        "seed": [(value, "must be a whole number") for value in NO_COUNT],
        "roller": instance("Roller", DRIVE.chain.hinge),
        "link_stiffness": optional_positive("N/m"),
    },
    "Roller": {
        "radius": positive("m"),
        "bore_radius": positive("m"),
        "length": positive("m"),
        "mass": positive("kg"),
        "inertia": positive("kg m^2"),
    },
    "Film": {
        "viscosity": [
            *[
                (v, "must be a positive number; for dry hinges, leave the film out")
                for v in POSITIVE
            ],
            *[(value, "must be a number in Pa s") for value in NO_NUMBER],
        ],
        "length": optional_positive("m"),
        "handover": [
            *[(value, "must be from 0.1 to 0.99") for value in (*FINITE, 0.05, 1.0)],
            *[(value, "must be a number") for value in NO_NUMBER],
        ],
        "tension": not_negative("Pa"),
    },
    "AnsiTooth": {
        "seat": SEAT,
        "roller_diameter": optional_positive("m"),
        "tip": word("full", "cut"),
        "edge_radius": optional_positive("m"),
    },
    "IsoTooth": {
        "gap": [
            *[(value, "must be between 0 and 1") for value in (*FINITE, -0.1, 1.1)],
            *[(value, 'must be "minimum" or "maximum"') for value in ("", "1", "medium")],
            *[(value, "must be a number") for value in (None, True, (), object)],
        ],
        "seat": SEAT,
        "roller_diameter": optional_positive("m"),
        "tip_diameter": optional_positive("m"),
        "edge_radius": optional_positive("m"),
    },
    "StraightTooth": {
        "flank_angle": within(0, 1.2, -0.1, 1.3),
        "seat_radius": optional_positive("m"),
        "seat": SEAT,
        "roller_diameter": optional_positive("m"),
        "tip_diameter": optional_positive("m"),
        "edge_radius": optional_positive("m"),
    },
    "CustomTooth": {
        "pieces": [
            (value, "must be a sequence of ToothLine and ToothArc")
            for value in (None, 2, "ab", object, rc.ToothLine)
        ],
        "tip_diameter": optional_positive("m"),
        "edge_radius": optional_positive("m"),
    },
    "ToothLine": {"start": vector("m"), "end": vector("m")},
    "ToothArc": {"start": vector("m"), "end": vector("m"), "center": vector("m")},
    "PrescribedSpeed": {"speed": table("rad/s")},
    "AppliedTorque": {
        "torque": table("N m"),
        "curve": [case for case in table("N m") if case[0] is not None],
    },
    "Free": {},
    "Sprocket": {
        "teeth": count(5, 1000, 0, 4, 1001),
        "center": vector("m"),
        "motion": instance(
            "PrescribedSpeed or a AppliedTorque or a Free", None, rc.Free, 12.566, rc.AnsiTooth()
        ),
        "profile": instance(
            "AnsiTooth or a IsoTooth or a StraightTooth or a CustomTooth", None, rc.AnsiTooth
        ),
        "mass": optional_positive("kg"),
        "inertia": optional_positive("kg m^2"),
        "initial_speed": [
            *[(value, "must be a finite number in rad/s") for value in FINITE],
            *[(value, "must be a number in rad/s") for value in NO_OPTION],
        ],
        "bearing": word("fixed", "floating"),
        "side": word("inside", "outside"),
        "load_inertia": not_negative("kg m^2"),
        "eccentricity": within(0, 1, -1e-9, 1.1),
        "eccentricity_angle": [
            *[(value, "must be a finite number in rad") for value in FINITE],
            *[(value, "must be a number in rad") for value in NO_NUMBER],
        ],
        "damaged_teeth": [
            (value, "must be rows (number of the tooth from 0") for value in (None, 3, "ab", object)
        ],
    },
    "Tensioner": {
        "pretension": not_negative("N"),
        "sprocket": [(value, "must be a whole number") for value in NO_COUNT],
        "ramp_time": not_negative("s"),
        "damping": not_negative("N s/m"),
        "direction": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
            *[(value, "must be a direction") for value in ((0.0, 0.0), (NAN, 1.0), (1.0, INF))],
        ],
        "stiffness": not_negative("N/m"),
        "travel": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
            *[(value, "how far the centre can move") for value in ((0, 0), (NAN, 1.0), (-1, 2))],
        ],
        "pivot": [(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
        "arm_inertia": [*not_negative("kg m^2"), (1.0, "must be 0 without a pivot")],
        "damping_back": [case for case in not_negative("N s/m") if case[0] is not None],
        "ratchet": [case for case in not_negative("m") if case[0] is not None],
    },
    "GuideArm": {
        "pivot": vector("m"),
        "force": not_negative("N"),
        "ramp_time": not_negative("s"),
        "stiffness": not_negative("N/m"),
        "damping": not_negative("N s/m"),
        "damping_back": [case for case in not_negative("N s/m") if case[0] is not None],
        "travel": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
            *[(value, "how far the plunger can go") for value in ((0, 0), (NAN, 1.0), (-1, 2))],
        ],
        "inertia": positive("kg m^2"),
        "ratchet": [case for case in not_negative("m") if case[0] is not None],
    },
    "GuideRail": {
        "center": vector("m"),
        "direction": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR],
            *[(value, "must be a direction") for value in ((0.0, 0.0), (NAN, 1.0), (1.0, INF))],
        ],
        "length": positive("m"),
        "radius": [
            *[(value, "must be a finite number in m") for value in (NAN, INF, -INF)],
            *[(value, "must be above half the length, 0.05 m") for value in (0.0, 0.05, -0.03)],
            *[(value, "must be a number in m") for value in NO_OPTION],
        ],
        "end_radius": positive("m"),
        "arm": instance("GuideArm", rc.GuideArm),
        "material": instance("Material", rc.Material),
        "plate_height": optional_positive("m"),
    },
    "SmoothIdler": {
        "material": instance("Material", rc.Material),
        "radius": positive("m"),
        "center": vector("m"),
        "inertia": optional_positive("kg m^2"),
        "plate_height": optional_positive("m"),
    },
    "Anchor": {
        "position": vector("m"),
        "velocity": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if np.ndim(value) < 2],
            ([(0.0, 1.0)], "each row must be (time, x, y)"),
        ],
        "links": LINKS_OF_END,
    },
    "Load": {
        "mass": positive("kg"),
        "inertia": optional_positive("kg m^2"),
        "arm": not_negative("m"),
        "position": [case for case in vector("m") if case[0] is not None],
        "links": LINKS_OF_END,
    },
    "LooseEnd": {
        "position": [case for case in vector("m") if case[0] is not None],
        "links": LINKS_OF_END,
    },
    "ChainDrive": {
        "ends": [
            *[(value, "must be None, or two of") for value in (2, "abc", (), (rc.LooseEnd(),))],
        ],
        "guides": [(value, "must be a sequence of GuideRail") for value in (None, 2, "ab", object)],
        "chain": instance("Chain", None, DRIVE, "ANSI 40"),
        "sprockets": [
            *[(value, "must be a sequence of Sprocket") for value in (None, 2, "ab", object)],
            (DRIVE.sprockets[0], "must be a sequence of Sprocket"),
        ],
        "tensioner": instance("Tensioner", 25.0, rc.Tensioner),
        "gravity": vector("m/s^2"),
        "hinges": word("clearance", "ideal"),
        "name": TEXT,
    },
    "LankaraniNikravesh": LAW,
    "Hertz": LAW,
    "Johnson": LAW,
    "EnhancedCylinder": {**LAW, "coefficients": word("2010", "2015")},
    "HertzCylinder": LAW,
    "Radzimovsky": LAW,
    "Esdu78035": LAW,
    "LiuConformal": LAW,
    "Linear": {**LAW, "stiffness": positive("N/m")},
    "Coulomb": {
        "coefficient": COEFFICIENT,
        "regularization": word("tanh", "threlfall", "ambrosio"),
        "speed": positive("m/s"),
        "dead_speed": not_negative("m/s"),
    },
    "LuGre": {
        "static_coefficient": COEFFICIENT,
        "kinetic_coefficient": [*COEFFICIENT, (0.3, "must be at most static_coefficient, 0.2")],
        "stiffness": positive("1/m"),
        "damping": not_negative("s/m"),
        "viscous_coefficient": not_negative("s/m"),
        "stribeck_speed": positive("m/s"),
        "stribeck_exponent": [
            *[(value, "must be from 0.1 to 10") for value in (*FINITE, 0.05, 11.0)],
            *[(value, "must be a number") for value in NO_NUMBER],
        ],
    },
    "Solver": {
        "method": word("auto", "pece", "newton"),
        "rtol": [case for case in not_negative("relative units") if case[0] is not None],
        "atol": [
            case for case in not_negative("the unit of each component") if case[0] is not None
        ],
        "max_step": [
            *[(value, "must be a positive number") for value in (NAN, -1.0, 0, -INF)],
            *[(value, "must be a number in s") for value in NO_NUMBER],
        ],
        "max_order": count(1, 12, 0, 13),
        "accuracy": positive("m"),
    },
    "HingeForceAbove": {"force": positive("N"), "hinge": NUMBER_OR_NONE},
    "ToothForceAbove": {"force": positive("N"), "bushing": NUMBER_OR_NONE},
    "StrandSlack": {
        "tension": not_negative("N"),
        "strand": [(value, "must be text, or None") for value in NO_TEXT if value is not None],
        "lasting": not_negative("s"),
        "from_start": [(value, "must be True or False") for value in (None, 1, 0.0, "yes")],
    },
    "TimeReached": {"time": positive("s")},
}


def shown(value):
    """The value as a message may show it: as the description holds it."""
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    return tuple(map(shown, value)) if isinstance(value, list | tuple) else value


def numbers(text):
    """The numbers in a text, so that "(0, NaN)" and "(0.0, nan)" are the same."""
    words = re.findall(r"[^\s(),]+", text)
    with contextlib.suppress(ValueError):
        return [repr(float(word)) for word in words]
    return words


def assert_refused(error, name, value, allowed):
    """The message reads ``name = value: what is allowed``."""
    message = str(error)
    said = re.fullmatch(r"(.+?) = (.*?): (.+)", message, flags=re.DOTALL)
    assert said, message
    assert said[1] == name
    assert allowed in said[3], message
    assert said[2] == repr(value) or numbers(said[2]) == numbers(repr(value)), message


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
    public -= {rc.ForceLaw, rc.StopCondition}  # only their subclasses can be made
    public -= below(rc.Table.__mro__[1])  # parts of mechanisms, checked when these are put together
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
    with pytest.raises(TypeError, match="positional argument"):
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
    ((1.0, 2.0), None, "each row must be (time, value)"),
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
        lambda: rc.Solver(rtol=0.0, atol=0.0),
        "Solver.atol",
        0.0,
        "rtol and atol must not both be zero",
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
    with pytest.raises(rc.InvalidInput, match=r"ChainDrive.sprockets\[1\] = 17: must be a Spro"):
        replace(DRIVE, sprockets=[DRIVE.sprockets[0], 17])


def test_a_law_without_an_elastic_part_is_refused():
    with pytest.raises(rc.InvalidInput, match="ForceLaw"):
        rc.ForceLaw()


def test_values_at_the_ends_of_their_ranges_are_taken():
    rc.Material(poisson_ratio=0.0, restitution=0.0)
    rc.Material(poisson_ratio=0.5, restitution=1.0)
    rc.Solver(rtol=0.0, max_step=INF, max_order=1)
    rc.Solver(atol=0.0, max_order=12)
    rc.Tensioner(pretension=0.0, ramp_time=0.0, damping=0.0)
    rc.Sprocket(teeth=5, initial_speed=-1.0)
    rc.Sprocket(teeth=np.int64(1000), mass=np.float32(0.5), center=np.zeros(2))
    replace(DRIVE.chain, links=4)


# --- Simulation

LAWS = "LankaraniNikravesh or a Hertz or a Johnson or a EnhancedCylinder or a HertzCylinder"
SIMULATION = [
    *[("drive", value, "must be a ChainDrive") for value in (None, "paper", 1)],
    ("drive", DRIVE.chain, "must be a ChainDrive"),
    *[
        (argument, value, f"must be a {LAWS}")
        for argument in ("force_law", "hinge_law", "tooth_law")
        for value in ("hertz", rc.Hertz, 1, 0, "", False)
    ],
    ("force_law", None, f"must be a {LAWS}"),
    *[
        ("min_approach_speed", value, "must be a positive number in m/s")
        for value in (NAN, INF, -1e-3, 0.0)
    ],
    *[
        ("min_approach_speed", value, "must be a number in m/s")
        for value in ("1e-3", None, True, 1j)
    ],
    *[("solver", value, "must be a Solver") for value in (None, "pece", rc.Solver, 1e-5)],
]


@pytest.mark.parametrize(("argument", "value", "allowed"), SIMULATION)
def test_a_wrong_argument_of_a_simulation_is_refused_by_name(argument, value, allowed):
    with pytest.raises(rc.InvalidInput) as caught:
        rc.Simulation(**{"drive": DRIVE, argument: value})
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


@pytest.mark.parametrize(
    ("body", "velocity", "message"),
    [
        (38, (1e-6, 0.0, 4 * math.pi), r"velocities of sprocket_1 = \(0.000001, 0\): .*fixed"),
        (38, (0.0, -1.0, 4 * math.pi), r"velocities of sprocket_1 = \(0, -1\): .*fixed"),
        (38, (0.0, 0.0, 12.0), r"velocities of sprocket_1 = 12: .*prescribed: must be 12.566"),
        (39, (0.0, 1e-3, 12.0), r"velocities of sprocket_2 = \(0, 0.001\): .*slide"),
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
    *[("duration", value, "must be a number in s") for value in ("1", None, True, 1j)],
    *[("report_step", value, "must be a positive number in s") for value in (NAN, INF, -1e-4, 0)],
    *[("report_step", value, "must be a number in s") for value in ("1", None, True, 1j)],
    ("report_step", 1e-20, "more than 1e9 reports"),
    *[("energy", value, "must be True or False") for value in ("no", None, 2)],
    *[("t", value, "must be a number in s") for value in ("1", None, True, 1j)],
    *[("t", value, "must not lie before the present time, 0.0005 s") for value in (0.0, 4.9e-4)],
    *[("t", value, "must be a finite number in s") for value in (NAN, INF, -INF)],
    *[("time", value, "must be a number in s") for value in ("1", True, 1j)],
    *[("time", value, "must be a finite number in s") for value in (NAN, INF)],
]


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
        (None, "record"),
    ],
)
def test_an_unknown_group_is_refused_with_the_nearest(record, message, beginning):
    with pytest.raises(rc.InvalidInput, match=message) as caught:
        CALLS["record"](beginning, record)
    assert str(caught.value).startswith("record")


def two_sprockets(**changes):
    return rc.two_sprocket_drive(**{"links": 60, **changes})


def by_distance(**changes):
    return rc.two_sprocket_drive(**{"center_distance": 0.25, **changes})


GENERATORS = [
    *[
        (rc.paper_drive, {"pretension": value}, "retension")
        for value in ("1", NAN, INF, -1.0, True)
    ],
    *[(two_sprockets, {"chain": value}, "chain") for value in (1, None, 40.0, rc.Chain, "ANSI 43")],
    *[
        (two_sprockets, {"teeth": value}, "teeth")
        for value in (17, (17,), (17, 25, 30), (17.5, 25), (4, 25), (17, 1001), "ab", (NAN, 17))
    ],
    *[(two_sprockets, {"links": value}, "links") for value in ("60", 60.5, -2, 0, NAN, 2**40)],
    *[(two_sprockets, {"center_distance": value}, "cent") for value in ("1", NAN, INF, 1j)],
    *[(by_distance, {"center_distance": value}, "cent") for value in ("1", NAN, INF, -1.0, 0.0)],
    *[(two_sprockets, {"speed": value}, "speed") for value in ("1", NAN, None, ((0.0,),))],
    *[(two_sprockets, {"torque": value}, "torque") for value in ("1", NAN, ())],
    *[(two_sprockets, {"pretension": value}, "retension") for value in ("1", NAN, -1.0)],
    *[(two_sprockets, {"seat": value}, "seat") for value in ("x", None, 1)],
    *[(two_sprockets, {"gravity": value}, "gravity") for value in (9.81, (0.0, NAN), (0, 0, 9.81))],
]


@pytest.mark.parametrize(("function", "keyword", "name"), GENERATORS)
def test_a_wrong_argument_of_a_generator_is_refused_by_name(function, keyword, name):
    with pytest.raises(rc.InvalidInput, match=name) as caught:
        function(**keyword)
    assert re.search("must be|must increase|needs at|too few|not in the cat", str(caught.value))


def test_center_distances_at_which_sprockets_overlap_are_refused_by_the_check():
    for distance in (-1.0, 0.0, 0.05):
        with pytest.raises(rc.InvalidInput, match=r"\d m"):
            two_sprockets(center_distance=distance).check()


@pytest.mark.parametrize("links", ["60", None, -2, 60.5, NAN])
def test_wrong_links_of_a_catalogue_chain_are_refused_by_name(links):
    with pytest.raises(rc.InvalidInput, match="links"):
        rc.catalogue_chain("ANSI 40", links)


@pytest.mark.parametrize("name", [40, None, "", "ANSI", "BS 40"])
def test_a_name_that_is_not_in_the_catalogue_is_refused(name):
    with pytest.raises(rc.InvalidInput, match="catalogue"):
        rc.catalogue_chain(name, 60)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"damaged_teeth": [(17, 0.5)]}, r"damaged_teeth = 17: .* 0 to 16"),
        ({"damaged_teeth": [(3, 0.5), (3, 0.2)]}, "each tooth once"),
        ({"damaged_teeth": [(3, 1.5)]}, r"damaged_teeth = 1\.5: must be between 0 and 1"),
        ({"damaged_teeth": [3]}, "must be rows"),
        ({"eccentricity": 0.01}, r"eccentricity = 0\.01: must be below half the pitch"),
        ({"profile": rc.IsoTooth(), "teeth": 8}, "must be between 9 and 150"),
        ({"profile": rc.IsoTooth(tip_diameter=0.05)}, "above the pitch diameter"),
        ({"profile": rc.IsoTooth(roller_diameter=0.0076)}, "seat wider than the bushing"),
        ({"profile": rc.StraightTooth(1.0)}, "pointed"),
    ],
)
def test_teeth_that_cannot_be_are_refused_when_the_drive_is_made(change, words):
    wrong = {"teeth": 17} | change
    with pytest.raises(rc.InvalidInput, match=words):
        replace(DRIVE, sprockets=[rc.Sprocket(**wrong), DRIVE.sprockets[1]])


def test_elongations_of_another_number_of_links_are_refused():
    with pytest.raises(rc.InvalidInput, match="one for each of the 38 links"):
        replace(DRIVE.chain, elongation=(0.0, 0.001, 0.002))
    with pytest.raises(rc.InvalidInput, match="offset"):
        replace(DRIVE.chain, offset=rc.Link(1.0, 1.0))
