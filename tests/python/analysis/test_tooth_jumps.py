"""Tooth jumps: counted, warned of, stopped at, and refused by outputs of a seated chain."""

import re
import warnings
from dataclasses import replace
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

import rustchain as rc

RECORD = ("hinges", "teeth", "sprockets", "energy")


def overloaded(torque=-10.0):
    """Return a drive whose load needs 197 N of difference, and whose tensioner keeps 100 N."""
    return rc.two_sprocket_drive(
        "ANSI 40", (17, 25), links=60, speed=20, torque=torque, pretension=50
    )


def simulation():
    return rc.Simulation(overloaded(), force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1)))


@pytest.fixture(scope="module")
def jumped():
    """Return a run in which the overloaded drive jumps, and the warnings of it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        result = simulation().run(0.5, report_step=1e-3, record=RECORD)
    return result, caught


def test_an_overloaded_drive_jumps_teeth_as_often_as_its_sprockets_get_out_of_step(jumped):
    result, _ = jumped
    jumps = result.tooth_jumps
    assert result.status == "finished"
    # The load holds sprocket 2 back, so that it lags; where sprocket 1 jumps, it leads.
    assert len(jumps) >= 2
    assert set(zip(jumps["sprocket"], jumps["direction"], strict=True)) <= {(1, 1), (2, -1)}
    angle, center = result.array("sprocket_angle"), result.array("sprocket_center")
    turned = angle - angle[0]
    lag = (turned[:, 0] * 17 - turned[:, 1] * 25) / (2 * np.pi)
    # The tight strand takes up what the centre has come nearer.
    nearer = (center[0, 1, 0] - center[:, 1, 0]) / result.drive.chain.pitch
    counted = np.searchsorted(jumps["time"], result.time, "right")
    settled = np.abs(result.time[:, None] - np.array(jumps["time"])).min(axis=1) > 0.02
    assert np.abs(lag - nearer - counted)[settled].max() < 0.3


@pytest.mark.filterwarnings("ignore::rustchain.ToothJumpWarning")
def test_a_file_that_is_written_in_pieces_has_each_tooth_jump_once(jumped, tmp_path):
    out = tmp_path / "run.nc"
    keywords = {"report_step": 2e-4, "record": RECORD, "out": out, "memory": "4 MB"}
    streamed = simulation().run(0.5, **keywords)
    for result in (streamed, rc.load_result(out)):
        for column, expected in zip(result.jumps, jumped[0].jumps, strict=True):
            np.testing.assert_array_equal(column, expected)
    with h5py.File(out, "r+") as file:  # as a kill between two columns leaves it
        file["jump_direction"].resize(1, axis=0)
    assert rc.load_result(out).tooth_jumps.equals(jumped[0].tooth_jumps[:1])


def test_a_run_warns_once_of_its_tooth_jumps(jumped):
    result, caught = jumped
    told = [str(w.message) for w in caught if w.category is rc.ToothJumpWarning]
    assert len(told) == 1
    first = result.tooth_jumps.iloc[0]
    assert told[0].startswith(f"the chain jumped {len(result.tooth_jumps)} teeth")
    assert f"sprocket {first['sprocket']:.0f} at t = {first['time']:.6f} s" in told[0]


def test_outputs_of_a_seated_chain_say_that_it_jumped_instead_of_giving_nan(jumped):
    result, _ = jumped
    for output in (result.transmission_error, result.efficiency):
        with pytest.raises(rc.InvalidInput, match=r"the chain jumped \d teeth .*tooth_jumps"):
            output()
    summary = result.summary()
    assert summary["tooth_jumps"] == len(result.tooth_jumps)
    assert not {"efficiency", "transmission_error_2"} & set(summary)
    assert np.isfinite(list(summary.values())).all()
    assert result.power_balance().attrs["tooth_jumps"] == len(result.tooth_jumps)


def test_a_part_without_jumps_is_that_of_a_seated_chain(jumped):
    result, _ = jumped
    before = float(result.tooth_jumps["time"].iloc[0]) - 1e-3
    assert len(result.between(end=before).tooth_jumps) == 0
    assert np.isfinite(result.transmission_error(start=0.1, end=before)["error"]).all()
    assert 0.5 < result.between(end=before).efficiency(after=0.1) < 1.0


def test_hinges_are_where_they_were_on_the_way_after_a_jump_of_the_first_sprocket(jumped):
    from dataclasses import replace

    from rustchain.analysis.circuit import Circuit

    result, _ = jumped
    way = Circuit.of(result.drive)
    one = (np.array([result.time[100]]), np.array([1]), np.array([1]))
    none = tuple(column[:0] for column in one)
    moved, seated = (way.moved(replace(result, jumps=each)) for each in (one, none))
    np.testing.assert_array_equal(moved[:100], seated[:100])
    np.testing.assert_allclose(seated[100:] - moved[100:], 1.0, rtol=1e-12)


def test_a_saved_result_keeps_its_tooth_jumps(jumped, tmp_path):
    assert jumped[0].to_xarray()["jump_time"].attrs["units"] == "s"
    result, _ = jumped
    result.save(tmp_path / "jumped.nc")
    found = rc.load_result(tmp_path / "jumped.nc")
    assert found.tooth_jumps.equals(result.tooth_jumps)
    seated = result.between(end=0.1)
    seated.save(tmp_path / "seated.nc")
    assert len(rc.load_result(tmp_path / "seated.nc").tooth_jumps) == 0


def test_a_run_stops_at_the_first_jump_and_a_state_keeps_the_count(tmp_path):
    whole = simulation()
    with pytest.warns(rc.ToothJumpWarning, match="jumped 1 tooth"):
        first = whole.run(1.0, report_step=1e-3, record=RECORD, stop=rc.ToothJump())
    assert first.status == "stopped"
    assert "jumped a tooth of sprocket" in first.message
    assert len(first.tooth_jumps) == 1
    assert first.time[-1] - first.tooth_jumps["time"][0] < 1e-3
    whole.save_state(tmp_path / "state.npz")
    successor = rc.Simulation.load_state(tmp_path / "state.npz")
    results = []
    for each in (whole, successor):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", rc.ToothJumpWarning)
            results.append(each.run(0.2, report_step=1e-3, record=RECORD))
    for one, other in zip(results[0].jumps, results[1].jumps, strict=True):
        np.testing.assert_array_equal(one, other)
    assert len(results[0].jumps[0]) == 1 + len(results[0].tooth_jumps)


def test_a_sweep_warns_of_tooth_jumps_and_measures_the_others():
    with pytest.warns(rc.ToothJumpWarning, match=r"1 of 2 cases, first case 1 \(torque=-10\.0\)"):
        found = rc.sweep(
            lambda torque: rc.Scene(
                overloaded(torque), rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
            ),
            {"torque": [-1.0, -10.0]},
            rc.Result.summary,
            duration=0.4,
            report_step=1e-3,
        )
    assert found.success
    assert list(found.jump_warnings) == [1]
    data = found.to_xarray()
    assert data["tooth_jumps"][0] == 0
    assert data["tooth_jumps"][1] > 0
    np.testing.assert_array_equal(np.isnan(data["transmission_error_2"]), [False, True])


@pytest.mark.parametrize("pretension", [0.0, 25.0, 100.0])
def test_the_published_drive_never_jumps(pretension):
    result = rc.Simulation(rc.paper_drive(pretension)).run(0.2, report_step=1e-3, energy=False)
    assert len(result.tooth_jumps) == 0


def test_no_jump_is_counted_outside_the_chain_nor_where_it_is_open():
    open_chain = rc.open_chain(
        "ANSI 40",
        ends=(rc.AnchoredEnd((-0.16, -0.02), links=30), rc.LoadedEnd(5.0, arm=0.08)),
        links=60,
        sprockets=[rc.Sprocket(17, motion=rc.PrescribedSpeed([(0.0, 0.0), (0.02, 20.0)]))],
    )
    idler = rc.chain_drive(
        "ANSI 40",
        [
            rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(40.0)),
            rc.Sprocket(25, (0.3, 0.0)),
            rc.Sprocket(13, (0.15, 0.03), side="outside"),
        ],
        adjust=2,
    )
    for drive in (open_chain, idler):
        result = rc.Simulation(drive).run(0.15, report_step=1e-3, energy=False)
        assert np.ptp(result.sprocket(1).angle) > 4 * 2 * np.pi / 17
        assert len(result.tooth_jumps) == 0


def test_jumps_are_counted_with_ideal_hinges_as_with_clearance():
    """A chain with clearance jumps at 0.28 s, one with ideal hinges at 0.32 s."""
    first = []
    for hinges in ("clearance", "ideal"):
        drive = replace(overloaded(), hinges=hinges)
        with pytest.warns(rc.ToothJumpWarning, match="jumped 1 tooth"):
            result = rc.Simulation(drive).run(0.5, 1e-3, energy=False, stop=rc.ToothJump())
        assert result.status == "stopped"
        first.append(result.tooth_jumps["time"][0])
    assert first[1] == pytest.approx(first[0], rel=0.5)


def test_check_warns_of_a_load_that_the_pretension_cannot_hold():
    (told,) = [w for w in overloaded().check().warnings if "jump" in w]
    for number in ("10.0000 N m on sprocket 2", "197.4 N", "100.0 N", "98.7 N"):
        assert number in told
    for drive in (overloaded(torque=-4.0), rc.paper_drive(25.0), rc.paper_drive()):
        assert not [w for w in drive.check().warnings if "jump" in w]


def heavily_loaded(pretension, **tensioner):
    """Return a drive of 3 kW at 1450 rpm; its load acts while the tensioner force grows."""
    torque = -3000.0 / rc.rpm(1450) * 3
    drive = rc.two_sprocket_drive(
        "ISO 08B",
        (19, 57),
        center_distance=0.5,
        speed=rc.rpm(1450),
        torque=torque,
        pretension=pretension,
    )
    return replace(drive, tensioner=replace(drive.tensioner, **tensioner))


def test_check_warns_of_a_load_that_pushes_the_centre_back_during_the_ramp():
    """With friction, runs push it back by 11.06, 8.26 and 5.47 mm and jump, by 3.66 mm not."""
    for pretension, pushed in ((300.0, "10.9"), (400.0, "8.1"), (600.0, "5.4")):
        (told,) = [w for w in heavily_loaded(pretension).check().warnings if "jump" in w]
        assert f"over 0.1000 s, and pushes sprocket 2 back by about {pushed} mm" in told
    held = (
        heavily_loaded(900.0),
        heavily_loaded(300.0, ramp_time=0.02),
        heavily_loaded(300.0, ramp_time=0.0),
        heavily_loaded(300.0, damping_back=1e5),
        heavily_loaded(300.0, travel=(0.0, 0.02)),
        heavily_loaded(300.0, ratchet=0.0),
        heavily_loaded(300.0, stiffness=3e5),
    )
    for drive in held:
        assert not [w for w in drive.check().warnings if "jump" in w]


@pytest.mark.parametrize(("pretension", "stiffness"), [(600.0, 0.0), (300.0, 3e4)])
def test_a_run_pushes_the_centre_back_as_far_as_check_tells(pretension, stiffness):
    drive = heavily_loaded(pretension, stiffness=stiffness)
    (told,) = [w for w in drive.check().warnings if "jump" in w]
    law = rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    with pytest.warns(rc.ToothJumpWarning):
        result = rc.Simulation(drive, force_law=law).run(
            0.1, 1e-3, record=("bodies",), energy=False, progress=False
        )
    place = result.body("sprocket_2").position[:, 0]
    pushed = float(re.search(r"back by about ([\d.]+) mm", told)[1])
    assert 1e3 * (place[0] - place.min()) == pytest.approx(pushed, rel=0.05)


def test_the_inertia_of_a_load_moves_with_the_centre_during_the_ramp():
    """With friction, runs push it back by 5.43 mm and jump, by 9.70, 3.61 and 0 mm they do not."""
    for pretension, inertia, pushed in (
        (600.0, 0.1, ["5.3"]),
        (300.0, 1.0, ["9.4"]),
        (600.0, 1.0, []),
        (600.0, 10.0, []),
    ):
        drive = heavily_loaded(pretension)
        driver, driven = drive.sprockets
        drive = replace(drive, sprockets=(driver, replace(driven, load_inertia=inertia)))
        told = " ".join(drive.check().warnings)
        assert re.findall(r"back by about ([\d.]+) mm", told) == pushed


def test_a_static_start_has_no_ramp_to_warn_of():
    drive = heavily_loaded(300.0)
    static, ramp = rc.Scene(drive, start="static"), rc.Scene(drive)
    assert [w for w in ramp.check().warnings if "jump" in w]
    assert not [w for w in static.check().warnings if "jump" in w]
    assert replace(static.check(), warnings=()) == replace(ramp.check(), warnings=())
    assert rc.Simulation(ramp).check() == ramp.check()


def told_of_jumps(*motions, **first):
    """Return the warnings of jumps of a drive with these motions and a changed first sprocket."""
    drive = overloaded()
    sprockets = [
        replace(sprocket, motion=motion, initial_speed=None)
        for sprocket, motion in zip(drive.sprockets, motions, strict=True)
    ]
    sprockets[0] = replace(sprockets[0], **first)
    drive = replace(drive, sprockets=tuple(sprockets))
    return [w for w in drive.check().warnings if "jump" in w]


def test_the_chain_transmits_what_a_motor_leaves_beside_its_own_inertia():
    motor = rc.AppliedTorque(20.0)
    # Nothing else is driven but the chain and a disc of 5e-3 kg m^2.
    assert not told_of_jumps(motor, rc.Free(), load_inertia=0.5)
    # Most of the torque accelerates the disc; a run jumps after 97 ms.
    (told,) = told_of_jumps(motor, rc.Free())
    assert "on sprocket 1 needs" in told
    # At constant speed all of it goes to the load: 29.41 N m at a pitch radius of 50.66 mm.
    (told,) = told_of_jumps(motor, rc.AppliedTorque(-20.0 * 25 / 17), load_inertia=0.5)
    assert "needs 580.5 N more" in told


def test_a_load_that_grows_with_speed_counts_at_the_highest_speed():
    fan = rc.AppliedTorque(curve=[(0.0, 0.0), (20.0, -4.0), (40.0, -16.0)])
    from_rest = rc.PrescribedSpeed([(0.0, 0.0), (1.0, 40.0)])
    (told,) = told_of_jumps(from_rest, fan)
    # 40 rad/s of 17 teeth are 27.2 rad/s of 25 teeth: -4 - 7.2/20 * 12 N m.
    assert "the load of 8.3200 N m on sprocket 2" in told
    assert not told_of_jumps(rc.PrescribedSpeed(10.0), fan)
    # It is largest in between.
    stirrer = rc.AppliedTorque(curve=[(0.0, 0.0), (13.0, -20.0), (27.0, -2.0)])
    (told,) = told_of_jumps(from_rest, stirrer)
    assert "the load of 20.0000 N m on sprocket 2" in told
    # A motor reaches the speed at which the load takes all of its torque; a run jumps after 0.51 s.
    pump = rc.AppliedTorque(curve=[(-20.0, 30.0), (0.0, 0.0), (20.0, -30.0)])
    (told,) = told_of_jumps(rc.AppliedTorque(20.0), pump, load_inertia=0.5)
    assert "the load of 20.0000 N m on sprocket 1" in told


def test_a_stop_at_a_jump_names_the_first_new_one_of_its_sprocket():
    told = [(0.05, 2), (0.1, 1), (0.2, 2), (0.3, 1)]

    def watched(stop):
        """Return what a stop says before and after the last three jumps."""
        rows = [told[:1]]
        core = SimpleNamespace(
            tooth_jumps=lambda: (
                *map(np.array, zip(*rows[-1], strict=True)),
                np.zeros(len(rows[-1])),
            )
        )
        look = stop.look_at(SimpleNamespace(drive=overloaded(), _core=core))
        before = look()
        rows.append(told)
        return before, look()

    first = "the chain jumped a tooth of sprocket 1 at 0.1 s"
    assert watched(rc.ToothJump()) == (None, first)
    assert watched(rc.ToothJump(1)) == (None, first)
    assert watched(rc.ToothJump(2)) == (None, "the chain jumped a tooth of sprocket 2 at 0.2 s")


@pytest.mark.parametrize(
    "stop", [{"sprocket": 0}, {"sprocket": 1.5}, {"sprocket": "driver"}, {"sprocket": True}]
)
def test_a_stop_at_a_jump_refuses_what_is_no_sprocket(stop):
    with pytest.raises(rc.InvalidInput, match=r"ToothJump\.sprocket"):
        rc.ToothJump(**stop)


def test_onset_speeds_and_force_vectors_are_those_of_the_state():
    simulation = rc.Simulation(
        rc.paper_drive(25.0), force_law=rc.LankaraniNikravesh(friction=rc.Coulomb(0.1))
    )
    result = simulation.run(0.03, report_step=1e-4, energy=False)
    present, state = simulation.evaluate(), simulation.state()
    vector = result.array("tooth_force_vector")
    np.testing.assert_allclose(vector[-1], present.tooth_force_vector.sum(axis=1), atol=1e-9)
    touching = result.array("tooth_penetration") > 0.0
    assert touching[-1].any()
    assert (vector[~touching] == 0.0).all()
    speed = result.array("tooth_onset_speed")
    assert (speed[~touching] == 0.0).all()
    # Contacts that begin and end within a step have no onset. They are counted, up to 1 nm deep.
    without = touching & (speed == 0.0)
    assert without.sum() <= simulation.stats["in_step_contacts"]
    assert (result.array("tooth_penetration")[without] <= 1e-9).all()
    assert (speed[touching & ~without] >= simulation.min_impact_velocity).all()
    np.testing.assert_array_equal(
        speed[-1], np.where(touching[-1], state["tooth_onset_speed"].max(axis=1), 0.0)
    )
    closed = result.array("hinge_penetration") > 0.0
    speed = result.array("hinge_onset_speed")
    assert (speed[~closed] == 0.0).all()
    np.testing.assert_array_equal(speed[-1], np.where(closed[-1], state["hinge_onset_speed"], 0.0))
    # What a contact began with stays while it lasts.
    lasting = closed[1:] & closed[:-1]
    assert (speed[1:] == speed[:-1])[lasting].mean() > 0.9
    assert result.hinge(6).onset_speed is not None
    assert result.bushing(6).tooth_force_vector.shape == (len(result.time), 2)
