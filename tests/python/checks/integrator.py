"""The integrator by itself: problems with known solutions, and its work beside SciPy's codes."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

from checks.check import Check, Range
from rustchain import _rustchain

TEST = "python/validation/test_integrator.py"


class Counted:
    """A right-hand side that counts its calls."""

    def __init__(self, slope):
        self.slope, self.calls = slope, 0

    def __call__(self, t, y):
        self.calls += 1
        return self.slope(t, y)


def integrate(slope, span, start, tolerance, max_step=math.inf, max_order=12, times=None):
    """The result, with calls counted on this side."""
    counted = Counted(slope)
    result = _rustchain.integrate(
        counted, span, np.array(start, float), tolerance, tolerance, max_step, max_order, times
    )
    assert counted.calls == result["evaluations"]
    return result


def forced_oscillator(t, y):
    return np.array([y[1], -y[0] + 3.0 * math.sin(2.0 * t)])


def logistic(t, y):
    return y * (1.0 - y)


def bernoulli(t, y):
    return -y * y


# Slope, span, start, solution at the end.
SMOOTH = {
    "oscillator": (forced_oscillator, (0.0, 10.0), [1.0, 0.0]),
    "logistic": (logistic, (0.0, 5.0), [0.1]),
    "bernoulli": (bernoulli, (0.0, 20.0), [1.0]),
}


def solution(name, t):
    if name == "oscillator":  # x = cos t + 2 sin t - sin 2t
        return np.array(
            [
                math.cos(t) + 2.0 * math.sin(t) - math.sin(2.0 * t),
                -math.sin(t) + 2.0 * math.cos(t) - 2.0 * math.cos(2.0 * t),
            ]
        )
    if name == "logistic":
        return np.array([1.0 / (1.0 + 9.0 * math.exp(-t))])
    return np.array([1.0 / (1.0 + t)])


def smooth(name):
    """Return the checks of one problem, a tolerance from 1e-3 to 1e-13 each."""
    test = f"{TEST}::test_the_error_follows_the_tolerance_over_ten_decades"
    slope, span, start = SMOOTH[name]
    expected = solution(name, span[1])
    checks = []
    for decade in range(3, 14):
        tolerance = 10.0**-decade
        result = integrate(slope, span, start, tolerance)
        assert result["steps"] < 600
        checks.append(
            Check(
                f"{name}, tolerance {tolerance:g}: solution at the end; largest error",
                *(
                    result["y"][-1][0],
                    expected[0],
                    100.0 * tolerance + 20 * np.finfo(float).eps,
                    test,
                ),
                error=float(np.max(np.abs(result["y"][-1] - expected))),
            )
        )
    return checks


# --- two bodies, e = 0.9, ten orbits

ECCENTRICITY = 0.9
ORBITS = (0.0, 20.0 * math.pi)
PERICENTRE = [
    1.0 - ECCENTRICITY,
    0.0,
    0.0,
    math.sqrt((1.0 + ECCENTRICITY) / (1.0 - ECCENTRICITY)),
]
DECADES = np.arange(4.0, 12.01, 0.5)
# Errors above are of the size of the orbit: phase is lost, and work says nothing.
MEANINGFUL = 0.3


def gravity(t, y):
    x, z, vx, vz = y
    cubed = (x * x + z * z) ** 1.5
    return np.array([vx, vz, -x / cubed, -z / cubed])


def error_of(end):
    return float(np.linalg.norm(end - PERICENTRE))


def ours(tolerance):
    result = integrate(gravity, ORBITS, PERICENTRE, tolerance)
    return error_of(result["y"][-1]), result["evaluations"]


def scipys(method):
    def run(tolerance):
        result = solve_ivp(gravity, ORBITS, PERICENTRE, method, rtol=tolerance, atol=tolerance)
        assert result.success
        return error_of(result.y[:, -1]), result.nfev

    return run


def work_at(error, code):
    """Evaluations that a code needs for an error, from a parabola through all its runs.

    Errors of single runs scatter by a factor of three; log(evaluations) against log(error), fitted
    over all the runs that mean something, does not.
    """
    errors, evaluations = code[code[:, 0] < MEANINGFUL].T
    fit = np.polyfit(np.log(errors), np.log(evaluations), 2)
    return np.exp(np.polyval(fit, np.log(error)))


def all_work():
    """Error and evaluations of each code for each tolerance."""
    codes = {"ours": ours, "LSODA": scipys("LSODA"), "DOP853": scipys("DOP853")}
    return {
        name: np.array([run(tolerance) for tolerance in 10.0**-DECADES])
        for name, run in codes.items()
    }


def work_ratios(work):
    """Return the checks of the evaluations over those of LSODA and DOP853 at equal error."""
    test = f"{TEST}::test_work_at_equal_error_beside_lsoda_and_dop853"
    errors = 10.0 ** -np.arange(1.0, 6.0)
    table = {name: work_at(errors, code) for name, code in work.items()}
    # Measured: 0.87, 0.78, 0.72, 0.69, 0.69 of LSODA's, 0.75 to 0.57 of DOP853's.
    limits = [("LSODA", 1.0 if error > 2e-5 else 0.8) for error in errors]
    limits += [("DOP853", 0.9) for _ in errors]
    ratios = [*(table["ours"] / table["LSODA"]), *(table["ours"] / table["DOP853"])]
    return [
        Range(f"evaluations over those of {code} at an error of {error:.0e}", ratio, 0, limit, test)
        for (code, limit), error, ratio in zip(limits, [*errors, *errors], ratios, strict=True)
    ]
