"""Figures of the validation pages: answers of this code beside independent ones."""

from __future__ import annotations

import math

import numpy as np

import rustchain as rc
from checks import contacts, integrator, mechanisms, numerical, sprockets, strands
from rustchain.plot.style import styled, subplots

EXACT = {"color": "0.55", "linewidth": 3.0, "zorder": 0}


@styled
def catenary():
    """Draw a chain at rest, its exact polygon, and their distance."""
    figure, (left, right) = subplots(1, 2, figsize=(9.0, 3.2))
    for share in (0.6, 0.95):
        found, exact, _, _ = strands.hanging(40, share)
        left.plot(*exact.T, label="rigid links, exact" if share == 0.6 else "_", **EXACT)
        left.plot(*found.T, ".", markersize=3, label=f"rustchain, span {share:g} of the length")
        right.semilogy(np.hypot(*(found - exact).T), ".-", label=f"span {share:g}")
    right.axhline(2e-7 * 40 * strands.PITCH, color="0.3", linestyle="--", label="bound")
    left.set(title="chain of 40 links at rest", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    right.set(title="distance from the exact place", xlabel="link", ylabel="[m]")
    left.legend(loc="upper right", bbox_to_anchor=(1.0, -0.35))
    right.set_ylim(top=3e-6)  # room for the legend
    right.legend(loc="upper right", ncols=3)
    return figure


@styled
def swing(motion):
    """Draw the lowest mode of a hanging chain beside a cosine of the eigenvalue's frequency."""
    time, moved, omega = motion
    figure, axes = subplots(1, 1, figsize=(6.0, 2.8))
    axes.plot(time, np.cos(omega * time), label="linear eigenvalue problem", **EXACT)
    axes.plot(time, moved, label="rustchain")
    axes.set(xlabel="time [s]", ylabel="amplitude of the mode")
    axes.legend()
    return figure


@styled
def strand_spectrum(found):
    """Draw the spectrum of a plucked strand and the frequencies of the formula."""
    figure, axes = subplots(1, 1, figsize=(6.0, 2.8))
    density = found["density"].sum("station").to_numpy()
    axes.semilogy(found["frequency"], density, label="rustchain")
    for k, natural in enumerate(found["natural_frequency"].to_numpy()):
        label = "n (c² - v²)/(2 L c)" if k == 0 else "_"
        axes.axvline(natural, label=label, **EXACT)
    axes.set(xlim=(0, 120), xlabel="frequency [Hz]", ylabel="density [m²/Hz]")
    axes.legend()
    return figure


@styled
def wrap_series():
    """Draw tooth loads along the wrap and their geometric series."""
    figure, axes = subplots(1, 1, figsize=(6.0, 3.0))
    for flank in (20, 25, 30):
        _, (tooth, ratio) = sprockets.wrap_series(17, flank)
        count = np.arange(len(tooth))
        pressed = tooth > 0.0
        axes.semilogy(tooth[0] * ratio**count, label="series" if flank == 20 else "_", **EXACT)
        axes.semilogy(
            count[pressed], tooth[pressed], "o", markersize=4, label=f"flanks at {flank}°"
        )
    axes.set(xlim=(-0.3, 6), ylim=(1e-2, 40), xlabel="tooth", ylabel="force [N]")
    axes.legend()
    return figure


@styled
def polygon_action(found):
    """Draw the transmission error of two polygons, by this code and by geometry."""
    figure, panels = subplots(1, len(found), figsize=(9.0, 3.0))
    for axes, (name, (driver, error, coarse, expected)) in zip(panels, found.items(), strict=True):
        axes.plot(np.degrees(coarse), 1e3 * expected, label="tangent of two polygons", **EXACT)
        axes.plot(np.degrees(driver), 1e3 * error, label="rustchain")
        axes.set(title=name, xlabel="angle of the driver [°]", ylabel="error [mrad]")
    panels[0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.1), ncols=2)
    return figure


@styled
def restitution():
    """Draw the ratio of velocities of an impact over the restitution of the material."""
    figure, axes = subplots(1, 1, figsize=(6.0, 3.6))
    given = np.linspace(0.1, 0.99, 40)
    for damping in contacts.FACTORS:
        (line,) = axes.plot(given, [contacts.rebound(damping, c) for c in given], label=damping)
        for c in (0.3, 0.5, 0.71, 0.9):
            rate = contacts.impact(rc.Hertz(damping=damping), restitution=c, rows=4)[2]
            axes.plot(c, -rate[-1] / rate[0], "o", color=line.get_color(), markersize=4)
    axes.set(xlabel="restitution of the material", ylabel="velocity after over before")
    axes.legend(title="line: formula, points: rustchain")
    return figure


