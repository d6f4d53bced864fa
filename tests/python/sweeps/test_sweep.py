"""Many runs at once: the numbers of single runs, failures that stay alone, Ctrl-C, names."""

import gc
import json
import signal
import subprocess
import sys
import threading
import time
import warnings
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import rustchain as rc
from rustchain.sweeps.measure import check_names_of
from rustchain.sweeps.result import SweepResult

EXAMPLE = Path(__file__).parents[3] / "examples" / "three_shafts.toml"
PAPER = rc.paper_drive()
SHORT = {"duration": 5e-3, "report_step": 1e-4, "progress": False}  # contacts begin at 4.1 ms
FAR = 1000.0  # [s], hours of wall time away


def peak(result):
    return result.peaks.tooth_force.max()


def assert_same_run(one, other):
    assert one.arrays.keys() == other.arrays.keys()
    for name, values in one.arrays.items():
        np.testing.assert_array_equal(values, other.arrays[name], strict=True)
    for name in ("drive", "hinge_law", "tooth_law", "solver", "min_impact_velocity", "body_names"):
        assert getattr(one, name) == getattr(other, name)
    for end in ("initial", "final"):
        for quantity in ("positions", "velocities"):
            name = f"{end}_{quantity}"
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert (one.status, one.message) == (other.status, other.message)
    assert {n: v for n, v in one.stats.items() if "wall" not in n} == {
        n: v for n, v in other.stats.items() if "wall" not in n
    }


def test_an_iterator_of_groups_is_read_once_and_serves_every_case():
    run = {"duration": 2e-4, "progress": False, "threads": 1}
    axes = {"pretension": [0.0, 25.0]}
    swept = rc.sweep(PAPER, axes, lambda r: r.groups, record=iter(["hinges", "teeth"]), **run)
    assert list(swept.values) == [("hinges", "teeth")] * 2
    with pytest.raises(rc.InvalidInput, match=r"record: 1\.0 is no group"):
        rc.sweep(PAPER, axes, lambda r: r.groups, record=iter([1.0]), **run)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_every_case_is_its_single_run_to_the_last_bit(threads):
    """With pretensions that have and have not a tensioner, and laws and lengths that differ."""
    cases = [
        {"pretension": 0},
        {"pretension": 25},
        {"pretension": 25, "hinge_law": rc.Johnson(), "record": ("hinges", "bodies", "energy")},
        {"speed": 10.0, "rtol": 1e-7, "duration": 3e-3},
        {"pretension": 100.0, "min_impact_velocity": 1e-2, "energy": False},
    ]
    swept = rc.sweep(PAPER, cases, threads=threads, **SHORT)
    assert swept.success
    assert (swept.status, swept.errors, swept.axes) == ("finished", {}, None)
    driver = replace(PAPER.sprockets[0], motion=rc.PrescribedSpeed(10.0))
    slow = replace(PAPER, sprockets=[driver, PAPER.sprockets[1]])
    run = {"duration": 5e-3, "report_step": 1e-4, "progress": False}
    single = [
        rc.Simulation(PAPER).run(**run),
        rc.Simulation(rc.paper_drive(25)).run(**run),
        rc.Simulation(rc.paper_drive(25), hinge_law=rc.Johnson()).run(
            **run, record=("hinges", "bodies", "energy")
        ),
        rc.Simulation(slow, solver=rc.Solver(rtol=1e-7)).run(**(run | {"duration": 3e-3})),
        rc.Simulation(rc.paper_drive(100.0), min_impact_velocity=1e-2).run(**run, energy=False),
    ]
    for one, other in zip(swept.results, single, strict=True):
        assert_same_run(one, other)


def test_a_grid_is_ordered_as_nested_loops_and_measured_in_that_order():
    calls = []

    def measure(result):
        tensioner = result.drive.tensioner
        calls.append(threading.current_thread())
        return (tensioner.pretension if tensioner else 0.0), result.drive.chain.material.restitution

    swept = rc.sweep(
        PAPER,
        # The first cases take longest, so that others finish before them.
        {"pretension": [100, 0], "duration": [4e-3, 1e-4], "chain.material.restitution": [0.5, 1]},
        measure,
        threads=2,
        progress=False,
    )
    assert swept.cases[1] == {
        "pretension": 100,
        "duration": 4e-3,
        "chain.material.restitution": 1,
    }
    assert swept.values == [(p, r) for p in (100, 0) for _ in range(2) for r in (0.5, 1)]
    assert set(calls) == {threading.current_thread()}


