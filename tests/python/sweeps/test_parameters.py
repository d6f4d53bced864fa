"""Parameters of sweeps: what each changes in a scene, and refusals with the nearest name."""

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "report_step": 1e-4, "progress": False}  # contacts begin at 4.1 ms


def peak(result):
    return result.peaks.tooth_force.max()


def test_pretension_makes_changes_and_removes_the_tensioner():
    def tensioner(result):
        return (result.drive.tensioner,)

    def swept(drive, axes):
        return [v[0] for v in rc.sweep(drive, axes, tensioner, duration=1e-4).values]

    assert swept(PAPER, {"pretension": [0, 25]}) == [None, rc.Tensioner(25.0)]
    assert swept(rc.paper_drive(25.0), {"pretension": [None, 5.0]}) == [None, rc.Tensioner(5.0)]
    own = rc.Tensioner(10.0, sprocket=1, ramp_time=0.2, direction=(-1.0, 0.0))
    tight = replace(PAPER, tensioner=own)
    assert swept(tight, {"pretension": [0.0, 25]}) == [None, replace(own, pretension=25)]
    both = {"pretension": [0, 25], "tensioner.damping": [1.0]}
    assert swept(PAPER, both) == [None, rc.Tensioner(25, damping=1.0)]
    replaced = {"tensioner": [None, own], "pretension": [5]}
    assert swept(PAPER, replaced) == [rc.Tensioner(5), replace(own, pretension=5)]


def test_speed_is_that_of_the_driver():
    second = rc.Sprocket(17, PAPER.sprockets[1].center, rc.PrescribedSpeed(3.0))
    first = replace(PAPER.sprockets[0], motion=rc.Free())
    table = ((0.0, 5.0), (0.1, 6.0))
    swept = rc.sweep(
        replace(PAPER, sprockets=[first, second]),
        {"speed": [5.0, table]},
        lambda result: [sprocket.motion for sprocket in result.drive.sprockets],
        duration=1e-4,
    )
    assert swept.values == [[rc.Free(), rc.PrescribedSpeed(v)] for v in (5.0, table)]


def test_fields_that_only_go_together_are_changed_together():
    """Either alone is refused: the pin would be larger than the bore, the bore than the bushing."""
    axes = [{"chain.hinge.pin_radius": 3e-3, "chain.hinge.bore_radius": 3.025e-3}]
    swept = rc.sweep(PAPER, axes, lambda r: r.drive.chain.hinge.clearance, duration=1e-4)
    assert swept.values == [3.025e-3 - 3e-3]


def test_a_field_of_one_law_changes_the_law_of_the_case():
    """The law of hinges is by default that of all contacts, which an axis may vary, too."""
    axes = {
        "hinge_law.friction": [rc.Coulomb(0.1)],
        "force_law": [rc.Johnson(), rc.Hertz()],
    }
    swept = rc.sweep(PAPER, axes, lambda r: (r.hinge_law, r.tooth_law), duration=1e-4)
    assert swept.values == [
        (rc.Johnson(friction=rc.Coulomb(0.1)), rc.Johnson()),
        (rc.Hertz(friction=rc.Coulomb(0.1)), rc.Hertz()),
    ]
    own = rc.Scene(PAPER, force_law=rc.Johnson(), hinge_law=rc.Hertz())
    axes = {"hinge_law.friction": [rc.Coulomb(0.1)]}
    swept = rc.sweep(own, axes, lambda r: (r.hinge_law, r.tooth_law), duration=1e-4)
    assert swept.values == [(rc.Hertz(friction=rc.Coulomb(0.1)), rc.Johnson())]


def test_a_chain_by_its_name_has_the_links_of_the_drive_and_warnings_are_those_of_a_run():
    axes = {"chain": ["ANSI 40"], "gravity": [(0.0, -9810.0)]}
    with pytest.warns(rc.RustchainWarning, match="gravity = 9810 m"):
        swept = rc.sweep(PAPER, axes, lambda r: r.drive.chain.links, duration=1e-4)
    assert swept.values == [38]


def test_the_other_name_of_a_keyword_is_a_parameter():
    axes = {"min_approach_speed": [1e-3, 2e-3]}
    swept = rc.sweep(PAPER, axes, lambda r: r.min_impact_velocity, duration=1e-4)
    assert swept.values == [1e-3, 2e-3]
    with pytest.raises(rc.InvalidInput, match="'min_impact_velocity' is there twice"):
        rc.sweep(PAPER, axes | {"min_impact_velocity": [1e-3]})


