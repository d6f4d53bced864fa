"""Inputs of drives in another unit than SI are told; `test_mechanism_input` has mechanisms."""

import re
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import rustchain as rc
from rustchain.description.plausibility import implausible_inputs

DRIVE = rc.paper_drive(25.0)
CHAIN = DRIVE.chain


def of_chain(**changed):
    return replace(DRIVE, chain=replace(CHAIN, **changed))


def of_load(**changed):
    driver, driven = DRIVE.sprockets
    return replace(DRIVE, sprockets=(driver, replace(driven, **changed)))


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        (replace(DRIVE, gravity=(0.0, -9810.0)), r"gravity = 9810 m/s\^2: about 9.81 is usual"),
        (replace(DRIVE, gravity=(0.0, -9.81e-3)), r"gravity = 0.00981 m/s\^2: about 9.81"),
        (of_chain(material=rc.Material(207.0)), "chain.material.elastic_modulus = 207 Pa: .*GPa"),
        (of_chain(material=rc.Material(207e3)), "elastic_modulus = 2.07e.05 Pa: .*1e6 of MPa"),
        (
            of_chain(link_stiffness=rc.Plates(2e-5, 2e-5, elastic_modulus=206.0)),
            "chain.link_stiffness.elastic_modulus = 206 Pa",
        ),
        (of_chain(inner=rc.Link(8.9, 1e-6)), "chain.inner.mass = 8.9 kg: .* 1e-3 of g"),
        (
            replace(DRIVE, tensioner=replace(DRIVE.tensioner, damping=1e12)),
            r"tensioner.damping = 1e\+12 N s/m: .* give it in N s/m",
        ),
        (
            of_chain(carried=[(6, 200.0), (8, 0.2)]),
            "chain.carried, link 6 = 200 kg: is much .* give it in kg, 1e-3 of g",
        ),
        (
            replace(DRIVE, tensioner=replace(DRIVE.tensioner, pretension=25e3)),
            "tensioner.pretension = 2.5e.04 N: .* break at about 1.39e.04 N; give it in N",
        ),
        (of_load(load_inertia=1e4), r"load_inertia of sprocket 2 = 1e\+04 kg m\^2: .* of kg mm"),
        (
            rc.two_sprocket_drive("ANSI 40", (17, 25), center_distance=250.0),
            r"center of sprocket 2 = \(250, 0\) m: is 250 m from sprocket 1; .* divide millimetres",
        ),
    ],
)
def test_inputs_in_another_unit_are_told_with_field_value_and_remedy(drive, says):
    assert not [text for text in DRIVE.check().warnings if re.search(says, text)]
    (told,) = [text for text in drive.check().warnings if re.search(says, text)]
    if len(drive.chain.link_pitches) < 1000:  # more take seconds to simulate
        with pytest.warns(rc.RustchainWarning) as caught:
            rc.Simulation(drive)
        assert told in [str(warning.message) for warning in caught]


@pytest.mark.parametrize(("chain", "distance"), [("ANSI 240", 150.0), ("ANSI 40", 80.0)])
def test_a_long_conveyor_is_usual(chain, distance):
    drive = rc.two_sprocket_drive(chain, (20, 20), center_distance=distance)
    assert not [text for text in drive.check().warnings if "millimetres" in text]


def test_a_pitch_in_millimetres_is_told():
    drive = rc.paper_drive(25.0)
    chain = drive.chain
    hinge = {n: 1e3 * v for n, v in vars(chain.hinge).items()}
    large = replace(
        chain,
        pitch=1e3 * chain.pitch,
        hinge=rc.ClearanceHinge(**hinge),
        bushing_radius=1e3 * chain.bushing_radius,
        tooth_contact_length=1e3 * chain.tooth_contact_length,
    )
    sprockets = [replace(s, center=tuple(1e3 * x for x in s.center)) for s in drive.sprockets]
    told = replace(drive, chain=large, sprockets=sprockets).check().warnings
    assert [text for text in told if "chain.pitch = 12.7 m: lengths are in metres" in text]


TORQUE = (
    "motion.torque of sprocket 2 reaches 2000 N m: pulls the chain with 5.787e+04 N, roller chains "
    "of its pitch break at about 1.39e+04 N; give it in N m, 1e-3 of N mm"
)