def test_measured_numbers_become_a_dataset_with_the_axes_as_dimensions():
    def measure(result):
        return {"peak": peak(result), "tension": result.strand("upper").tension[-3:]}

    axes = {
        "pretension": np.array([0.0, 25.0]),
        "hinge_law": [rc.Hertz(), rc.Johnson(damping="lankarani-nikravesh")],
    }
    swept = rc.sweep(PAPER, axes, measure, **SHORT)
    data = swept.to_xarray()
    assert data.sizes == {"pretension": 2, "hinge_law": 2, "tension_0": 3}
    assert data["tension"].dims == ("pretension", "hinge_law", "tension_0")
    assert list(data["hinge_law"].values) == ["Hertz", "Johnson"]
    for case, value in zip(swept.cases, swept.values, strict=True):
        there = data.sel(pretension=case["pretension"], hinge_law=type(case["hinge_law"]).__name__)
        assert float(there["peak"]) == value["peak"] > 0.0
        np.testing.assert_array_equal(there["tension"], value["tension"])
    table = swept.to_pandas()
    assert list(table.columns) == [*axes, "peak", "tension_0", "tension_1", "tension_2"]
    np.testing.assert_array_equal(table["peak"], data["peak"].values.ravel())
    assert list(table["pretension"]) == [0.0, 0.0, 25.0, 25.0]


def test_listed_cases_become_a_dataset_over_the_cases():
    swept = rc.sweep(PAPER, [{"pretension": 0}, {"pretension": 25, "rtol": 1e-4}], peak, **SHORT)
    data = swept.to_xarray()
    assert data["value"].dims == data["pretension"].dims == ("case",)
    np.testing.assert_array_equal(data["value"], swept.values)
    np.testing.assert_array_equal(data["rtol"], [np.nan, 1e-4])
    assert list(swept.to_pandas()["pretension"]) == [0, 25]


def test_laws_of_one_kind_are_told_apart():
    laws = [rc.Johnson(), rc.Johnson(damping="lankarani-nikravesh")]
    swept = rc.sweep(PAPER, {"force_law": laws}, peak, duration=1e-4, progress=False)
    assert list(swept.to_xarray()["force_law"].values) == list(map(repr, laws))


def test_measuring_arrays_of_different_shapes_leaves_them_as_values():
    def measure(result):
        return {"time": result.time, "end": result.time[-1]}

    swept = rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, measure, progress=False)
    assert [len(value["time"]) for value in swept.values] == [11, 21]
    with pytest.warns(
        UserWarning, match=r"'time' has shape \(11,\) .* and \(21,\) in another: NaN"
    ):
        data = swept.to_xarray()
    assert data["time"].shape == (2, 21)
    np.testing.assert_array_equal(data["time"].isnull().sum("time_0"), [10, 0])
    np.testing.assert_array_equal(data["time"][0, :11], swept.values[0]["time"])
    with pytest.warns(UserWarning, match="NaN fills the table"):
        assert list(swept.to_pandas()["end"]) == [1e-3, 2e-3]


def test_a_number_and_an_array_stand_in_one_table():
    def measure(result):
        return 3.0 if len(result.time) == 11 else [[1.0, 2.0]]

    swept = rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, measure, progress=False)
    with pytest.warns(UserWarning, match="NaN fills the table"):
        data = swept.to_xarray()
    np.testing.assert_array_equal(data["value"], [[[3.0, np.nan]], [[1.0, 2.0]]])


def test_whole_numbers_stay_whole_where_nothing_is_missing():
    swept = rc.sweep(PAPER, {"rtol": [1e-4, 1e-5]}, lambda r: r.stats["steps"], **SHORT)
    assert swept.to_xarray()["value"].dtype.kind == "i"


