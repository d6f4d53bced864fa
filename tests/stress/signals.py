"""Random signals: a number, tables, splines, sines and steps, and loads that follow a speed."""

from __future__ import annotations

import math

import rustchain as rc
from draw import Draw
from rustchain.description.signals import Signal


def about(draw: Draw, value: float) -> Signal:
    """Return a function of time whose values are of the size of `value`."""
    kind = draw.one_of(("number",) * 6 + ("ramp", "rows", "table", "spline", "sines", "step"))
    later = draw.log_between(2e-3, 0.1)
    if kind != "number":
        draw.features.append(kind)
    if kind == "ramp":
        return ((0.0, draw.one_of((0.0, 0.5 * value))), (later, value))
    if kind in ("rows", "table", "spline"):
        rows = [(0.0, value)]
        for _ in range(draw.integer(1, 4)):
            rows.append((rows[-1][0] + later, value * draw.between(0.2, 1.0)))
        return {"rows": tuple(rows), "table": rc.Table(rows), "spline": rc.Spline(rows)}[kind]
    if kind == "sines":
        terms = [
            (draw.between(0.0, 0.3) * value, draw.log_between(1.0, 2e3), draw.between(-3.0, 3.0))
            for _ in range(draw.integer(1, 3))
        ]
        return rc.Sines(terms, offset=0.5 * value)
    if kind == "step":
        start = draw.between(0.0, 0.02)
        return rc.SmoothStep(start, start + later, draw.one_of((0.0, value, -value)), value)
    return value


def speed(draw: Draw, radius: float) -> Signal:
    """Return a speed [rad/s]: up to 15 m/s of a chain at `radius` [m], rarely up to the limit."""
    fastest = 990.0 if draw.chance(0.04, "speed to its limit") else 15.0
    return about(draw, draw.sign() * draw.log_between(0.1, fastest) / radius)


def load(draw: Draw, tension: float, radius: float) -> rc.Free | rc.AppliedTorque:
    """Return what a driven sprocket bears: nothing, a torque, or a load that grows with speed."""
    if draw.chance(0.4):
        return rc.Free()
    greatest = 500.0 if draw.chance(0.04, "torque to its limit") else 1.0
    torque = draw.sign() * draw.log_between(0.01, greatest) * tension * radius
    if draw.chance(0.2, "load curve"):
        fast = draw.log_between(1.0, 30.0) / radius
        curve = ((-fast, abs(torque)), (0.0, 0.0), (fast, -abs(torque)))
        return rc.AppliedTorque(0.0, draw.one_of((curve, rc.Table(curve))))
    if draw.chance(0.2, "sudden load"):
        return rc.AppliedTorque(((5e-3, 0.0), (5.1e-3, torque)))
    draw.features.append("torque")
    return rc.AppliedTorque(about(draw, torque))


def anchor_velocity(draw: Draw) -> tuple[object, ...]:
    """Return an anchor's velocity: none, rows, or signals that begin at rest."""
    if draw.chance(0.6):
        return (0.0, 0.0)
    draw.features.append("moved anchor")
    v, w = draw.between(-1.0, 1.0), draw.between(-1.0, 1.0)
    if draw.chance(0.5):
        return ((0.0, 0.0, 0.0), (0.01, v, w), (0.02, 0.0, 0.0))
    wave = rc.Sines([(v, draw.log_between(3.0, 500.0), 0.0)])
    return (wave, draw.one_of((0.0, rc.SmoothStep(0.0, 0.01, 0.0, w))))


def angle(draw: Draw, start: float) -> Signal:
    """Return an angle over time [rad] that begins at `start`."""
    size, frequency = draw.between(0.1, 1.0), draw.log_between(5.0, 300.0)
    kind = draw.one_of(("sines", "spline", "step"))
    draw.features.append(kind)
    if kind == "sines":
        phase = draw.between(-math.pi, math.pi)
        return rc.Sines([(size, frequency, phase)], offset=start - size * math.sin(phase))
    if kind == "spline":
        later = draw.log_between(0.01, 0.1)
        return rc.Spline([(0.0, start), (later, start + size), (2.0 * later, start - size)])
    return rc.SmoothStep(1e-3, 1e-3 + draw.log_between(1e-2, 0.1), start, start + size)
