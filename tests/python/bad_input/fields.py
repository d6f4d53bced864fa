"""One good description of each type, and the wrong values of each of its fields."""

import numpy as np

import rustchain as rc
from bad_input.values import (
    FINITE,
    INF,
    NAN,
    NO_COUNT,
    NO_NUMBER,
    NO_OPTION,
    NO_TEXT,
    NO_VECTOR,
    POSITIVE,
    allowed_count,
    count,
    instance,
    not_negative,
    optional_positive,
    positive,
    table,
    vector,
    within,
    word,
)

DRIVE = rc.paper_drive()
TENSIONED = rc.paper_drive(pretension=25.0)
ROLLER = rc.paper_drive(rollers="bodies").chain.roller

# One good description of each type.
GOOD = {
    type(description).__name__: description
    for description in (
        rc.Material(),
        rc.Link(mass=1.0, inertia=1.0),
        rc.Plates(3.7e-5, 3.2e-5),
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
        rc.AnchoredEnd((0.0, 0.0)),
        rc.LoadedEnd(2.0),
        rc.FreeEnd(),
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
        rc.LubricantFilm(0.1),
        ROLLER,
        rc.Solver(),
        rc.HingeForceAbove(1.0),
        rc.ToothForceAbove(1.0),
        rc.StrandSlack(),
        rc.ToothJump(),
        rc.TimeReached(1.0),
    )
}

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
    "film": instance("LubricantFilm", rc.Hertz()),
}
COEFFICIENT = [
    *[
        (value, "must be a positive number; for no friction, leave the law out")
        for value in POSITIVE
    ],
    *[(value, "must be a number in newton a newton") for value in NO_NUMBER],
]

LINKS_OF_END = [
    *[(value, allowed_count(value)) for value in NO_COUNT if value is not None],
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
            *[(value, allowed_count(value)) for value in NO_COUNT],
            *[(value, "must be between 4 and 100000") for value in (0, 2)],
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
        "seed": [(value, allowed_count(value)) for value in NO_COUNT],
        "roller": instance("Roller", DRIVE.chain.hinge),
        "link_stiffness": [
            *[(value, "must be a positive number in N/m") for value in POSITIVE],
            *[(value, "must be a number in N/m, or Plates") for value in NO_OPTION],
        ],
        "carried": [
            *[(value, "must be rows (number of the link") for value in (None, 3, "ab", object)],
            ([5], "must be rows (number of the link"),
        ],
    },
    "Plates": {
        "inner_section": positive("m^2"),
        "outer_section": positive("m^2"),
        "elastic_modulus": optional_positive("Pa"),
    },
    "Roller": {
        "radius": positive("m"),
        "bore_radius": positive("m"),
        "length": positive("m"),
        "mass": positive("kg"),
        "inertia": positive("kg m^2"),
    },
    "LubricantFilm": {
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
            *[
                (value, 'must be a number from 0 to 1, or "minimum" or "maximum"')
                for value in ("", "1", "medium")
            ],
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
            "PrescribedSpeed or an AppliedTorque or a Free", None, rc.Free, 12.566, rc.AnsiTooth()
        ),
        "profile": instance(
            "AnsiTooth or an IsoTooth or a StraightTooth or a CustomTooth", None, rc.AnsiTooth
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
        "sprocket": [(value, allowed_count(value)) for value in NO_COUNT],
        "ramp_time": not_negative("s"),
        "damping": not_negative("N s/m"),
        "direction": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
            *[(value, "must be a direction") for value in ((0.0, 0.0), (NAN, 1.0), (1.0, INF))],
        ],
        "stiffness": not_negative("N/m"),
        "travel": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if value is not None],
            *[(value, "the travel of the centre") for value in ((0, 0), (NAN, 1.0), (-1, 2))],
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
            *[(value, "the travel of the plunger") for value in ((0, 0), (NAN, 1.0), (-1, 2))],
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
    "AnchoredEnd": {
        "position": vector("m"),
        "velocity": [
            *[(value, "two numbers (x, y)") for value in NO_VECTOR if np.ndim(value) < 2],
            ([(0.0, 1.0)], "each row must be (time, x, y)"),
        ],
        "links": LINKS_OF_END,
    },
    "LoadedEnd": {
        "mass": positive("kg"),
        "inertia": optional_positive("kg m^2"),
        "arm": not_negative("m"),
        "position": [case for case in vector("m") if case[0] is not None],
        "links": LINKS_OF_END,
    },
    "FreeEnd": {
        "position": [case for case in vector("m") if case[0] is not None],
        "links": LINKS_OF_END,
    },
    "ChainDrive": {
        "ends": [
            *[(value, "must be None, or two of") for value in (2, "abc", (), (rc.FreeEnd(),))],
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
        "rtol": [
            *[case for case in not_negative("relative units") if case[0] is not None],
            (1e-16, "is below rounding; must be zero, or 1e-15 or more"),
        ],
        "atol": [
            case for case in not_negative("the unit of each component") if case[0] is not None
        ],
        "max_step": [
            *[(value, "must be a positive number") for value in (NAN, -1.0, 0, -INF)],
            *[(value, "must be a number in s") for value in NO_NUMBER],
        ],
        "max_order": count(1, 12, 0, 13),
        "accuracy": [
            *positive("m"),
            *[(value, "must be at most 0.0001 m") for value in (1.0, 1.1e-4)],
        ],
    },
    "HingeForceAbove": {"force": positive("N"), "hinge": NUMBER_OR_NONE},
    "ToothForceAbove": {"force": positive("N"), "bushing": NUMBER_OR_NONE},
    "StrandSlack": {
        "tension": not_negative("N"),
        "strand": [(value, "must be text, or None") for value in NO_TEXT if value is not None],
        "lasting": not_negative("s"),
        "from_start": [(value, "must be True or False") for value in (None, 1, 0.0, "yes")],
    },
    "ToothJump": {"sprocket": NUMBER_OR_NONE},
    "TimeReached": {"time": positive("s")},
}