def test_the_parts_of_sequences_count_from_1_as_results_do():
    swept = rc.sweep(
        PAPER,
        {
            "sprockets.2.mass": [2.0],
            "gravity.2": [0.0],
            "solver": [rc.Solver(atol=1e-6)],
            "rtol": [1e-7],
        },
        duration=1e-4,
    )
    result = swept.results[0]
    assert [sprocket.mass for sprocket in result.drive.sprockets] == [0.817, 2.0]
    assert result.drive.gravity == (0.0, 0.0)
    assert result.solver == rc.Solver(rtol=1e-7, atol=1e-6)


def test_a_function_gets_the_parameters_that_are_its_arguments():
    def build(teeth, speed=12.0):
        return rc.two_sprocket_drive(teeth=(17, teeth), links=60, speed=2 * speed)

    swept = rc.sweep(
        build,
        {"teeth": [17, 25], "speed": [5.0, 6.0], "chain.material.restitution": [0.5]},
        lambda r: (r.drive.sprockets[1].teeth, r.drive.sprockets[0].motion.speed),
        duration=1e-4,
    )
    assert swept.values == [(17, 10.0), (17, 12.0), (25, 10.0), (25, 12.0)]
    generator = rc.sweep(rc.paper_drive, {"pretension": [0, 25]}, peak, **SHORT)
    assert generator.values == rc.sweep(PAPER, {"pretension": [0, 25]}, peak, **SHORT).values
    free = rc.sweep(lambda **keywords: build(**keywords), {"teeth": [18]}, duration=1e-4)
    assert free.results[0].drive.sprockets[1].teeth == 18


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pretention", "did you mean 'pretension'"),
        ("rtoll", "did you mean 'rtol'"),
        ("durration", "did you mean 'duration'"),
        ("restitution", "did you mean 'chain.material.restitution'"),
        ("chain.material.restitutoin", "did you mean 'chain.material.restitution'"),
        ("sprocket.1.teeth", "did you mean 'sprockets.1.teeth'"),
        ("sprockets.20.teeth", "drive.sprockets.20: does not exist; expected a number from 1 to 2"),
        ("sprockets.0.teeth", "drive.sprockets.0: does not exist; expected a number from 1 to 2"),
        ("sprocket.2.teth", "did you mean 'sprockets.2.teeth'"),
        ("sprockets.1.speed", "did you mean 'sprockets.1.motion.speed'"),
        ("psrockets.1.motion.speed", "did you mean 'sprockets.1.motion.speed'"),
        ("tensioner.sprockets", "did you mean 'tensioner.sprocket'"),
        ("tensioner.force", "known: 'tensioner.pretension', .*'tensioner.stiffness'"),
        ("chain.inner.lenght", "known: 'chain.inner.mass', 'chain.inner.inertia'"),
        ("chain.pin_radus", "did you mean 'chain.hinge.pin_radius'"),
        ("chain.pitch.1", "did you mean 'chain.pitch'"),
        ("sprockets.two.teeth", "did you mean 'sprockets.1.teeth'"),
        ("sprockets.2.center.y", "did you mean 'sprockets.2.center.2'"),
        ("gravity.x", "did you mean 'gravity.1'"),
        ("inner.mas", "did you mean 'chain.inner.mass'"),
        ("motion.sped", "did you mean 'sprockets.1.motion.speed'"),
        ("simulation.start", "did you mean 'start'"),
        ("friction", "did you mean 'force_law.friction'"),
        ("viscosity", "did you mean 'force_law.film.viscosity'"),
        ("centre_distance", "known: .*'pretension', 'speed', 'duration'"),
        ("sprockets.2.1", "known: 'sprockets.2.teeth', 'sprockets.2.center'"),
        ("place", "is no parameter"),
        ("threads", "is no parameter"),
        ("zzz", "known: .*'pretension', 'speed', 'duration'"),
    ],
)
def test_an_unknown_axis_is_refused_at_once_with_the_nearest_name(name, said):
    for axes in ({name: [1]}, [{}, {name: 1}]):
        with pytest.raises(rc.InvalidInput, match=said) as caught:
            rc.sweep(PAPER, axes)
        assert repr(name) in str(caught.value)
    with pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(lambda center=0: PAPER, {name: [1]})


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ends.1.force", "drive.ends.1: cannot be changed, for drive.ends is None"),
        ("ends.1.1", "drive.ends.1: cannot be changed, for drive.ends is None"),
        ("sprockets.2.speed", "drive.sprockets.2.speed: does not exist; known: .*'motion'"),
        ("guides.1.1", "drive.guides.1: does not exist, for drive.guides is empty"),
        (
            "torque",
            r"drive.sprockets.2.motion is a Free; set the whole of it, sprockets.2.motion to "
            r"AppliedTorque\(torque=1\), in files {torque = 1}",
        ),
        (
            "links",
            "it is an argument of two_sprocket_drive, no field of the drive; sweep a function",
        ),
        ("adjust", "it is an argument of chain_drive, no field of the drive; sweep a function"),
    ],
)
def test_no_name_is_proposed_that_the_drive_does_not_have(name, said):
    with pytest.raises(rc.InvalidInput, match=rf"{name!r} is no parameter; {said}"):
        rc.sweep(PAPER, {name: [1]})