@pytest.mark.parametrize(
    "torque",
    [
        -2000.0,
        [(0.0, 0.0), (0.5, -2000.0)],
        rc.Table([(0.0, 0.0), (0.5, 2000.0)]),
        rc.Sines([(500.0, 25.0, 0.0)], offset=-1500.0),
        rc.Sines([(300.0, 25.0, 0.0), (-200.0, 50.0, 0.0)], offset=-1500.0),
        rc.SmoothStep(0.1, 0.2, before=0.0, after=2000.0),
        rc.SmoothStep(0.1, 0.2, before=-2000.0, after=0.0),
    ],
)
def test_a_torque_at_which_the_chain_breaks_is_told(torque):
    loaded = replace(of_load(motion=rc.AppliedTorque(torque)), tensioner=None)
    assert loaded.check().warnings == (TORQUE,)
    assert not replace(loaded, chain=replace(CHAIN, strands=5)).check().warnings


def test_a_curve_over_the_speed_and_a_hung_mass_are_told_as_torques_are():
    curve = of_load(motion=rc.AppliedTorque(-2.0, curve=[(0.0, 0.0), (10.0, -2000.0)]))
    assert replace(curve, tensioner=None).check().warnings == (
        TORQUE.replace("torque of", "curve of"),
    )
    hung = (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(2000.0))
    (told,) = rc.open_chain("ANSI 40", hung, links=10).check().warnings
    assert told.startswith("mass of end 2 = 2000 kg: pulls the chain with 1.962e+04 N, ")
    assert told.endswith("give it in kg, 1e-3 of g")


def drawn_for(teeth):
    """A round seat with a straight flank, for so many teeth."""
    seat, slope = 4.03e-3, np.radians(20.0)
    center = np.array([0.0, CHAIN.pitch / (2.0 * np.sin(np.pi / teeth))])
    bottom = center - np.array([0.0, seat])
    tangent = center + seat * np.array([np.cos(slope), -np.sin(slope)])
    top = tangent + 6e-3 * np.array([np.sin(slope), np.cos(slope)])
    pieces = [rc.ToothArc(bottom, tangent, center), rc.ToothLine(tangent, top)]
    return rc.CustomTooth(pieces, tip_diameter=75e-3)


@pytest.mark.parametrize(("teeth", "depth"), [(18, 2.1), (19, 4.1), (20, 6.1)])
def test_a_tooth_drawn_for_another_number_of_teeth_is_told(teeth, depth):
    def told(teeth):
        drive = rc.two_sprocket_drive("ANSI 40", teeth=(17, teeth), links=60, profile=drawn_for(17))
        return drive.check().warnings

    assert told(17) == ()
    assert told(teeth) == (
        f"profile of sprocket 2: a seated bushing stands {depth} mm below the pitch circle of "
        f"{teeth} teeth; draw the pieces for this tooth number",
    )


@pytest.mark.parametrize("seat", ["bottom-diameter", "pitch-circle"])
@pytest.mark.parametrize("form", [rc.AnsiTooth, rc.IsoTooth, partial(rc.StraightTooth, 0.3)])
def test_a_tooth_cut_for_far_larger_rollers_is_told(form, seat):
    def told(share):
        tooth = form(seat=seat, roller_diameter=share * 7.9375e-3)
        drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, profile=tooth)
        return drive.check().warnings

    assert told(1.0) == told(1.1) == ()
    assert len(told(1.3)) == 2
    assert re.fullmatch(
        r"profile of sprocket 1: a seated bushing stands 1\.[23] mm below the pitch circle of 17 "
        r"teeth; the chain needs a roller_diameter of 7\.938 mm",
        told(1.3)[0],
    )


@pytest.mark.parametrize("hinges", ["clearance", "ideal"])
def test_an_accuracy_that_does_not_resolve_the_contacts_of_a_drive_is_told(hinges):
    drive = rc.paper_drive(25.0, hinges=hinges)
    with pytest.warns(rc.RustchainWarning) as caught:
        rc.Simulation(drive, solver=rc.Solver(accuracy=1e-5))
    (told,) = [str(warning.message) for warning in caught]
    assert told == (
        "solver.accuracy = 1e-05 m: steps no longer resolve contacts of 1e-6 m; take 1e-8 or less"
    )
    # The suite makes an error of any warning.
    rc.Simulation(drive, solver=rc.Solver(accuracy=1e-7))
    rc.Simulation(drive, solver=rc.Solver(accuracy=1e-5, rtol=1e-7, atol=1e-7))


def test_a_minimum_impact_velocity_that_is_not_above_the_error_of_velocities_is_told():
    drive = rc.paper_drive(25.0)
    with pytest.warns(rc.RustchainWarning) as caught:
        rc.Simulation(drive, min_impact_velocity=1e-5)
    (told,) = [str(warning.message) for warning in caught]
    assert told == (
        "min_impact_velocity = 1e-05 m/s: is not above the error of velocities that "
        "solver.accuracy = 1e-10 m permits, 1e-05 m/s; forces of slow contacts can be many times "
        "too large; take an accuracy of 3e-12 or less, or a larger velocity"
    )
    # The suite makes an error of any warning.
    rc.Simulation(drive, min_impact_velocity=1.1e-5)
    rc.Simulation(drive, min_impact_velocity=1e-5, solver=rc.Solver(accuracy=1e-11))
    rc.Simulation(drive, min_impact_velocity=1e-5, solver=rc.Solver(rtol=1e-7, atol=1e-7))
    # The default, at an accuracy that permits the same velocity.
    rc.Simulation(drive, solver=rc.Solver(accuracy=1e-8))


