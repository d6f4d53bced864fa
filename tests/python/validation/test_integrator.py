"""The integrator by itself: known solutions, its counts, and its work beside SciPy's codes."""

import math

import numpy as np
import pytest

import rustchain as rc
from checks.check import hold
from checks.integrator import (
    DECADES,
    MEANINGFUL,
    SMOOTH,
    all_work,
    integrate,
    smooth,
    solution,
    work_ratios,
)


@pytest.mark.parametrize("name", SMOOTH)
def test_the_error_follows_the_tolerance_over_ten_decades(name):
    hold(smooth(name))


@pytest.mark.parametrize("name", SMOOTH)
def test_two_evaluations_a_step_and_one_a_rejected_one(name):
    slope, span, start = SMOOTH[name]
    for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
        result = integrate(slope, span, start, tolerance)
        # One at the start, and one that tests the first step.
        assert result["evaluations"] == 2 + 2 * result["steps"] + result["rejected"]


@pytest.mark.parametrize("max_order", range(1, 13))
def test_the_order_is_held_below_its_limit(max_order):
    """The lower the order, the more steps; each order keeps the tolerance."""
    slope, span, start = SMOOTH["oscillator"]
    tolerance = 1e-6
    result = integrate(slope, span, start, tolerance, max_order=max_order)
    error = np.max(np.abs(result["y"][-1] - solution("oscillator", span[1])))
    assert error <= 1e4 * tolerance if max_order == 1 else error <= 300.0 * tolerance
    if max_order >= 3:
        lower = integrate(slope, span, start, tolerance, max_order=max_order - 2)
        assert result["steps"] <= 1.3 * lower["steps"]


def test_dense_output_is_as_good_as_the_steps():
    slope, span, start = SMOOTH["oscillator"]
    times = np.linspace(*span, 501)
    result = integrate(slope, span, start, 1e-9, times=times)
    expected = np.array([solution("oscillator", t) for t in times])
    np.testing.assert_array_equal(result["t"], times)
    assert np.max(np.abs(result["y"] - expected)) <= 1e-7
    assert result["steps"] < 150


def test_output_times_do_not_change_the_steps():
    slope, span, start = SMOOTH["oscillator"]
    plain = integrate(slope, span, start, 1e-8)
    many = integrate(slope, span, start, 1e-8, times=np.linspace(*span, 1234))
    np.testing.assert_array_equal(plain["y"][-1], many["y"][-1])
    for count in ("evaluations", "steps", "rejected"):
        assert plain[count] == many[count]


def test_no_step_is_larger_than_the_largest():
    slope, span, start = SMOOTH["logistic"]
    seen = []

    def watched(t, y):
        seen.append(t)
        return slope(t, y)

    integrate(watched, span, start, 1e-3, max_step=0.01)
    assert max(np.diff(np.unique(seen))) <= 0.01 + 1e-12
    assert len(np.unique(seen)) >= 500


def test_an_exception_of_the_right_hand_side_comes_through():
    def broken(t, y):
        if t > 1.0:
            raise LookupError("no slope past 1 s")
        return -y

    with pytest.raises(LookupError, match="no slope past 1 s"):
        integrate(broken, (0.0, 2.0), [1.0], 1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"span": (1.0, 1.0)}, "t_span"),
        ({"span": (0.0, math.nan)}, "t_span"),
        ({"span": (0.0, math.inf), "times": np.array([1.0])}, r"t_span \(end\) = inf"),
        ({"span": (-math.inf, 0.0)}, r"t_span \(start\) = -inf"),
        ({"tolerance": -1.0}, "rtol"),
        ({"tolerance": math.nan}, "rtol"),
        ({"max_order": 13}, "max_order"),
        ({"max_step": 0.0}, "max_step"),
        ({"max_step": 1e-17}, r"max_step = .* at least 4\.4e-16 s, the rounding of t_span"),
        ({"times": np.array([0.0, 3.0])}, "t_eval"),
        ({"times": np.array([1.0, 0.5])}, "t_eval"),
        ({"slope": lambda t, y: np.zeros(2)}, "must return 1 values"),
    ],
)
def test_wrong_arguments_are_refused_by_name(change, message):
    good = {"slope": lambda t, y: -y, "span": (0.0, 2.0), "start": [1.0], "tolerance": 1e-6}
    with pytest.raises(ValueError, match=message):
        integrate(**(good | change))


@pytest.fixture(scope="module")
def work():
    return all_work()


def test_work_at_equal_error_beside_lsoda_and_dop853(work):
    hold(work_ratios(work))


def test_the_error_of_ten_orbits_falls_with_the_tolerance(work):
    errors = work["ours"][:, 0]
    assert errors[-1] < 1e-5
    meaningful = errors < MEANINGFUL
    slope = np.polyfit(-DECADES[meaningful], np.log10(errors[meaningful]), 1)[0]
    assert 0.8 < slope < 1.3


def test_newton_and_pece_agree_on_a_pretensioned_strand():
    """Mean tension of both strands from 20 to 80 ms, past the tensioner's ramp."""
    tension = {}
    for solver in (rc.Solver(method="pece", rtol=1e-5), rc.Solver(method="newton")):
        result = rc.Simulation(rc.paper_drive(25.0), solver=solver).run(
            0.08, record=("hinges", "energy"), progress=False
        )
        upper, lower = (result.strand(side).tension for side in ("upper", "lower"))
        tension[solver.method] = np.mean(upper[200:] + lower[200:])
        assert (result.stats["jacobians"] > 0) == (solver.method == "newton")
    assert abs(tension["newton"] / tension["pece"] - 1) < 0.05


def test_newton_says_what_it_cannot_do_with_its_accuracy():
    with pytest.raises(rc.InvalidInput, match=r"Solver.accuracy = 0"):
        rc.Simulation(rc.paper_drive(), solver=rc.Solver(method="newton", accuracy=0.0))


def test_auto_takes_both_methods_on_a_slack_chain():
    stats = rc.Simulation(rc.paper_drive()).run(0.02, progress=False).stats
    assert 0 < stats["jacobians"] < stats["steps"]
    # Two evaluations a step of either method, one or two more for a rejected one.
    assert stats["evaluations"] < 2.5 * stats["steps"]


@pytest.mark.parametrize("method", ["auto", "pece"])
def test_tolerances_that_are_given_take_the_place_of_accuracy(method):
    def steps(**tolerances):
        simulation = rc.Simulation(rc.paper_drive(), solver=rc.Solver(method, **tolerances))
        return simulation.run(5e-3, record=("energy",), progress=False).stats["steps"]

    assert steps(rtol=1e-6, atol=1e-6, accuracy=1e-4) == steps(rtol=1e-6, atol=1e-6)
    assert steps(rtol=1e-6) == steps(rtol=1e-6, atol=1e-5)
    assert steps(accuracy=1e-9) < steps(accuracy=1e-10) < steps(accuracy=1e-11)
