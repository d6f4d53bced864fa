"""What every scene promises: chains with clearance, chains with ideal hinges, and mechanisms."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc

DURATION, STEP = 4e-3, 1e-4


def crank() -> rc.Mechanism:
    """A crank that a motor turns, a ball that falls onto a floor, and a flywheel."""
    m = rc.Mechanism(name="crank and ball")
    m.add_body("crank", 0.4, 1e-3, position=(0.05, 0.0, 0.0), velocity=(0.0, 0.5, 10.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_driver("motor", "ground", "crank", speed=10.0)
    m.add_body("ball", 1.0, 1e-3, position=(0.5, 0.0505, 0.0), velocity=(0.0, -0.4, 0.0))
    m.add_outline_contact(
        "floor",
        "ground",
        "ball",
        [(0.9, 0.0), (0.1, 0.0)],
        0.05,
        rc.LinearContact(1e5, 20.0),
        closed=False,
    )
    m.add_body("wheel", 0.5, 2e-3, position=(1.5, 0.0, 0.0))
    m.add_revolute("axle", "ground", "wheel", at=(1.5, 0.0))
    m.add_torque("load", "wheel", 0.0)
    return m


def drive(hinges: str) -> rc.ChainDrive:
    made = rc.paper_drive(pretension=25.0)
    return replace(made, hinges=hinges)


SYSTEMS: dict[str, Callable[[], rc.ChainDrive | rc.Mechanism]] = {
    "clearance": lambda: drive("clearance"),
    "ideal": lambda: drive("ideal"),
    "mechanism": crank,
}
GROUPS = {
    "drive": ("hinges", "teeth", "sprockets", "energy"),
    "mechanism": ("bodies", "joints", "contacts", "energy"),
}
# Part whose speed can be set, with its body; part whose torque can be set.
INPUTS = {
    "drive": (("sprocket_1", "sprocket_1"), "sprocket_2"),
    "mechanism": (("motor", "crank"), "load"),
}
PEAKS = {
    "drive": [("hinge_force", "hinge_force"), ("tooth_force", "tooth_force")],
    "mechanism": [("contact_force", "contact_force"), ("joint_force", "joint_reaction")],
}
STOPS = {
    "drive": rc.ToothForceAbove(1e-6),
    "mechanism": rc.ContactForceAbove(1e-6),
}


@pytest.fixture(scope="module", params=SYSTEMS)
def scene(request):
    return rc.Scene(SYSTEMS[request.param]())


@pytest.fixture(scope="module")
def result(scene):
    return rc.Simulation(scene).run(DURATION, STEP, progress=False)


def test_one_class_simulates_and_one_holds_the_result(scene, result):
    simulation = rc.Simulation(scene)
    assert type(simulation) is rc.Simulation
    assert type(simulation.evaluate()) is rc.Evaluation
    assert type(result) is rc.Result
    assert simulation.scene == scene == result.scene


def test_keywords_make_the_same_scene_as_a_scene_does(scene):
    solver = rc.Solver(method="pece", rtol=1e-7, atol=1e-8)
    made = rc.Simulation(scene.system, solver=solver)
    assert made.scene == replace(scene, solver=solver)
    assert rc.Simulation(scene, solver=solver).scene == made.scene


def test_all_that_the_scene_has_is_recorded_by_default(scene, result):
    assert set(result.groups) == set(GROUPS[scene.kind])
    assert (result.success, result.status) == (True, "finished")
    np.testing.assert_allclose(result.time, np.arange(len(result.time)) * STEP, atol=1e-12)
    assert len(rc.Simulation(scene).run(2e-4, progress=False).time) == 3  # a row each 1e-4 s


@pytest.mark.parametrize("duration", [1e-10, 1e-14, 1e-20])
def test_a_run_far_shorter_than_a_report_step_has_rows_of_its_start_and_end(scene, duration):
    short = rc.Simulation(scene).run(duration, report_step=1.0, progress=False)
    assert short.time.tolist() == [0.0, duration]


def test_energy_is_a_group_like_the_others(scene, result):
    energy = result.energy
    balance = energy.kinetic + energy.gravity + energy.elastic
    left = balance - balance[0] + energy.dissipated - energy.external_work
    np.testing.assert_allclose(energy.residual, left, atol=1e-9 * np.abs(balance).max())
    assert energy.worked_in is energy.external_work
    groups = [group for group in GROUPS[scene.kind] if group != "energy"]
    for more in ({"record": groups}, {"energy": False}):
        without = rc.Simulation(scene).run(3e-4, STEP, progress=False, **more)
        assert set(without.groups) == set(groups)
        with pytest.raises(rc.NotRecorded, match="energy"):
            _ = without.energy


def test_a_group_that_the_scene_does_not_have_is_refused_with_those_that_it_has(scene):
    wrong = {"drive": "joints", "mechanism": "hinges"}[scene.kind]
    with pytest.raises(rc.InvalidInput, match=f"'{wrong}' is no group; .*'"):
        rc.Simulation(scene).run(1e-4, record=(wrong,), progress=False)


def test_one_group_alone_is_the_same_to_the_last_bit(scene, result):
    group = GROUPS[scene.kind][1]
    alone = rc.Simulation(scene).run(DURATION, STEP, record=(group,), progress=False)
    assert alone.groups == (group,)
    for name, values in alone.arrays.items():
        np.testing.assert_array_equal(values, result.arrays[name])


def test_a_part_of_the_time_is_a_result(result):
    part = result.between(start=1e-3, end=2e-3)
    assert type(part) is rc.Result
    np.testing.assert_array_equal(part.time, result.time[10:21])
    np.testing.assert_array_equal(part.energy.kinetic, result.energy.kinetic[10:21])


def test_arrays_are_read_only_and_stay_so_in_copies(result):
    for one in (
        result,
        copy.copy(result),
        copy.deepcopy(result),
        pickle.loads(pickle.dumps(result)),
    ):
        assert one == result
        for values in (*one.arrays.values(), one.energy.kinetic, one.final_positions):
            with pytest.raises(ValueError, match="read-only"):
                values[...] = 0


def test_results_of_other_scenes_or_numbers_are_not_equal(scene, result):
    assert result != replace(result, scene=replace(scene, solver=rc.Solver(accuracy=1e-9)))
    changed = {name: values + 1 for name, values in result.arrays.items()}
    assert result != replace(result, arrays=changed)


def test_scenes_are_values(scene):
    for made in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert made == scene
        assert hash(made) == hash(scene)
    assert rc.Scene.from_json(scene.to_json()) == scene
    assert len({scene, copy.copy(scene), replace(scene, start="static")}) == 2


def test_copies_of_a_simulation_continue_on_their_own(scene):
    simulation = rc.Simulation(scene, start="static")
    simulation.step_to(1e-3)
    copies = [copy.copy(simulation), copy.deepcopy(simulation)]
    copies.append(pickle.loads(pickle.dumps(simulation)))
    for made in copies:
        assert (made.scene, made.time, made.rest) == (simulation.scene, 1e-3, simulation.rest)
        made.step_to(2e-3)
        assert simulation.time == 1e-3
    simulation.step_to(2e-3)
    for made in copies:
        np.testing.assert_array_equal(made.positions, simulation.positions)


def test_copies_of_a_simulation_keep_the_attributes_of_its_user(scene):
    simulation = rc.Simulation(scene)
    simulation.label = ["first"]
    shallow, deep = copy.copy(simulation), copy.deepcopy(simulation)
    assert shallow.label is simulation.label
    assert deep.label == ["first"]
    assert deep.label is not simulation.label
    assert pickle.loads(pickle.dumps(simulation)).label == ["first"]


class _Labelled(rc.Simulation):
    __slots__ = ("label", "never_set")


def test_copies_of_a_simulation_keep_what_a_subclass_has_in_slots(scene):
    simulation = _Labelled(scene)
    simulation.label, simulation.note = "first", "second"
    for made in (copy.copy(simulation), copy.deepcopy(simulation)):
        assert (made.label, made.note) == ("first", "second")
        assert not hasattr(made, "never_set")


def test_a_copy_made_during_a_run_can_run(scene):
    simulation = rc.Simulation(scene)
    made = []

    def copies(_):
        made.extend([copy.deepcopy(simulation), pickle.loads(pickle.dumps(simulation))])

    simulation.run(2e-4, 1e-4, callback=copies, progress=False)
    for each in made:
        assert each.run(1e-4, progress=False).success


def test_a_scene_has_the_names_of_its_bodies(scene):
    assert scene.body_names == tuple(rc.Simulation(scene).body_names)


def test_a_start_that_is_not_finite_is_refused_by_field_and_body(scene):
    simulation = rc.Simulation(scene)
    start = {"positions": simulation.positions, "velocities": simulation.velocities}
    for field in start:
        for number in (np.nan, np.inf):
            wrong = start[field].copy()
            wrong[1, 2] = number
            named = f"{field} of {scene.body_names[1]} = {number}: must be finite"
            with pytest.raises(rc.InvalidInput, match=named):
                rc.Scene(scene.system, **start | {field: wrong})


def test_what_a_scene_simulates_cannot_be_changed(scene, result):
    before = pickle.dumps(scene)
    for system in (scene.system, result.scene.system):
        with pytest.raises((rc.InvalidInput, AttributeError)):
            system.name = "another"
    assert pickle.loads(before) == scene


@pytest.mark.parametrize("form", [".toml", ".json"])
def test_scenes_come_back_from_their_file(scene, form, tmp_path):
    path = tmp_path / f"scene{form}"
    rc.save_scene(scene, path)
    assert rc.load_scene(path) == scene


def test_results_come_back_from_their_file(result, tmp_path):
    path = tmp_path / "run.nc"
    result.save(path)
    assert rc.load_result(path) == result


def test_a_state_goes_on_to_the_same_bits(scene, result, tmp_path):
    first = rc.Simulation(scene)
    first.run(DURATION / 2, STEP, progress=False)
    state = first.state()
    first.save_state(tmp_path / "state.npz")
    second = rc.Simulation(scene)
    second.set_state(pickle.loads(pickle.dumps(state)))
    third = rc.Simulation.load_state(tmp_path / "state.npz")
    assert third.scene == scene
    for simulation in (first, second, third):
        last = simulation.run(DURATION / 2, STEP, progress=False)
        np.testing.assert_array_equal(last.final_positions, result.final_positions)


def test_a_state_of_another_scene_is_refused(scene):
    other = rc.Simulation(replace(scene, solver=replace(scene.solver, max_step=5e-5)))
    with pytest.raises(rc.InvalidInput):
        rc.Simulation(scene).set_state(other.state())


def test_a_condition_stops_a_run_which_is_then_a_success(scene):
    simulation = rc.Simulation(scene)
    found = simulation.run(0.05, STEP, progress=False, stop=STOPS[scene.kind])
    assert (found.status, found.success) == ("stopped", True)
    assert simulation.time == found.time[-1] < 0.05
    timed = rc.Simulation(scene).run(1.0, STEP, progress=False, stop=rc.TimeReached(5e-4))
    assert timed.message == "stopped at t = 0.0005 s: reached 0.0005 s"


def test_a_callback_sees_every_row_and_does_not_move_the_simulation(scene, result):
    times = []
    found = rc.Simulation(scene).run(
        DURATION, STEP, progress=False, callback=lambda s: times.append(s.time)
    )
    np.testing.assert_array_equal(times, found.time)
    np.testing.assert_array_equal(found.final_positions, result.final_positions)
    with pytest.raises(rc.InvalidInput, match="a run is under way") as raised:
        rc.Simulation(scene).run(DURATION, STEP, progress=False, callback=lambda s: s.step_to(1.0))
    assert len(raised.value.result.time) == 1


def turned(simulation, body):
    row = simulation.body_names.index(body)
    return simulation.positions[row, 2], simulation.velocities[row, 2]


def test_a_speed_that_is_set_holds_from_the_present_angle_on(scene):
    simulation = rc.Simulation(scene)
    (part, body), _ = INPUTS[scene.kind]
    simulation.step_to(1.2345e-3)
    places, (angle, speed) = simulation.positions, turned(simulation, body)
    simulation.set_speed(part, 0.9 * speed)
    np.testing.assert_allclose(simulation.positions, places, rtol=0.0, atol=1e-13)
    assert turned(simulation, body) == pytest.approx((angle, 0.9 * speed), abs=1e-12)
    simulation.step_to(2.2345e-3)
    angle += 0.9 * speed * 1e-3
    assert turned(simulation, body) == pytest.approx((angle, 0.9 * speed), abs=1e-11)
    simulation.set_speed(part, [(0.0, 0.9 * speed), (2 * simulation.time, 1.1 * speed)])
    assert turned(simulation, body) == pytest.approx((angle, speed), abs=1e-11)
    assert simulation.scene == scene


def test_a_state_has_what_was_set_in_it(scene, tmp_path):
    simulation = rc.Simulation(scene)
    (part, body), load = INPUTS[scene.kind]
    simulation.step_to(1.000_001e-3)
    simulation.set_speed(part, 13.0)
    simulation.set_torque(load, [(0.0, 0.0), (4e-3, -0.02)])
    simulation.save_state(tmp_path / "set.npz")
    other = rc.Simulation.load_state(tmp_path / "set.npz")
    assert other.scene == scene
    first, second = (each.run(1e-3, 1e-5, progress=False) for each in (simulation, other))
    for name, values in first.arrays.items():
        np.testing.assert_array_equal(second.arrays[name], values, err_msg=name)
    assert turned(other, body)[1] == pytest.approx(13.0, rel=1e-14)
    assert simulation.state()["snapshot"] == other.state()["snapshot"]
    # The state of the start takes the change away.
    other.set_state(rc.Simulation(scene).state())
    assert turned(other, body)[1] != pytest.approx(13.0, rel=1e-3)


def test_the_energy_balance_continues_over_speeds_and_torques_that_are_set(scene):
    (part, body), load = INPUTS[scene.kind]
    speed = turned(rc.Simulation(scene), body)[1]

    def change(simulation):
        late = simulation.time > 2e-3
        simulation.set_speed(part, (1.05 if late else 0.95) * speed)
        simulation.set_torque(load, -20.0 * simulation.time)

    if getattr(scene.system, "hinges", None) == "ideal":
        # At the default accuracy the first impact alone can reach the limit of the warning.
        scene = replace(scene, solver=rc.Solver(accuracy=1e-11))
    result = rc.Simulation(scene).run(DURATION, STEP, progress=False, callback=change)
    energy = result.energy
    exchanged = np.abs(energy.external_work).max()
    assert exchanged > 1e-4
    assert np.abs(energy.residual).max() < 0.01 * exchanged


def test_a_part_that_is_not_there_gets_the_nearest(scene):
    simulation = rc.Simulation(scene)
    (part, _), load = INPUTS[scene.kind]
    for call, name in ((simulation.set_speed, part), (simulation.set_torque, load)):
        with pytest.raises(rc.NoSuchPart, match=f"did you mean '{name}'"):
            call(name.replace("o", "oo", 1), 1.0)
        for wrong in (0, 99, True, None, [name]):
            with pytest.raises(rc.NoSuchPart, match=r"nearest is|known: "):
                call(wrong, 1.0)


def test_a_condition_on_a_part_that_is_not_there_is_refused(scene):
    conditions = {
        "drive": [rc.HingeForceAbove(1.0, hinge=99), rc.StrandSlack(strand="uper")],
        "mechanism": [rc.JointForceAbove(1.0, joint="moter"), rc.ContactForceAbove(1.0, "flor")],
    }
    for condition in conditions[scene.kind]:
        with pytest.raises(rc.NoSuchPart, match=r"did you mean|from 1 to 38"):
            rc.Simulation(scene).run(1e-3, stop=condition, progress=False)


def test_a_part_without_the_quantity_gets_an_error_and_the_run_stays_as_it_was(scene):
    simulation = rc.Simulation(scene)
    (part, _), load = INPUTS[scene.kind]
    simulation.step_to(1e-3)
    before = simulation.state()["snapshot"]
    for call, name, value in [
        (simulation.set_speed, load, 1.0),
        (simulation.set_torque, part, 1.0),
        (simulation.set_speed, part, "fast"),
        (simulation.set_torque, load, [(1.0, 0.0), (0.0, 1.0)]),
        (simulation.set_torque, load, np.nan),
        (simulation.set_speed, "wheel_9", 1.0),
        (simulation.set_speed, None, 1.0),
        (simulation.set_torque, True, 1.0),
    ]:
        with pytest.raises(rc.InvalidInput):
            call(name, value)
        assert simulation.state()["snapshot"] == before


def test_a_driver_or_torque_of_a_mechanism_is_found_by_its_name_and_a_wrong_one_gets_the_nearest():
    simulation = rc.Simulation(crank())
    for call, wrong, text in [
        (simulation.set_speed, "moter", "did you mean 'motor'"),
        (simulation.set_torque, "laod", "did you mean 'load'"),
        (simulation.set_speed, 1, "known: 'motor'"),
        (simulation.set_speed, "bearing", "a joint without prescribed motion"),
    ]:
        with pytest.raises(rc.InvalidInput, match=text):
            call(wrong, 1.0)


def test_peaks_are_at_least_what_the_rows_show_and_bound_their_impulse(scene):
    result = rc.Simulation(scene).run(0.02, STEP, progress=False)
    for peak, channel in PEAKS[scene.kind]:
        largest = getattr(result.peaks, peak)
        rows = result.array(channel)
        rows = np.hypot(rows[..., 0], rows[..., 1]) if channel == "joint_reaction" else rows
        assert largest.shape == rows.shape
        assert largest.max() > 0.0
        # The first row has no interval before it.
        assert (largest[1:] >= rows[1:] * (1.0 - 1e-12)).all()
        impulse = getattr(result.peaks, peak.replace("force", "impulse"))
        # An impulse of an interval is at most its largest force times its length.
        assert (impulse[1:] <= largest[1:] * STEP * (1.0 + 1e-9)).all()


def test_every_channel_has_a_name_dimensions_and_a_unit(result):
    table = result.to_xarray()
    over_time = [one for one in table.variables.values() if one.dims[:1] == ("time",)]
    assert len(over_time) >= len(result.arrays)
    for name, variable in table.items():
        assert variable.attrs["units"], name


def test_a_body_is_found_by_its_name_and_a_wrong_one_gets_the_nearest(scene):
    simulation = rc.Simulation(scene)
    record = ("bodies",)
    found = simulation.run(3e-4, STEP, record=record, progress=False)
    name = simulation.body_names[1]
    np.testing.assert_array_equal(found.body(name).position, found.arrays["positions"][:, 1])
    with pytest.raises(rc.NoSuchPart, match=f"did you mean '{name}'"):
        found.body(name + "x")


def test_an_evaluation_has_no_side_effects_and_names_what_it_has(scene):
    simulation = rc.Simulation(scene)
    before = simulation.state()
    first, second = simulation.evaluate(), simulation.evaluate()
    assert first == second
    assert simulation.state()["snapshot"] == before["snapshot"]
    assert first.accelerations.shape == (len(simulation.body_names), 3)
    missing = {"drive": "joint_reaction", "mechanism": "hinge_force"}[scene.kind]
    with pytest.raises(AttributeError, match=missing):
        getattr(first, missing)
    with pytest.raises(ValueError, match="read-only"):
        first.accelerations[0] = 0.0


def test_arrays_of_the_present_state_are_read_only(scene):
    simulation = rc.Simulation(scene)
    for values in (simulation.positions, simulation.velocities):
        with pytest.raises(ValueError, match="read-only"):
            values[0, 0] = 1.0


def test_a_start_of_ones_own_is_where_the_simulation_begins(scene):
    simulation = rc.Simulation(scene)
    positions, velocities = simulation.positions.copy(), simulation.velocities
    made = rc.Simulation(scene, positions=positions, velocities=velocities)
    np.testing.assert_allclose(made.positions, positions, atol=1e-12)
    assert made.scene.positions == tuple(map(tuple, positions))


def test_a_static_start_balances_all_forces_and_keeps_the_speeds_of_motors(scene):
    simulation = rc.Simulation(scene, start="static")
    assert simulation.rest["residual"] < 1e-6 * max(simulation.rest["largest_force"], 1.0)
    _, body = INPUTS[scene.kind][0]
    number = simulation.body_names.index(body)
    generated = rc.Simulation(scene)
    assert simulation.velocities[number, 2] == pytest.approx(generated.velocities[number, 2])
    assert simulation.run(DURATION, STEP, progress=False).success


def test_a_sweep_runs_to_the_bits_of_single_runs(scene):
    solvers = [replace(scene.solver, max_step=step) for step in (1e-4, 5e-5)]
    found = rc.sweep(scene, {"solver": solvers}, duration=1e-3, progress=False)
    assert found.success
    for solver, one in zip(solvers, found.results, strict=True):
        alone = rc.Simulation(replace(scene, solver=solver)).run(1e-3, progress=False)
        assert one.scene == alone.scene
        np.testing.assert_array_equal(one.final_positions, alone.final_positions)


def test_a_study_measures_replicates(scene):
    found = rc.study(
        scene,
        lambda result: result.energy.kinetic[-1],
        runs=3,
        duration=1e-3,
        burn_in=0.0,
        progress=False,
    )
    assert found.statistics["value"].sel(statistic="count") == 3
    assert found.statistics["value"].sel(statistic="std") > 0.0


def test_sweeps_and_studies_are_equal_to_their_copies_and_repetitions(scene, tmp_path):
    def swept(step=2e-4, **more):
        axes = {"report_step": [1e-4, step], "rtol": [1e-6, -1.0]}  # the last one fails
        with pytest.warns(rc.CaseWarning):
            return rc.sweep(scene, axes, duration=4e-4, progress=False, **more)

    def studied(runs=2):
        measure = lambda result: {"work": result.energy.external_work[-1], "none": np.nan}  # noqa: E731
        return rc.study(scene, measure, runs=runs, duration=3e-4, burn_in=0.0, progress=False)

    for make, other in ((swept, swept(step=1e-4)), (studied, studied(runs=3))):
        made = make()
        copies = (copy.copy(made), copy.deepcopy(made), pickle.loads(pickle.dumps(made)))
        for each in (*copies, make()):
            assert each == made
        assert made != other
    stored = swept(store=tmp_path / "first")
    assert stored == swept(store=tmp_path / "first") == swept(store=tmp_path / "second")
    assert stored != swept(step=1e-4, store=tmp_path / "second")


def test_a_wrong_keyword_gets_the_nearest(scene):
    with pytest.raises(TypeError, match="did you mean 'solver'"):
        rc.Simulation(scene, slver=rc.Solver())


def test_a_figure_of_the_energy_is_drawn(result):
    assert len(result.plot.energy().axes) == 2
