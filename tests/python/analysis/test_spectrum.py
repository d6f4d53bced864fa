"""The spectrum of any array, against `scipy.signal.welch` on the same rows."""

import numpy as np
import pytest
from scipy import signal

import rustchain as rc
from rustchain.analysis.spectrum import welch

STEP = 1e-3  # [s]


def rows(count, channels=3):
    """Return times that do not begin at zero, and noise about a line, (channels, times)."""
    noise = np.random.default_rng(1).normal(size=(channels, count))
    return 0.7 + STEP * np.arange(count), noise + 0.01 * np.arange(count)


@pytest.mark.parametrize(
    ("segment", "points"), [(None, 200), (0.05, 50), (0.016, 16), (1e308, 200)]
)
def test_segments_are_those_of_welch(segment, points):
    time, values = rows(200)
    frequency, density = welch(time, values, segment)
    expected = signal.welch(values, 1.0 / STEP, nperseg=points, detrend="linear")
    np.testing.assert_allclose(frequency, expected[0], rtol=1e-9)
    np.testing.assert_allclose(density, expected[1], rtol=1e-6, atol=1e-15)


@pytest.mark.parametrize(("segment", "points"), [(None, 64), (64.0, 32)])
def test_rows_may_be_seconds_apart(segment, points):
    _, values = rows(64)
    frequency, density = welch(2.0 * np.arange(64), values, segment)
    expected = signal.welch(values, 0.5, nperseg=points, detrend="linear")
    np.testing.assert_allclose(frequency, expected[0], rtol=1e-12)
    np.testing.assert_allclose(density, expected[1], rtol=1e-9)


def test_a_density_has_the_leading_axes_of_its_values():
    time, values = rows(64, 6)
    _, density = welch(time, values.reshape(2, 3, -1), None)
    assert density.shape == (2, 3, 33)
    np.testing.assert_array_equal(density.reshape(6, -1), welch(time, values, None)[1])


def test_a_last_row_between_two_steps_is_interpolated_to_the_nearest_one():
    time, values = rows(100, 1)
    for early, count in ((0.4, 100), (0.6, 99)):
        moved = time.copy()
        moved[-1] -= early * STEP
        even = time[0] + STEP * np.arange(count)
        expected = signal.welch(
            np.interp(even, moved, values[0]), 1.0 / STEP, nperseg=count, detrend="linear"
        )
        np.testing.assert_allclose(welch(moved, values, None)[1][0], expected[1], rtol=1e-6)


def test_sixteen_rows_are_enough_and_fifteen_are_not():
    time, values = rows(16)
    assert len(welch(time, values, None)[0]) == 9
    with pytest.raises(rc.InvalidInput, match="15 rows: too few for a spectrum"):
        welch(time[:15], values[:, :15], None)


@pytest.mark.parametrize("segment", [0.0, -0.1])
def test_a_segment_without_length_is_refused(segment):
    time, values = rows(64)
    with pytest.raises(rc.InvalidInput, match="must be a positive number in s"):
        welch(time, values, segment)


def test_a_segment_of_fewer_rows_than_a_spectrum_has_is_refused():
    time, values = rows(64)
    message = r"segment = 0.005: has 5 rows of 0.001 s; expected at least 0.016 s"
    with pytest.raises(rc.InvalidInput, match=message):
        welch(time, values, 0.005)


def test_the_array_keeps_its_axes_and_has_its_unit_squared():
    result = rc.Simulation(rc.paper_drive(25.0)).run(5e-3, progress=False)
    found = result.spectrum("hinge_force")
    assert found.dims == ("hinge", "frequency")
    expected = signal.welch(
        result.array("hinge_force").T, 1e4, nperseg=len(result.time), detrend="linear"
    )
    np.testing.assert_allclose(found.to_numpy(), expected[1], rtol=1e-6, atol=1e-12)
    assert found.attrs["units"] == "N^2/Hz"
    with pytest.raises(rc.NotRecorded, match="no_such_array"):
        result.spectrum("no_such_array")


def test_the_spectrum_of_positions_is_over_time_for_each_body_and_coordinate():
    result = rc.Simulation(rc.paper_drive(25.0)).run(5e-3, record=("bodies",), progress=False)
    found = result.spectrum("position")
    positions = result.array("positions")
    assert found.shape == (positions.shape[1], 2, len(found["frequency"]))
    expected = signal.welch(positions[:, 7, 1], 1e4, nperseg=len(result.time), detrend="linear")
    np.testing.assert_allclose(found.to_numpy()[7, 1], expected[1], rtol=1e-5, atol=1e-25)


@pytest.mark.parametrize("name", ["initial_position", "hinge"])
def test_what_has_no_rows_over_time_has_no_spectrum(name):
    result = rc.Simulation(rc.paper_drive(25.0)).run(5e-3, progress=False)
    assert name in result.to_xarray()
    with pytest.raises(rc.InvalidInput, match=f"name = '{name}': has no rows over time"):
        result.spectrum(name)


def test_what_varies_by_rounding_only_has_a_spectrum_of_zeros():
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, torque=[(0.0, -1.9), (1.0, -2.1)])
    result = rc.Simulation(drive).run(5e-3, record=("sprockets",), progress=False)
    motor, load = result.spectrum("sprocket_torque").to_numpy()
    assert motor.min() > 0.0
    assert load.max() == 0.0
    (axes,) = result.plot.spectrum("sprocket_torque", sprocket=2).axes
    assert "nothing varies" in axes.texts[0].get_text()
