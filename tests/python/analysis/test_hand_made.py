"""Transmission error, ripple and powers of histories made by hand, each number worked out here."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

import rustchain as rc
from rustchain.analysis.transmission import order_spectrum

# Teeth 17, 25 and, on the outside, 13; the third runs free.
DRIVE = rc.chain_drive(
    "ANSI 40",
    [
        rc.Sprocket(17, (0.0, 0.0), rc.PrescribedSpeed(12.566)),
        rc.Sprocket(25, (0.35, -0.05), rc.AppliedTorque(-2.0)),
        rc.Sprocket(13, (0.18, -0.005), side="outside"),
    ],
)
PITCH = 0.0127  # [m]


@pytest.fixture(scope="module")
def run():
    return rc.Simulation(DRIVE).run(1e-3, record=("sprockets", "energy"), progress=False)


def history(run, time, **arrays):
    """Return a result with these arrays alone."""
    return replace(run, arrays={"time": time, **arrays})


def uneven(count, end):
    """Return times from 0.5 s whose steps grow to twice the first, and trapezoidal weights."""
    steps = np.linspace(1.0, 2.0, count - 1)
    time = 0.5 + end * np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
    weights = np.zeros(count)
    weights[:-1] += 0.5 * np.diff(time)
    weights[1:] += 0.5 * np.diff(time)
    return time, weights / weights.sum()


def test_the_error_is_what_the_driven_sprocket_lags_behind_the_ratio(run):
    """Driven 1 by driver 2: ratio 25 / 17. Angles begin anywhere; means are over uneven time."""
    time, weights = uneven(200, 2.0)
    turned = 3.0 * (time - time[0])
    error = 1e-3 * np.sin(25 * turned) + 4e-4 * turned
    angle = np.stack([0.7 + 25 / 17 * turned + error, 0.3 + turned, 0.1 - turned], axis=-1)
    found = history(run, time, sprocket_angle=angle).transmission_error(driven=1, driver=2)
    np.testing.assert_allclose(found["driver_angle"], turned, atol=1e-12)
    expected = error - weights @ error
    np.testing.assert_allclose(found["error"], expected, atol=1e-12)
    radius = PITCH / (2 * math.sin(math.pi / 17))
    np.testing.assert_allclose(found["error_length"], radius * expected, rtol=1e-6, atol=1e-15)
    assert found.attrs["ratio"] == pytest.approx(25 / 17)
    assert found.attrs["tooth_order"] == 25
    assert found.attrs["peak_to_peak"] == pytest.approx(np.ptp(error))
    assert found.attrs["peak_to_peak_length"] == pytest.approx(radius * np.ptp(error), rel=1e-6)


def test_the_ripple_is_the_speed_over_its_mean_less_one(run):
    time, weights = uneven(64, 1.0)
    speed = np.stack([np.full(64, 9.0), 5.0 + time, -8.0 - time], axis=-1)
    angle = np.stack([9.0 * time, 5.0 * time, 0.4 - 8.0 * time], axis=-1)
    found = history(run, time, sprocket_speed=speed, sprocket_angle=angle).speed_ripple(3)
    mean = -8.0 - weights @ time
    ripple = (-8.0 - time) / mean - 1.0
    np.testing.assert_array_equal(found["speed"], speed[:, 2])
    np.testing.assert_allclose(found["ripple"], ripple, atol=1e-13)
    assert found.attrs["mean"] == pytest.approx(mean)
    assert found.attrs["rms"] == pytest.approx(math.sqrt(weights @ ripple**2))
    assert found.attrs["peak_to_peak"] == pytest.approx(np.ptp(ripple))
    assert found.attrs["tooth_order"] == 13
    order = found["order"].to_numpy()
    assert order[1] == 1.0  # of the last of 1.27 revolutions


def test_a_speed_of_one_has_a_ripple_and_a_sprocket_at_rest_has_none(run):
    time = np.linspace(0.0, 1.0, 16)
    angle = np.stack([time] * 3, axis=-1)
    made = history(run, time, sprocket_speed=np.ones((16, 3)), sprocket_angle=angle)
    assert made.speed_ripple(2).attrs["rms"] == 0.0
    rest = replace(made, arrays={**made.arrays, "sprocket_speed": np.zeros((16, 3))})
    with pytest.raises(rc.InvalidInput, match=r"sprocket 2 is 0 rad/s, .*turns one way; take ano"):
        rest.speed_ripple(2)


def test_a_sprocket_that_turns_back_and_forth_has_no_ripple_and_no_orders(run):
    """Its mean speed is 0.39 and 0.61 of the RMS."""
    time = np.linspace(0.0, 1.0, 401)
    wave = 10.0 * np.sin(4 * math.pi * time)
    for offset, refused in ((3.0, True), (5.4, False)):
        speed = np.stack([wave + offset] * 3, axis=-1)
        angle = np.cumsum(speed, axis=0) / 400
        made = history(run, time, sprocket_speed=speed, sprocket_angle=angle)
        assert ("ripple_2" in made.summary()) is not refused
        for output, match in (
            (made.speed_ripple, r"mean speed of sprocket 2 is 3 rad/s, the RMS .* 7\.68 rad/s"),
            (made.transmission_error, r"back and forth by 6\.66 rad, and on by 3 rad; .* one way"),
        ):
            if refused:
                with pytest.raises(rc.InvalidInput, match=match):
                    output()
            else:
                assert float(output()["order"][1]) > 0.0


def test_orders_are_cycles_per_revolution_of_what_turned():
    """Three waves in two revolutions are of order 1.5; forwards and backwards alike."""
    angle = np.linspace(0.0, 4 * math.pi, 129)
    waves = 0.2 * np.sin(1.5 * angle)
    _, power = signal.periodogram(waves[1:], window="hann", detrend="linear", scaling="spectrum")
    for sign in (1.0, -1.0):
        order, amplitude = order_spectrum(sign * angle, waves)
        np.testing.assert_allclose(amplitude, np.sqrt(2.0 * power), atol=1e-12)
        np.testing.assert_array_equal(order, 0.5 * np.arange(65))
        assert order[amplitude.argmax()] == 1.5
        assert amplitude.max() == pytest.approx(0.2, rel=0.01)


def test_a_shaft_that_turns_back_is_read_at_its_farthest_angles():
    angle = np.linspace(0.0, 1.5 * math.pi, 129)
    back = angle.copy()
    back[-1] = angle[-3]  # the total stays that of the last but one
    order, _ = order_spectrum(back, np.sin(angle))
    assert order[1] == pytest.approx(2 * math.pi / angle[-2])


@pytest.mark.parametrize("revolutions", [1.0, 1.5, 1.97, 2.0 - 1e-9, 3.03, 7.47])
def test_the_amplitude_at_a_tooth_order_is_that_of_a_sine_over_any_angle(revolutions):
    angle = 2 * math.pi * revolutions * np.linspace(0.0, 1.0, 8001)
    order, amplitude = order_spectrum(angle, 0.7 * np.sin(17 * angle + 0.3) + 0.1 * angle)
    place = amplitude.argmax()
    assert order[place] == pytest.approx(17.0, abs=1e-12)
    assert amplitude[place] == pytest.approx(0.7, rel=2e-3)
    assert order[1] == pytest.approx(1.0 / math.floor(revolutions + 1e-6))


@pytest.mark.parametrize("revolutions", [3.1, 3.37, 3.77, 10.3])
def test_six_rows_of_a_cycle_are_enough_for_its_amplitude(revolutions):
    angle = np.linspace(0.0, 2 * math.pi * revolutions, round(6 * 17 * revolutions) + 1)
    _, amplitude = order_spectrum(angle, np.sin(17 * angle + 0.3))
    assert amplitude.max() == pytest.approx(1.0, rel=5e-3)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_shaft_that_first_turns_back_has_the_orders_of_the_way_on(sign):
    """It turns back by 3 rad and returns before it goes on: that is left out."""
    onward = np.linspace(0.0, 4 * math.pi, 129)
    back = np.concatenate([np.linspace(0.0, -3.0, 30), np.linspace(-3.0, 0.0, 30)[1:-1]])
    angle = np.concatenate([back, onward])
    order, amplitude = order_spectrum(sign * angle, 0.2 * np.sin(1.5 * angle))
    expected = order_spectrum(onward, 0.2 * np.sin(1.5 * onward))
    assert order[amplitude.argmax()] == pytest.approx(1.5, rel=0.01)
    near = np.interp(expected[0], order, amplitude)
    np.testing.assert_allclose(near, expected[1], atol=0.01 * 0.2)


def test_eight_rows_of_a_turning_shaft_are_enough_for_orders():
    angle = np.linspace(0.0, 0.5, 8)
    assert len(order_spectrum(angle, np.sin(angle))[0]) == 5
    with pytest.raises(rc.InvalidInput, match=r"7 rows over 0\.429 rad: too few"):
        order_spectrum(angle[:7], angle[:7])
    with pytest.raises(rc.InvalidInput, match="8 rows over 0 rad: too few"):
        order_spectrum(np.zeros(8), angle)


@pytest.mark.parametrize("place", [0, 1])
@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_orders_of_values_that_are_no_numbers_are_refused(place, wrong):
    given = [np.linspace(0.0, 9.0, 50), np.ones(50)]
    given[place][7] = wrong
    expected = f"{('angle', 'values')[place]}: 1 of 50 values are no finite numbers, such as"
    with pytest.raises(rc.InvalidInput, match=f"{expected} {wrong}; take rows without them"):
        order_spectrum(*given)


def test_a_shaft_that_ends_at_its_first_angle_has_no_orders():
    angle = np.sin(np.linspace(0.0, math.pi, 9))
    angle[-1] = 0.0
    with pytest.raises(rc.InvalidInput, match="back and forth by 2 rad, and on by 0 rad"):
        order_spectrum(angle, angle)


def powers(run, time, torque, speed, energies):
    arrays = {f"energy_{name}": values for name, values in energies.items()}
    count = len(time)
    return history(
        run,
        time,
        sprocket_torque=np.tile(torque, (count, 1)),
        sprocket_speed=np.tile(speed, (count, 1)),
        **arrays,
    )


def energies(time, **rates):
    """Return energies whose mean growth over all rows are the rates; between, they are bent."""
    span = time[-1] - time[0]
    part = (time - time[0]) / span
    names = ("dissipated", "external_work", "residual", "kinetic", "gravity", "elastic")
    return {name: 1.0 + span * rates.get(name, 0.0) * part**2 for name in names}


def test_small_powers_are_those_of_torques_and_of_the_growth_of_energies(run):
    """The motor puts in 0.9 W, the load takes 0.5 W, the torque set on the idler 0.1 W."""
    time = np.array([0.5, 0.6, 0.9])
    rates = {"external_work": 0.3, "dissipated": 0.2, "kinetic": 0.06, "residual": -0.04}
    made = powers(run, time, [7.0, -0.25, -0.02], [12.0, 2.0, 5.0], energies(time, **rates))
    found = made.power_balance()
    np.testing.assert_allclose(found["shaft_power"], [0.9, -0.5, -0.1], atol=1e-12)
    assert float(found["other_work"]) == 0.0
    assert float(found["loss"].sum()) == pytest.approx(0.2)
    np.testing.assert_allclose(found["stored"], [0.06, 0.0, 0.0], atol=1e-12)
    assert float(found["residual"]) == pytest.approx(-0.04)
    assert float(found["efficiency"]) == pytest.approx(0.6 / 0.8)
    assert found.attrs["span"] == pytest.approx(0.4)


def test_two_rows_have_a_power_and_one_has_none(run):
    time = np.array([0.5, 0.9])
    made = powers(run, time, [1.0, -1.0, 0.0], [1.0, 1.0, 1.0], energies(time, external_work=1.0))
    assert made.power_balance().attrs["span"] == pytest.approx(0.4)
    with pytest.raises(rc.InvalidInput, match="a power needs at least two rows"):
        made.power_balance(start=0.7)


def test_an_efficiency_counts_a_row_that_agrees_to_rounding(run):
    time = np.array([0.0, 0.3, 0.6])
    given = energies(time, external_work=0.6, dissipated=0.2)
    made = powers(run, time, [7.0, -0.5, 0.0], [12.0, 1.0, 0.0], given)
    assert 3 * 0.1 > 0.3
    assert made.efficiency(after=3 * 0.1) == made.efficiency(after=0.3)


@pytest.mark.parametrize("before", [0.0, 1e4])
def test_a_drive_without_dashpots_loses_nothing_in_them(run, before):
    """Losses add up but for rounding, also where much was lost before the part."""
    time = np.array([0.0, 0.5, 1.0])
    given = energies(time)
    lost = {"hinge_contact": 0.1 * time, "tooth_contact": 0.2 * time}
    lost = {name: 0.37 * before + values for name, values in lost.items()}
    given |= lost | {"dissipated": sum(lost.values()) * (1.0 + 1e-15)}
    made = powers(run, time, [1.0, -1.0, 0.0], [1.0, 1.0, 1.0], given)
    loss = made.power_balance()["loss"]
    assert float(loss.sel(channel="dashpots")) == 0.0
    given["dissipated"] = given["dissipated"] + 1e-3 * time
    loss = powers(run, time, [1.0, -1.0, 0.0], [1.0] * 3, given).power_balance()["loss"]
    assert float(loss.sel(channel="dashpots")) == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize(("torque", "work"), [(0.0, 2.0), (-1.0, -3.0)])
def test_without_a_power_delivered_or_put_in_there_is_no_efficiency(run, torque, work):
    """Either the load takes nothing, or no shaft drives and stored energy is spent."""
    time = np.array([0.0, 0.5, 1.0])
    rates = energies(time, external_work=work, dissipated=0.5)
    made = powers(run, time, [0.0, torque, 0.0], [1.0, 1.0, 1.0], rates)
    assert math.isnan(float(made.power_balance()["efficiency"]))


def test_a_part_keeps_the_states_at_the_ends_of_the_run_alone(run):
    """Bodies were not recorded: states at the ends of a part are known at the run's own ends."""
    early, late = run.between(None, 5e-4), run.between(1e-4)
    np.testing.assert_array_equal(early.initial_positions, run.initial_positions)
    np.testing.assert_array_equal(late.final_velocities, run.final_velocities)
    assert np.isnan(early.final_positions).all()
    assert np.isnan(late.initial_velocities).all()