def test_the_field_of_a_part_that_has_it_is_proposed():
    second = replace(PAPER.sprockets[1], motion=rc.AppliedTorque(torque=-1.0))
    drive = replace(PAPER, sprockets=[PAPER.sprockets[0], second])
    with pytest.raises(rc.InvalidInput, match=r"did you mean 'sprockets\.2\.motion\.torque'"):
        rc.sweep(drive, {"torque": [1]})


def test_the_fields_of_an_end_are_those_of_its_kind():
    ends = [rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(mass=1.0)]
    hanging = rc.open_chain("ISO 08B", ends, links=10)
    for name, known in (("ends.1.force", "'velocity'"), ("ends.2.1", "'mass', 'inertia'")):
        with pytest.raises(rc.InvalidInput, match=f"drive.{name}: does not exist; .*{known}"):
            rc.sweep(hanging, {name: [1]})


def pendulum():
    m = rc.Mechanism(name="pendulum")
    m.add_body("bob", 2.0, 0.1, position=(0.3, 0.0, 0.0))
    m.add_revolute("pin", "ground", "bob", at=(0.0, 0.0))
    m.add_torque("load", "bob", 0.5)
    law = rc.LinearContact(1e5)
    floor = [(1.0, -1.0), (-1.0, -1.0)]
    m.add_outline_contact("floor", "ground", "bob", floor, 0.05, law, closed=False)
    return m


def test_parameters_reach_into_the_parts_of_a_mechanism():
    axes = {
        "bodies.1.mass": [1.0, 3.0],
        "gravity.2": [-1.62],
        "joints.1.friction": [rc.Coulomb(0.1)],
        "joints.1.radius": [0.01],
        "forces.1.x": [0.25],
        "contacts.1.law.stiffness": [2e5],
        "rtol": [1e-7],
    }
    for system in (pendulum(), rc.Scene(pendulum()), pendulum):
        swept = rc.sweep(system, axes, duration=1e-4, progress=False)
        assert swept.success
        scenes = [result.scene for result in swept.results]
        assert [scene.system.bodies[0].mass for scene in scenes] == [1.0, 3.0]
        changed = scenes[0].system
        assert changed.gravity == (0.0, -1.62)
        assert (changed.joints[0].friction, changed.forces[0].x) == (rc.Coulomb(0.1), 0.25)
        assert changed.contacts[0].law == rc.LinearContact(2e5)
        assert scenes[0].solver.rtol == 1e-7
    built = pendulum()
    built.bodies = (replace(built.bodies[0], mass=3.0),)
    alone = rc.Simulation(built).run(1e-3, progress=False)
    swept = rc.sweep(pendulum(), {"bodies.1.mass": [3.0]}, duration=1e-3, progress=False)
    np.testing.assert_array_equal(swept.results[0].final_positions, alone.final_positions)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("bodies.1.mas", "did you mean 'bodies.1.mass'"),
        ("body.1.mass", "did you mean 'bodies.1.mass'"),
        ("bodies.2.mass", "mechanism.bodies.2: does not exist; expected a number from 1 to 1"),
        ("contacts.1.law.stifness", "did you mean 'contacts.1.law.stiffness'"),
        ("stiffness", "did you mean 'forces.1.stiffness'"),
        ("friction", "did you mean 'joints.1.friction'"),
        ("bodies.1.1", "known: 'bodies.1.name', 'bodies.1.mass'"),
        ("pretension", "is no parameter"),
        ("zzz", "known: .*'bodies'"),
    ],
)
def test_an_unknown_axis_of_a_mechanism_gets_the_nearest_of_its_own(name, said):
    for system in (pendulum(), rc.Scene(pendulum())):
        with pytest.raises(rc.InvalidInput, match=said):
            rc.sweep(system, [{}, {name: 1.0}], duration=1e-4, progress=False)