def test_forces_of_slow_contacts_are_right_at_the_accuracy_that_is_told():
    """The largest hinge force from static equilibrium, where contacts have the minimum."""

    def largest(accuracy):
        scene = rc.Scene(
            rc.paper_drive(25.0),
            start="static",
            min_impact_velocity=3e-6,
            solver=rc.Solver(accuracy=accuracy),
        )
        result = rc.Simulation(scene).run(5e-3, 2e-5, energy=False, progress=False)
        return result.peaks.hinge_force.max()

    exact = largest(1e-13)
    with pytest.warns(rc.RustchainWarning, match="take an accuracy of 1e-12 or less"):
        assert largest(1e-10) > 1.5 * exact
    assert largest(1e-12) == pytest.approx(exact, rel=0.1)


def test_a_seat_radius_for_far_larger_rollers_is_told():
    tooth = rc.StraightTooth(0.3, seat="pitch-circle", seat_radius=0.6 * 7.9375e-3)
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, profile=tooth)
    assert drive.check().warnings[0].endswith("17 teeth; leave seat_radius out")


def test_a_film_at_a_static_start_is_told_to_have_no_force():
    law = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    with pytest.warns(rc.RustchainWarning, match="hinges begin in dry contact") as caught:
        simulation = rc.Simulation(DRIVE, hinge_law=law, start="static")
    assert len(caught) == 1
    energy = simulation.run(2e-3, progress=False).energy
    assert energy.hinge_film[-1] == 0.0
    # The suite makes an error of any warning.
    rc.Simulation(DRIVE, hinge_law=law)
    rc.Simulation(DRIVE, hinge_law=replace(law, friction=rc.Coulomb(0.1)), start="static")


def told_of_speeds(drive):
    return [text for text in drive.check().warnings if " m/s" in text and "rpm" in text]


@pytest.mark.parametrize(
    "speed",
    [
        -1500.0,
        [(0.0, 0.0), (0.5, 1500.0)],
        rc.Spline([(0.0, 0.0), (0.5, 1500.0)]),
        rc.Sines([(100.0, 25.0, 0.0)], offset=-1400.0),
        rc.SmoothStep(0.1, 0.2, before=0.0, after=1500.0),
    ],
)
def test_a_speed_in_revolutions_per_minute_is_told(speed):
    driver, driven = DRIVE.sprockets
    fast = replace(driver, motion=rc.PrescribedSpeed(speed))
    (told,) = told_of_speeds(replace(DRIVE, sprockets=(fast, driven)))
    assert told.startswith(
        "motion.speed of sprocket 1 reaches 1500 rad/s: moves the chain at 51.84 m/s"
    )
    assert "rustchain.rpm" in told


def test_an_initial_speed_in_revolutions_per_minute_is_told():
    (told,) = told_of_speeds(of_load(initial_speed=-1500.0))
    assert told.startswith("initial_speed of sprocket 2 reaches 1500 rad/s: ")
    assert not told_of_speeds(of_load(initial_speed=rc.rpm(1500)))


@pytest.mark.parametrize(
    ("law", "says"),
    [
        (rc.Hertz(friction=rc.Coulomb(3.0)), "force_law.friction.coefficient = 3: .*normal force"),
        (rc.Hertz(friction=rc.LuGre(5.0, 0.1)), "force_law.friction.static_coefficient = 5: "),
        (rc.Hertz(film=rc.LubricantFilm(20.0)), "force_law.film.viscosity = 20 Pa s: .*mPa s"),
        (rc.Linear(stiffness=2e13), r"force_law.stiffness = 2e\+13 N/m: .*give it in N/m"),
        (rc.Linear(stiffness=1e-3), "force_law.stiffness = 0.001 N/m"),
    ],
)
def test_laws_in_another_unit_are_told_once(law, says):
    with pytest.warns(rc.RustchainWarning, match=says) as caught:
        rc.Simulation(DRIVE, force_law=law, hinge_law=law)
    assert len(caught) == 1