def test_results_are_kept_or_measured_and_each_says_so():
    kept = rc.sweep(PAPER, {"pretension": [0]}, duration=1e-4, progress=False)
    assert isinstance(kept.results[0], rc.Result)
    for table in (kept.to_xarray, kept.to_pandas):
        with pytest.raises(rc.NotRecorded, match="measure="):
            table()
    measured = rc.sweep(PAPER, {"pretension": [0]}, peak, duration=1e-4, progress=False)
    with pytest.raises(rc.NotRecorded, match="without measure"):
        _ = measured.results


@pytest.mark.parametrize("name", ["speed", "error", "case"])
def test_a_measured_name_that_is_taken_ends_the_sweep_with_its_first_case(name, tmp_path):
    calls = []

    def measure(result):
        calls.append(1)
        return {"peak": 1.0, name: 1.0}

    axes = {"speed": [1.0, 2.0, 3.0, 4.0]}
    for store in (None, tmp_path):
        with pytest.raises(rc.InvalidInput, match=f"measure: '{name}' is the name of a parameter"):
            rc.sweep(PAPER, axes, measure, store=store, threads=1, **SHORT)
    assert len(calls) == 2
    assert list(tmp_path.iterdir()) == []
    calls.clear()
    with pytest.raises(rc.InvalidInput, match=f"'{name}' is"):
        rc.study(PAPER, measure, axes=axes, threads=1, burn_in=0.0, **SHORT)
    assert len(calls) == 1


@pytest.mark.parametrize(
    ("measured", "named"),
    [
        ({"value": [1, 2], "value_0": 7}, "measured quantity 'value_0'"),
        ({"value": np.ones((5, 2)), "value_4": [1, 2]}, "measured quantity 'value_4'"),
        (np.ones((10, 2)), "parameter or dimension 'value_9_1'"),
    ],
)
def test_a_name_that_a_number_of_an_array_has_in_tables_is_refused(measured, named):
    """By the sweep with its first case, and by the tables."""
    calls = []

    def measure(result):
        calls.append(1)
        return measured

    axes = {"value_9_1": [0.0, 25.0]}
    said = f"the {named} and a dimension or a number of the array 'value' have the same name; name"
    with pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(lambda value_9_1: rc.paper_drive(value_9_1), axes, measure, threads=1, **SHORT)
    assert len(calls) == 1
    found = SweepResult([{"value_9_1": 0.0}], None, [measured])
    for table in (found.to_xarray, found.to_pandas):
        with pytest.raises(rc.InvalidInput, match=said):
            table()


def test_names_of_two_cases_may_clash_in_tables():
    found = SweepResult([{"n": 0}, {"n": 1}], None, [{"a": [1, 2]}, {"a_1": 7}])
    with pytest.raises(rc.InvalidInput, match="'a_1' and a dimension or a number of the array 'a'"):
        found.to_pandas()


def test_two_measured_names_of_one_text_are_refused():
    """By the sweep with its first case, and by the tables of two cases."""
    said = "measure: 1 and '1' are one name in tables"
    with pytest.raises(rc.InvalidInput, match=said):
        rc.sweep(PAPER, {"pretension": [0.0]}, lambda _: {1: 2.0, "1": 3.0}, **SHORT)
    found = SweepResult([{"n": 0}, {"n": 1}], None, [{1: 2.0}, {"1": 3.0}])
    with pytest.raises(rc.InvalidInput, match=said):
        found.to_xarray()


def test_a_measured_array_with_rows_of_unlike_lengths_has_no_table():
    found = SweepResult([{"n": 0}], None, [{"a": 1.0, "b": [[1], [2, 3]]}])
    for table in (found.to_xarray, found.to_pandas):
        with pytest.raises(rc.InvalidInput, match=r"'b' = \[\[1\], \[2, 3\]\] has rows of"):
            table()


def test_names_that_no_number_of_an_array_has_are_kept():
    measured = {"a": np.ones((5, 2)), "a_4": 1.0, "a_00": 2.0, "a_5_0": 3.0, "b": [[1], [2, 3]]}
    check_names_of(measured, {"a_x", "b_0"})
    columns = SweepResult([{}], None, [{**measured, "b": 0.0}]).to_pandas().columns
    assert len(columns) == len(set(columns)) == 10 + 4