REFUSED = {
    "a drive that is none": (
        lambda: rc.sweep("paper", {}),
        "scene: got 'paper'; expected a Scene, a ChainDr",
    ),
    "a value in place of an axis": (lambda: rc.sweep(PAPER, {"rtol": 1e-5}), r"axes\['rtol'\] = 1"),
    "a word in place of an axis": (
        lambda: rc.sweep(PAPER, {"method": "pece"}),
        r"axes\['method'\] = 'pece': must be a sequence",
    ),
    "an empty axis": (lambda: rc.sweep(PAPER, {"rtol": []}), "at least one value"),
    "no cases": (lambda: rc.sweep(PAPER, []), r"axes = \[\]: must map names"),
    "cases that are none": (lambda: rc.sweep(PAPER, [1.0]), r"axes = \[1.0\]: must map names"),
    "no axes": (lambda: rc.sweep(PAPER, None), "axes = None: must map names"),
    "two names for one field": (
        lambda: rc.sweep(PAPER, {"pretension": [1], "tensioner.pretension": [2]}),
        "'tensioner.pretension' is there twice",
    ),
    "a function that lacks an argument": (
        lambda: rc.sweep(lambda teeth, speed: PAPER, {"teeth": [17]}),
        "the function needs 'speed'",
    ),
    "a function that returns no drive": (
        lambda: rc.sweep(lambda teeth: None, {"teeth": [17]}),
        "system of the scene = None: must be a ChainDrive",
    ),
    "a function that returns no drive to change": (
        lambda: rc.sweep(lambda: None, {"speed": [17]}),
        "system of the scene = None: must be a ChainDrive",
    ),
    "no driver": (
        lambda: rc.sweep(
            replace(PAPER, sprockets=[replace(s, motion=rc.Free()) for s in PAPER.sprockets]),
            {"speed": [1.0]},
        ),
        "speed = 1.0: no sprocket",
    ),
    "the speed of the driver under two names": (
        lambda: rc.sweep(PAPER, {"speed": [10.0], "sprockets.1.motion.speed": [20.0]}),
        "'speed' and 'sprockets.1.motion.speed' are one parameter",
    ),
    "a field of nothing": (
        lambda: rc.sweep(PAPER, {"tensioner.damping": [1.0]}),
        "tensioner.damping: cannot be changed, for drive.tensioner is None",
    ),
    "a field of another motion": (
        lambda: rc.sweep(PAPER, {"sprockets.2.motion.torque": [1.0]}),
        "sprockets.2.motion is a Free",
    ),
    "a keyword that no case can do with": (
        lambda: rc.sweep(PAPER, {"pretension": [0, 25]}, duration=-1.0),
        r"duration = -1: must be a positive",
    ),
    "a group that is none": (
        lambda: rc.sweep(PAPER, {"pretension": [0]}, record=("hinge",)),
        "did you mean 'hinges'",
    ),
    "an index in brackets": (
        lambda: rc.sweep(PAPER, {"sprockets[1].mass": [2.0]}),
        "parts are numbered from 1 behind a dot: 'sprockets.2.mass'",
    ),
    "no solver": (lambda: rc.sweep(PAPER, {"solver": [3]}), "solver = 3: must be a Solver"),
    "no threads": (
        lambda: rc.sweep(PAPER, {"rtol": [1e-5]}, threads=0),
        "threads = 0: .*from 1 to",
    ),
    "half a thread": (lambda: rc.sweep(PAPER, {"rtol": [1e-5]}, threads=0.5), "threads = 0.5"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_makes_no_sweep_is_refused_by_name(case):
    call, message = REFUSED[case]
    with pytest.raises(rc.InvalidInput, match=message):
        call()


def test_an_unknown_keyword_is_answered_with_the_nearest_name():
    with pytest.raises(TypeError, match="'measure'"):
        rc.sweep(PAPER, {"pretension": [0]}, mesure=peak)