@styled
def work(found):
    """Draw errors over tolerances, and evaluations over errors of three codes."""
    figure, (left, right) = subplots(1, 2, figsize=(9.0, 3.4))
    decades = np.arange(3, 14)
    for name, (slope, span, start) in integrator.SMOOTH.items():
        expected = integrator.solution(name, span[1])
        ends = [integrator.integrate(slope, span, start, 10.0**-k)["y"][-1] for k in decades]
        errors = [max(np.max(np.abs(end - expected)), 1e-17) for end in ends]
        left.loglog(10.0**-decades, errors, "o-", markersize=3, label=name)
    left.loglog(10.0**-decades, 100.0 * 10.0**-decades, "k--", label="bound")
    left.set(title="smooth problems", xlabel="tolerance", ylabel="error at the end")
    left.legend()
    for name, code in found.items():
        meant = code[code[:, 0] < integrator.MEANINGFUL]
        label = "rustchain" if name == "ours" else name
        right.loglog(meant[:, 0], meant[:, 1], "o-", markersize=3, label=label)
    right.set(title="two bodies, e = 0.9, ten orbits", xlabel="error", ylabel="evaluations")
    right.legend()
    return figure


@styled
def slider_accelerations():
    """Draw the acceleration of a slider with clearance in the wrist pin beside the ideal one."""
    figure, panels = subplots(1, 3, figsize=(10.0, 3.2), sharey=True)
    for axes, clearance in zip(panels, (5e-4, 5e-5, 5e-6), strict=True):
        time, acceleration, _ = mechanisms.with_clearance(clearance)
        late = time > mechanisms.TURN
        angle = 360.0 * (time[late] / mechanisms.TURN - 1.0)
        ideal = mechanisms.slider_motion(mechanisms.SPEED, time[late])[2]
        axes.plot(angle, 1e-3 * ideal, label="ideal joint, closed form", **EXACT)
        axes.plot(angle, 1e-3 * acceleration[late], label="rustchain")
        axes.set(title=f"radial clearance {1e6 * clearance:g} µm", xlabel="crank angle [°]")
    panels[0].set(ylabel="acceleration [km/s²]", ylim=(-100, 100))
    panels[0].legend()
    return figure


@styled
def squeezing():
    """Draw the angles of Andrews' mechanism and those of the test set at 0.03 s."""
    mechanism, end = mechanisms.andrews()
    simulation = rc.Simulation(mechanism, solver=mechanisms.solver(1e-10))
    result = simulation.run(0.03, 5e-5, progress=False)
    k = np.stack([result.body(f"K{n}").position[:, 2] for n in range(1, 8)])
    own = (k[0], k[1] - k[0], k[2], k[3] - k[4], k[4], k[5] - k[6], k[6])
    figure, axes = subplots(1, 1, figsize=(6.0, 3.2))
    for name, values, last in zip("βΘγΦδΩε", own, end, strict=True):
        turned = (values + math.pi) % (2.0 * math.pi) - math.pi
        turned[1:][np.abs(np.diff(turned)) > math.pi] = np.nan  # no line across the jump
        (line,) = axes.plot(1e3 * result.time, turned, label=name)
        axes.plot(30.0, (last + math.pi) % (2.0 * math.pi) - math.pi, "o", color=line.get_color())
    axes.set(xlabel="time [ms]", ylabel="angle, within half a turn [rad]")
    axes.legend(
        title="line: rustchain\npoint: test set", loc="center left", bbox_to_anchor=(1.0, 0.5)
    )
    return figure


@styled
def exudyn(stored):
    """Draw the difference from Exudyn over the size of its steps."""
    figure, axes = subplots(1, 1, figsize=(5.0, 3.0))
    size = 2e3 / np.array(stored["steps"])  # [µs]
    axes.loglog(size, stored["errors"], "o-", label="largest difference of a link")
    axes.loglog(size, stored["errors"][0] * (size / size[0]) ** 2, label="order two", **EXACT)
    axes.set(xlabel="step size of Exudyn [µs]", ylabel="[m]")
    axes.legend()
    return figure


@styled
def growth(found):
    """Draw the error of a chaotic path over time, a line for each tolerance."""
    figure, axes = subplots(1, 1, figsize=(6.0, 3.2))
    for tolerance, errors in found.items():
        axes.semilogy(
            1e3 * numerical.TIMES, np.maximum(errors, 1e-17), "o-", label=f"{tolerance:g}"
        )
    axes.set(xlabel="time [ms]", ylabel="largest error of a link [m]")
    axes.legend(title="rtol = atol")
    return figure


@styled
def paths(results):
    """Draw the path of pin 6 in its bushing, a panel for each result."""
    figure, panels = subplots(1, len(results), figsize=(10.0, 3.4))
    for axes, (name, result) in zip(panels, results.items(), strict=True):
        axes.plot(*(1e6 * result.hinge(6).eccentricity.T), linewidth=0.4)
        turn = np.linspace(0.0, 2.0 * np.pi, 200)
        axes.plot(25 * np.cos(turn), 25 * np.sin(turn), **EXACT)
        axes.set(title=name, xlabel="x [µm]", aspect="equal")
    panels[0].set(ylabel="y [µm]")
    return figure