# --- parameters


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


# --- failures


def test_failing_cases_leave_the_others_alone_and_are_told_once():
    cases = [
        {"pretension": 0},
        {"pretension": -1},  # refused as a value
        {"chain.links": 20},  # no initial configuration
        {"chain.material.elastic_modulus": 1e300},  # fails under way, at the first contact
        {"pretension": 25},
    ]
    with pytest.warns(RuntimeWarning) as caught:
        swept = rc.sweep(PAPER, cases, peak, **SHORT)
    assert [warning.filename for warning in caught] == [__file__]
    said = str(caught[0].message)
    assert said.startswith("3 of 5 cases failed, first case 1 (pretension=-1): InvalidInput: Tens")
    assert (swept.status, swept.success) == ("finished", False)
    assert "2 of 5 cases finished, 3 failed" in swept.message
    assert list(swept.errors) == [1, 2, 3]
    assert swept.values[1:4] == [None] * 3
    for place in (0, 4):
        drive = rc.paper_drive(cases[place]["pretension"])
        assert swept.values[place] == peak(rc.Simulation(drive).run(**SHORT))
    assert "Tensioner.pretension = -1" in str(swept.errors[1])
    assert "the chain has no initial configuration" in str(swept.errors[2])
    error = swept.errors[3]
    assert isinstance(error, rc.SimulationError)
    assert error.__notes__[-1].startswith("in case 3 (chain.material.elastic_modulus=1e+300")
    chain = replace(PAPER.chain, material=rc.Material(elastic_modulus=1e300))
    alone = rc.Simulation(replace(PAPER, chain=chain))
    with pytest.raises(rc.SimulationError) as single:
        alone.run(**SHORT)
    assert str(error) == str(single.value)
    assert len(error.result.time) >= 20
    assert_same_run(error.result, single.value.result)


def test_failed_cases_are_nan_in_the_tables():
    with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
        swept = rc.sweep(PAPER, {"pretension": [-1, 0]}, lambda r: {"n": len(r.time)}, **SHORT)
    np.testing.assert_array_equal(swept.to_xarray()["n"], [np.nan, 51])
    np.testing.assert_array_equal(swept.to_pandas()["n"], [np.nan, 51])


def test_a_measure_that_raises_is_the_error_of_its_case():
    def measure(result):
        if result.drive.tensioner is None:
            raise LookupError("no tensioner")
        return peak(result)

    with pytest.warns(RuntimeWarning, match="case 1 .*LookupError: 'no tensioner'|no tensioner"):
        swept = rc.sweep(PAPER, {"pretension": [25, 0, 50]}, measure, threads=2, **SHORT)
    assert list(swept.errors) == [1]
    assert isinstance(swept.errors[1], LookupError)
    place, case = swept.errors[1].__notes__
    assert place.startswith("raised at test_sweep.py, line ")
    assert case == "in case 1 (pretension=0) of the sweep"
    assert [value is None for value in swept.values] == [False, True, False]


def test_the_error_of_a_measure_keeps_no_result_in_memory():
    results = []

    def measure(result):
        results.append(weakref.ref(result))
        own = result
        try:
            raise KeyError(own.time.size)
        except KeyError as error:
            raise ValueError("none") from error

    with pytest.warns(RuntimeWarning, match="2 of 2 cases failed"):
        swept = rc.sweep(PAPER, {"rtol": [1e-5, 1e-4]}, measure, **SHORT)
    gc.collect()
    assert [result() for result in results] == [None, None]
    assert swept.errors[0].__notes__[0].startswith("raised at test_sweep.py, line ")


def test_a_sweep_of_which_every_measure_fails_still_has_its_axes():
    with pytest.warns(RuntimeWarning, match="2 of 2"):
        swept = rc.sweep(PAPER, {"rtol": [1e-5, 1e-4]}, lambda r: 1 / 0, duration=1e-4)
    assert dict(swept.to_xarray().sizes) == {"rtol": 2}