def test_mechanisms_have_the_same_limits():
    mechanism = rc.Mechanism()
    mechanism.add_body("ball", 1.0, 1e-3, (0.0, 0.3, 0.0))
    soft = rc.SurfaceContact(rc.Hertz(), material=rc.Material(elastic_modulus=207.0))
    mechanism.add_disc_contact("floor", "ground", "ball", 0.1, 0.1, soft)
    (told,) = mechanism.check().warnings
    assert told.startswith("law.material.elastic_modulus of contact 'floor' = 207 Pa: ")


def a_joined_body():
    mechanism = rc.Mechanism()
    mechanism.add_body("arm", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "arm", at=(0.0, 0.0))
    return mechanism


LAW = rc.LinearContact(1e6)
OF_MECHANISMS = {
    "speed of driver 'd' reaches 1e+06 rad/s": ("add_driver", {"speed": 1e6}),
    "rest of force 'd' = 300 m": ("add_spring", {"stiffness": 100.0, "rest_length": 300.0}),
    "profile_radius of contact 'd' = 200 m": (
        "add_clearance_joint", {"bore_radius": 200.0, "pin_radius": 0.03, "law": LAW},
    ),
    "points of contact 'd', the farthest = 1000 m": (
        "add_outline_contact",
        {"points": [(1e3, -0.5), (-1e3, -0.5)], "radius": 0.03, "law": LAW, "closed": False},
    ),
    "law.length of contact 'd' = 1e+04 m": (
        "add_clearance_joint",
        {"bore_radius": 0.04, "pin_radius": 0.03, "pin_point": (-0.5, 0.0),
         "law": rc.LinearContact(1e6, length=1e4)},
    ),
}  # fmt: skip


@pytest.mark.parametrize("says", OF_MECHANISMS)
def test_parts_of_mechanisms_in_another_unit_are_told(says):
    call, given = OF_MECHANISMS[says]
    mechanism = a_joined_body()
    assert not mechanism.check().warnings
    getattr(mechanism, call)("d", "ground", "arm", **given)
    assert [text for text in mechanism.check().warnings if text.startswith(says)]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_states_of_bodies_in_another_unit_are_told_whatever_their_sign(sign):
    for state, says in (
        ({"position": (sign * 300.0, 0.0, 0.0)}, "position of body 'arm' = "),
        ({"position": (0.0, sign * 300.0, 0.0)}, "position of body 'arm' = "),
        ({"position": (0.0, 0.0, sign * 90.0)}, "position of body 'arm', its angle = "),
        ({"velocity": (0.0, 0.0, sign * 1e5)}, "velocity of body 'arm', its rate of turning = "),
    ):
        mechanism = a_joined_body()
        (body,) = mechanism.bodies
        moved = replace(mechanism, bodies=[replace(body, **state)], joints=[])
        told = implausible_inputs(rc.Scene(moved))
        assert [text.startswith(says) for text in told] == [True], told


def test_wound_springs_hoists_and_long_outlines_are_usual():
    mechanism = a_joined_body()
    mechanism.add_torsion_spring("wound", "ground", "arm", stiffness=0.1, rest_angle=-50.0)
    points = [(120.0, -1.0), (-1.0, -1.0)]
    mechanism.add_outline_contact("floor", "ground", "arm", points, 0.03, LAW, closed=False)
    mechanism.add_body("cage", 100.0, 10.0, position=(0.0, 5.0, 0.0))
    mechanism.add_prismatic("shaft", "ground", "cage", direction=(0.0, 1.0))
    rise = rc.SmoothStep(0.0, 60.0, before=5.0, after=155.0)
    mechanism.add_position_driver("hoist", "ground", "cage", (0.0, 1.0), position=rise)
    assert not mechanism.check().warnings


def told_at_rest(drive):
    return [text for text in drive.check().warnings if "no sprocket has a speed" in text]


def test_a_drive_that_nothing_moves_is_told():
    still = rc.paper_drive()
    driver, driven = still.sprockets
    (told,) = told_at_rest(replace(still, sprockets=(replace(driver, motion=rc.Free()), driven)))
    assert "motion=PrescribedSpeed(...)" in told


def test_what_is_moved_otherwise_is_not_at_rest():
    still = rc.paper_drive()
    driver, driven = still.sprockets
    free = replace(driver, motion=rc.Free())
    assert not told_at_rest(replace(DRIVE, sprockets=(free, driven)))  # its tensioner moves it
    turning = (replace(free, initial_speed=3.0), driven)
    torque = (free, replace(driven, motion=rc.AppliedTorque(1.0)))
    for sprockets in (still.sprockets, turning, torque):
        assert not told_at_rest(replace(still, sprockets=sprockets))
    laden = replace(CHAIN, carried=((3, 0.1),))
    assert not told_at_rest(replace(still, chain=laden, sprockets=(free, driven)))
    hung = (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(1.0))
    assert not told_at_rest(rc.open_chain("ANSI 40", hung, links=10))