def test_laws_out_of_their_range_are_told_once_for_the_whole_sweep():
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        swept = rc.sweep(
            drive,
            {"force_law": [rc.Hertz(), rc.EnhancedCylinder()], "speed": [5.0, 6.0]},
            duration=1e-4,
        )
    assert [(w.category, w.filename) for w in caught] == [(rc.RangeWarning, __file__)]
    assert "2 of 4 cases, first case 2 (force_law=EnhancedCylinder(" in str(caught[0].message)
    assert list(swept.law_warnings) == [2, 3]
    assert all("enhanced" in note for notes in swept.law_warnings.values() for note in notes)


# --- under way


def test_others_run_on_while_a_case_is_measured():
    """The first case is measured until the second one, which runs meanwhile, has ended."""
    reached = []

    def callback(simulation):
        reached.append(simulation.time)

    def measure(result):
        if len(measured) == 0:
            while max(reached) < 2e-3 - 1e-12:
                time.sleep(1e-3)
        measured.append(result.time[-1])

    measured = []
    axes = {"duration": [1e-3, 2e-3]}
    rc.sweep(PAPER, axes, measure, callback=callback, threads=1, progress=False)
    assert measured == [1e-3, 2e-3]


def test_an_interrupted_sweep_returns_soon_with_what_has_finished():
    script = f"""
import json, os, signal, threading
import rustchain as rc

# A job in the background is born deaf to it.
signal.signal(signal.SIGINT, signal.default_int_handler)
measured = []
def measure(result):
    measured.append(result.time[-1])
    if len(measured) == 2:
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()
    return float(result.time[-1])

axes = {{"duration": [1e-3, {FAR}, 2e-3, {FAR}, {FAR}]}}
swept = rc.sweep(rc.paper_drive(), axes, measure, threads=3, record=("energy",), energy=False)
print(json.dumps(dict(
    status=swept.status, message=swept.message, success=swept.success, values=swept.values,
    errors=len(swept.errors), missing=int(swept.to_xarray()["value"].isnull().sum()),
)))
"""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", script], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["status"], said["success"], said["errors"]) == ("interrupted", False, 0)
    assert said["message"] == "interrupted: 2 of 5 cases finished, 0 failed"
    assert said["values"] == [1e-3, None, 2e-3, None, None]
    assert said["missing"] == 3


@pytest.mark.skipif(not hasattr(signal, "SIGALRM"), reason="no interval timer here")
def test_a_handler_of_ones_own_is_heard_and_ends_the_runs():
    class Alarm(BaseException):
        pass

    def ring(number, frame):
        raise Alarm

    before = signal.signal(signal.SIGALRM, ring)
    threads = threading.active_count()
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.3)
        with pytest.raises(Alarm):
            rc.sweep(
                PAPER, {"duration": [FAR, FAR]}, record=("energy",), energy=False, progress=False
            )
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert threading.active_count() == threads


def test_what_ends_a_sweep_has_the_cases_that_are_done():
    def measure(result):
        if len(result.time) > 11:
            raise SystemExit(3)
        return 1.0

    axes = {"duration": [1e-3, 2e-3, 3e-3]}
    with pytest.raises(SystemExit) as caught:
        rc.sweep(PAPER, axes, measure, threads=1, progress=False)
    found = caught.value.result
    assert (found.status, found.finished, found.values[0]) == ("interrupted", 1, 1.0)


def test_a_warning_raised_as_an_error_has_the_result():
    drive = rc.two_sprocket_drive(chain="ANSI 160", teeth=(17, 17), links=38)
    scene = rc.Scene(drive, rc.EnhancedCylinder())
    with warnings.catch_warnings():
        warnings.simplefilter("error", rc.RangeWarning)
        with pytest.raises(rc.RangeWarning) as caught:
            rc.sweep(scene, {"speed": [5.0]}, duration=1e-4, progress=False)
    assert caught.value.result.finished == 1


@pytest.mark.parametrize("portion", [1, 64])
def test_progress_is_shown_in_cases_and_simulated_seconds(portion, monkeypatch):
    bars = []

    class Bar:
        disable = False

        def __init__(self, **keywords):
            self.n, self.keywords, self.said = 0.0, keywords, []
            bars.append(self)

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def update(self, n):
            assert n >= 0.0
            self.n += n

        def set_description(self, text):
            self.said.append(text)

    monkeypatch.setattr("tqdm.auto.tqdm", Bar)
    monkeypatch.setattr("rustchain.sweeps.running._PORTION", portion)
    rc.sweep(PAPER, {"duration": [1e-3, 2e-3]}, threads=1)
    rc.sweep(PAPER, {"duration": [1e-3]}, progress=False)
    (shown,) = bars
    assert shown.keywords["total"] == pytest.approx(3e-3)
    assert shown.n == pytest.approx(3e-3)
    assert shown.keywords["desc"] == "0 of 2 cases"
    assert shown.said == ["1 of 2 cases", "2 of 2 cases"]
    assert shown.keywords["disable"] is None  # where there is no terminal


def test_without_a_terminal_progress_is_lines_now_and_then(monkeypatch, capsys):
    rc.Simulation(PAPER).run(1e-3)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("rustchain.simulation.run._BETWEEN_LINES", 0.0)
    rc.Simulation(PAPER).run(1e-3, callback=lambda _: None)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) <= 11
    assert lines[0] == "run: 0.0001 of 0.0010 s simulated (10%) in 0 s"
    rc.Simulation(PAPER).run(1e-3, 1e-6, callback=lambda _: None)
    assert 50 < len(capsys.readouterr().err.splitlines()) <= 100
    rc.sweep(PAPER, {"speed": [5.0, 6.0]}, duration=1e-3, callback=lambda _: None, threads=1)
    assert capsys.readouterr().err.splitlines()[-1].startswith("1 of 2 cases: 0.0020 of 0.0020 s")
    rc.Simulation(PAPER).run(1e-3, progress=False)
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stderr", None)
    assert rc.Simulation(PAPER).run(1e-3).success


def test_the_start_is_a_parameter_and_cases_begin_there():
    drive = rc.paper_drive(pretension=100.0)
    found = rc.sweep(drive, {"start": ["generated", "static"]}, duration=5e-4, progress=False)
    for start, result in zip(["generated", "static"], found.values, strict=True):
        alone = rc.Simulation(drive, start=start).run(5e-4, progress=False)
        assert result.drive == alone.drive
        for name, values in alone.arrays.items():
            np.testing.assert_array_equal(result.arrays[name], values, err_msg=name)
    tension = [result.strand("upper").tension[0] for result in found.values]
    assert tension[0] == 0.0
    assert tension[1] > 50.0


def test_positions_and_velocities_of_ones_own_are_keywords_and_parameters():
    calm = rc.Simulation(PAPER)
    pushed = calm.velocities.copy()
    pushed[:38, 0] += 0.1
    found = rc.sweep(
        PAPER, {"velocities": [calm.velocities, pushed]}, duration=2e-4, progress=False
    )
    alone = rc.Simulation(PAPER, velocities=pushed).run(2e-4, progress=False)
    for name, values in alone.arrays.items():
        np.testing.assert_array_equal(found.values[1].arrays[name], values, err_msg=name)
    both = {"positions": calm.positions, "velocities": pushed}
    same = rc.sweep(rc.Scene(PAPER, **both), [{}], duration=2e-4, progress=False)
    np.testing.assert_array_equal(same.values[0].final_positions, alone.final_positions)


def test_a_start_that_ideal_hinges_change_is_told_once_as_by_a_single_run():
    drive = replace(PAPER, hinges="ideal")
    made = rc.Simulation(drive)
    moved = made.positions.copy()
    moved[3, 1] += 1e-3
    scene = rc.Scene(drive, positions=moved, velocities=made.velocities)
    with pytest.warns(UserWarning, match=r"links had to be moved by up to 7\.\d+e-04 m") as caught:
        rc.sweep(scene, {"rtol": [1e-5, 1e-6]}, duration=1e-4, progress=False)
    assert len(caught) == 1


def test_a_start_that_is_none_is_refused():
    with pytest.raises(rc.InvalidInput, match="start = 'rest': must be 'generated' or 'static'"):
        rc.sweep(PAPER, {"start": ["rest"]}, progress=False)


def test_cases_that_are_looked_at_are_those_of_single_runs_to_the_bit():
    drive = rc.paper_drive()
    axes = {"pretension": [0.0, 50.0]}
    plain = rc.sweep(drive, axes, duration=4e-3, progress=False)
    looked = rc.sweep(
        drive, axes, duration=4e-3, progress=False, callback=lambda _: None, threads=2
    )
    for one, other in zip(plain.results, looked.results, strict=True):
        np.testing.assert_array_equal(one.final_positions, other.final_positions)
    assert looked.success


def test_a_stop_condition_ends_its_case_alone():
    axes, given = {"pretension": [0.0, 100.0]}, {"duration": 8e-3, "progress": False}
    peaks = [run.peaks.tooth_force.max() for run in rc.sweep(PAPER, axes, **given).results]
    assert min(peaks) < 0.9 * max(peaks)
    stop = rc.ToothForceAbove(float(np.mean(peaks)))
    found = rc.sweep(PAPER, axes, stop=stop, **given)
    ends = ["stopped" if peak > stop.force else "finished" for peak in peaks]
    assert [run.status for run in found.results] == ends
    stopped = found.results[ends.index("stopped")]
    assert stopped.peaks.tooth_force[-1].max() > stop.force
    assert (stopped.peaks.tooth_force[:-1] <= stop.force).all()
    assert found.success
    with pytest.raises(rc.InvalidInput, match="stop = 3: must be a stop condition"):
        rc.sweep(rc.paper_drive(), {"speed": [1.0]}, stop=3)
    with pytest.raises(rc.InvalidInput, match="threads = 0: must be"):
        rc.sweep(rc.paper_drive(), {"speed": [1.0]}, stop=stop, threads=0)


def test_what_a_callback_raises_fails_its_case_and_leaves_the_others():
    def callback(simulation):
        if simulation.drive.sprockets[0].motion.speed > 15.0 and simulation.time > 1e-3:
            raise RuntimeError("not that fast")

    with pytest.warns(RuntimeWarning, match="1 of 2 cases failed"):
        sweep = rc.sweep(
            rc.paper_drive(),
            {"speed": [10.0, 20.0]},
            duration=3e-3,
            progress=False,
            callback=callback,
        )
    assert list(sweep.errors) == [1]
    assert sweep.results[0].success
    assert len(sweep.errors[1].result.time) == 12


def test_a_simulation_or_a_result_is_no_scene_but_has_one():
    simulation = rc.Simulation(PAPER)
    result = simulation.run(1e-4, progress=False)
    for given, name in ((simulation, "simulation"), (result, "result")):
        for call in (rc.Simulation, lambda given: rc.sweep(given, {"rtol": [1e-5]})):
            with pytest.raises(rc.InvalidInput, match=rf"; use {name}\.scene"):
                call(given)


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_a_loss_map_refuses_a_torque_that_helps(side):
    sprockets = [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(20.0)),
        rc.Sprocket(25, (0.3, 0.0), rc.Free() if side == "outside" else rc.AppliedTorque(-2.0)),
        rc.Sprocket(
            13, (0.15, 0.03), rc.AppliedTorque(2.0) if side == "outside" else rc.Free(),
            side="outside",
        ),
    ]  # fmt: skip
    drive = rc.chain_drive("ANSI 40", sprockets, adjust=2)
    loaded, helping = (3, -2.0) if side == "outside" else (2, 2.0)
    with pytest.raises(rc.InvalidInput, match=f"turns sprocket {loaded} the way it goes"):
        rc.loss_map(drive, [20.0], [helping], loaded=loaded, duration=1e-3, burn_in=5e-4)
    with pytest.raises(rc.InvalidInput, match="sprocket 1 is the driver"):
        rc.loss_map(drive, [20.0], [-2.0], loaded=1, duration=1e-3, burn_in=5e-4)


def test_a_data_frame_of_cases_is_refused_with_what_to_take():
    table = pd.DataFrame({"pretension": [25.0, 50.0]})
    with pytest.raises(rc.InvalidInput, match=r"of a DataFrame take \.to_dict\('records'\)"):
        rc.sweep(rc.paper_drive(), table, duration=1e-3)
    cases = table.to_dict("records")
    found = rc.sweep(rc.paper_drive(), cases, duration=1e-3, progress=False)
    assert found.cases == cases
