"""Chart, tables, verdicts and pages of a full run."""

from __future__ import annotations

import numpy as np

import rustchain as rc
from pages import put, table

from .analysis import order_of_convergence, ratios_of_rounds, spread, time_at_error

CHART = "images/work-precision.png"
COLOURS = {
    "rustchain Newton": "#d62728",
    "rustchain PECE": "#1f4fb4",
    "rustchain PECE, rtol": "#7b9fe0",
    "rustchain auto": "#111111",
    "CVODE Adams": "#2ca02c",
    "CVODE BDF": "#117733",
    "CVODE Adams, functional": "#77bb55",
    "Dormand-Prince 5(4)": "#b8860b",
    "DOP853": "#8b5a2b",
    "RK4": "#888888",
}
SHORT = {
    "rustchain Newton": "Newton",
    "rustchain PECE": "PECE",
    "rustchain PECE, rtol": "PECE, rtol",
    "rustchain auto": "auto",
    "CVODE Adams, functional": "CVODE Adams, funct.",
    "Dormand-Prince 5(4)": "Dorm.-Prince",
}
PANELS = [
    "0 N, 6 ms",
    "25 N, 20 ms",
    "100 N, 20 ms",
    "0 N, 0.2 s",
    "25 N, 0.2 s",
    "100 N, 0.2 s",
    "planet, 10 periods",
    "pin, undamped",
    "pin, damped",
]
# Scenes and errors of the table that the page opens with.
SUMMARY = [
    ("0 N, 5 ms", 1e-5),
    ("0 N, 6 ms", 1e-7),
    ("25 N, 20 ms", 1e-6),
    ("25 N, 20 ms", 1e-8),
    ("100 N, 20 ms", 1e-6),
    ("0 N, 0.2 s", 1e-2),
    ("25 N, 0.2 s", 1e-2),
    ("100 N, 0.2 s", 1e-2),
    ("planet, 10 periods", 1e-6),
    ("planet, 10 periods", 1e-9),
    ("pin, undamped", 1e-6),
    ("pin, damped", 1e-6),
]
# Time of auto over that of the better corrector, at equal error.
AUTO_LIMIT = 1.15
# The accuracy that users get who ask for none [m].
DEFAULT = rc.Solver().accuracy
# Goals for the time at residuals of 1e-2 and 1e-3 with AVX-512, set before the work [s/s]; twice
# that with AVX2.
TARGETS = {"0 N, 0.2 s": (0.15, 0.5), "25 N, 0.2 s": (0.15, 0.2), "100 N, 0.2 s": (0.2, 0.3)}


def machines(record):
    """Return machine and revision of all scenes, or each with its scenes."""
    scenes = {}
    for scene, name in record["machines"].items():
        scenes.setdefault(name, []).append(scene)
    if len(scenes) == 1:
        return next(iter(scenes))
    return "; ".join(f"{name}: {', '.join(of)}" for name, of in scenes.items())


def error_of(line):
    """Error that a scene is judged by."""
    return line["residual"] if ", 0.2 s" in line["scene"] else line["position_error"]


def curves(record, scene, cost="wall"):
    """Return {method: (errors, times)} of what finished; `cost` counts in the place of time."""
    found = {}
    for line in record["lines"]:
        error = error_of(line)
        if line["scene"] == scene and np.isfinite(error):
            found.setdefault(line["method"], []).append((max(error, 1e-17), line[cost]))
    return {method: np.array(points).T for method, points in found.items()}


def times_at(record, scene, wanted, cost="wall"):
    """Return {method: time at an error of `wanted`}; NaN of those that do not reach it."""
    found = curves(record, scene, cost)
    return {method: time_at_error(*points, wanted) for method, points in found.items()}


def reaching(times, ours):
    """Return those of {method: time} that reach the error, of this project or all others."""
    return {
        method: time
        for method, time in times.items()
        if method.startswith("rustchain") == ours and np.isfinite(time)
    }


def summary(record):
    """Return the table of few lines, and how the machine was."""
    titles = ["scene", "error", "rustchain", "time", "best other solver", "time", "ratio"]
    titles += ["median (range)"]
    rows, shares = [], []
    for scene, wanted in SUMMARY:
        times = times_at(record, scene, wanted)
        own, others = reaching(times, ours=True), reaching(times, ours=False)
        best = min(own, key=own.get)
        shares.append(times["rustchain auto"] / own[best])
        cells = [_called(scene), _said_error(scene, wanted)]
        cells += [SHORT[best], _said_time(scene, own[best])]
        if others:
            other = min(others, key=others.get)
            ratio = _digits(others[other] / own[best], 2)
            cells += [other, _said_time(scene, others[other]), ratio]
            cells += [_rounds(record, scene, wanted, best, other)]
        else:
            least = min(
                errors.min()
                for method, (errors, _) in curves(record, scene).items()
                if not method.startswith("rustchain")
            )
            cells += [f"none; least error {least:.0e}", "", "does not reach it", ""]
        rows.append(cells)
    said = [f"Machine: {machines(record)}{_load(record)}."]
    if np.isfinite(shares).all():
        said.append(
            f"`auto`, the default, takes at most {max(shares):.2f} times the time of the fastest "
            "method of rustchain in these lines."
        )
    share = spread([line["difference"] for line in record["lines"]])
    said.append(f"Two halves of equal runs differ by {share:.1%} in time (median of all points).")
    return [*table(titles, rows), "", *said]


def _called(scene):
    return scene if is_known(scene) else f"drive, {scene}"


def _said_error(scene, wanted):
    unit = "" if is_known(scene) else " of energy" if ", 0.2 s" in scene else " m"
    return f"{wanted:.0e}{unit}".replace("e-0", "e-")


def _said_time(scene, time):
    return f"{_digits(1e3 * time, 3)} ms" if is_known(scene) else f"{_digits(time, 3)} s/s"


def _rounds(record, scene, wanted, own, other):
    """Median and range of the ratio over the rounds of timed runs."""
    points = {
        method: [
            (max(error_of(line), 1e-17), line["times"])
            for line in record["lines"]
            if (line["scene"], line["method"]) == (scene, method) and np.isfinite(error_of(line))
        ]
        for method in (own, other)
    }
    found = ratios_of_rounds(points[own], points[other], wanted)
    median, least, most = (_digits(of(found), 2) for of in (np.median, np.min, np.max))
    return f"{median} ({least} to {most})"


def _digits(value, count):
    return f"{value:#.{count}g}".rstrip(".")


def verdicts(record):
    """Return what the figures say, in words."""
    said = [f"machine: {machines(record)}{_load(record)}"]
    scenes = list(dict.fromkeys(line["scene"] for line in record["lines"]))
    for scene in scenes:
        for wanted in (1e-2, 1e-3, 1e-4) if ", 0.2 s" in scene else _errors(scene):
            times = times_at(record, scene, wanted)
            said += _verdict(scene, wanted, times, _narrower(record, scene))
            if is_known(scene):
                said[-1] += _evaluations(times_at(record, scene, wanted, "evaluations"))
    said += _instructions(record) + _links(record) + _orders(record)
    return said


def is_known(scene):
    """Return whether the answer is known and an evaluation is cheap."""
    return scene.startswith(("planet", "pin"))


def _evaluations(counts):
    """Compare by evaluations, of which the time of a system that is not tiny consists."""
    best = {"own": (np.inf, ""), "other": (np.inf, "")}
    for method, count in counts.items():
        # Newton's method makes a matrix besides.
        if np.isfinite(count) and method not in ("rustchain Newton", "CVODE BDF"):
            whose = "own" if method.startswith("rustchain") else "other"
            best[whose] = min(best[whose], (count, method))
    (own, _), (other, name) = best["own"], best["other"]
    if not np.isfinite(own + other):
        return ""
    return f"; by evaluations {own:.0f}, {name} {other / own:.1f} times that"


def _load(record):
    """Load of the machine; the run itself is one."""
    loads = [load for pair in record["load"].values() for load in pair]
    return f"; load average {min(loads):.1f} to {max(loads):.1f}, of which the run itself is 1"


def _errors(scene):
    if scene == "0 N, 6 ms":
        # Above, which contacts were grazed decides, not what a method costs.
        return (1e-7, 1e-8)
    return (1e-6, 1e-8) if " N, " in scene else (1e-6, 1e-9)


def _narrower(record, scene):
    """Return the time of a Newton step with vectors of 256 bits over that with 512 bits, if known.

    The path is the same to the last bit, and so are the steps.
    """
    pretension = float(scene.split(" N")[0]) if " N, " in scene else -1.0
    walls = {
        line["set"]: line["wall_step"]
        for line in record["rust"]
        if line["kind"] == "instructions"
        and (line["method"], line["pretension"]) == ("newton", pretension)
    }
    both = "avx2" in walls and "avx512" in walls
    return walls["avx2"] / walls["avx512"] if both else np.nan


def _verdict(scene, wanted, times, narrower):
    """Best of this project beside CVODE, and beside the best other, at one error."""
    own, others = reaching(times, ours=True), reaching(times, ours=False)
    head = f"{scene}, error {wanted:.0e}:"
    if not own:
        return [f"{head} not reached"]
    best = min(own, key=own.get)
    text = f"{head} {SHORT[best]} {own[best]:.3g}"
    text += " s" if is_known(scene) else " s/s"
    cvode = [t for m, t in others.items() if m.startswith("CVODE")]
    text += f"; CVODE {min(cvode) / own[best]:.1f} times that" if cvode else "; no CVODE there"
    if others:
        other = min(others, key=others.get)
        text += f"; best other solver, {other}, {others[other] / own[best]:.1f} times"
    parts = [own[m] for m in ("rustchain Newton", "rustchain PECE") if m in own]
    if parts and "rustchain auto" not in own:
        text += "; auto does not reach it"
    elif parts:
        share = own["rustchain auto"] / min(parts)
        text += f"; auto {share:.2f} of the better of PECE and Newton"
        text += f", more than {AUTO_LIMIT}" if share > AUTO_LIMIT else ""
    if scene in TARGETS and wanted in (1e-2, 1e-3):
        target = TARGETS[scene][0 if wanted == 1e-2 else 1]
        text += f"; goal {target} s/s"
        if np.isfinite(narrower):
            text += f"; with 256-bit vectors {narrower * own[best]:.3g}, goal {2 * target:.2g}"
    return [text]


def _instructions(record):
    """Time of a step with narrower SIMD vectors over that with the widest."""
    rows = [line for line in record["rust"] if line["kind"] == "instructions"]
    widest = {(r["method"], r["pretension"]): r["wall_step"] for r in reversed(rows)}
    for row in rows:
        if row["set"] == "avx512":
            widest[row["method"], row["pretension"]] = row["wall_step"]
    said = []
    for (method, pretension), least in sorted(widest.items()):
        shares = [
            f"{r['set']} {1e6 * r['wall_step']:.2f} us ({r['wall_step'] / least:.2f})"
            for r in rows
            if (r["method"], r["pretension"]) == (method, pretension)
        ]
        said.append(f"a step, {method}, {pretension:.0f} N: {', '.join(shares)}")
    return said


def _links(record):
    """Growth of cost with links: the exponent should be one."""
    said = []
    rows = [line for line in record["rust"] if line["kind"] == "links"]
    for method in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == method]
        links, walls = np.array([(row["links"], row["wall"]) for row in own]).T
        power = -order_of_convergence(links, walls)
        each = ", ".join(
            f"{row['links']}: {1e6 * row['wall_step'] / row['links']:.4f} ({row['steps']})"
            for row in own
        )
        said.append(
            f"links, {method}: cost of a simulated second grows as links^{power:.2f}; "
            f"us per step and link (steps) {each}"
        )
    return said


def _orders(record):
    """Return the order at which the error falls with the tolerance, and the decades of both.

    Of a formula of order k it falls as tolerance^(k/(k+1)): 0.67 for Newton's method at order 2,
    up to 0.92 for PECE, less where contacts hold its order down.
    """
    said = []
    for scene in ("0 N, 5 ms", "0 N, 6 ms", "25 N, 20 ms", "100 N, 20 ms"):
        for method in ("rustchain Newton", "rustchain PECE", "rustchain PECE, rtol"):
            points = [
                (line["tolerance"], line["position_error"])
                for line in record["lines"]
                if line["scene"] == scene
                and line["method"] == method
                and np.isfinite(line["position_error"])
            ]
            if len(points) > 2:
                tolerances, errors = np.array(points).T
                slope = -order_of_convergence(tolerances, errors)
                span, wide = (np.log10(of.max() / of.min()) for of in (errors, tolerances))
                said.append(
                    f"{scene}, {SHORT[method]}: error falls as tolerance^{slope:.2f}, "
                    f"over {span:.1f} decades, {wide:.1f} of the tolerance"
                )
    return said


def pages(record, docs):
    """Return {page: text} with the blocks of this record between the marks of both pages."""
    blocks = {
        "work-precision.md": {"summary": summary(record), "long": _long_table(record)},
        "work-precision-tables.md": {
            "verdicts": [f"- {line}" for line in verdicts(record)],
            "tables": _tables(record),
        },
    }
    made = {}
    for name, of_page in blocks.items():
        page = docs / "performance" / name
        text = page.read_text(encoding="utf-8")
        for mark, lines in of_page.items():
            text = put(text, mark, lines)
        made[page] = text
    return made


def write(record, docs):
    """Draw the chart and write the pages."""
    draw(record, docs / CHART)
    for page, text in pages(record, docs).items():
        page.write_text(text, encoding="utf-8")
        print(f"wrote {page}")


def _tables(record):
    """Return the lines of a table a scene."""
    made = []
    for scene in dict.fromkeys(line["scene"] for line in record["lines"]):
        unit = "time of a run, ms" if is_known(scene) else "s/s"
        note = _reference(record["references"].get(scene))
        columns = ["method", "tolerance", unit, "steps", "evaluations", "Jacobians", "onsets"]
        columns += ["error", "residual", "runs", ""]
        rows = []
        for line in record["lines"]:
            if line["scene"] != scene:
                continue
            wall = line["wall"] * (1e3 if unit.endswith("ms") else 1.0)
            counts = (line[name] for name in ("steps", "evaluations", "jacobians", "onsets"))
            rows.append(
                [
                    line["method"],
                    f"{line['tolerance']:.1e}",
                    f"{wall:.3g}",
                    *(f"{count:.0f}" for count in counts),
                    _number(line["position_error"]),
                    _number(line["residual"]),
                    f"{line['runs']}",
                    line["note"],
                ]
            )
        made += ["", f"### {scene}{note}", "", *table(columns, rows)]
    return made[1:]


def _reference(found):
    """Say what a scene's errors and residuals are measured by."""
    if found is None:
        return ""
    if len(found) == 2:
        return (
            f"\n\nResiduals are over {found[0]:.4g} J, the energy that fine runs dissipate: a mean "
            f"from which none is farther than {found[1]:.1e} J."
        )
    return (
        f"\n\nReference: PECE at rtol = atol = 1e-12 and 1e-13 differ by {found[0]:.1e} m, RK4 "
        f"with short steps is {found[1]:.1e} m away. Residuals are over the {found[2]:.4g} J "
        "that it dissipates."
    )


def _number(value):
    return f"{value:.1e}" if np.isfinite(value) else ""


def _long_table(record):
    """Long runs: energy and statistics."""
    if not record["long"]:
        return []
    names = list(record["long"][0]["forces"])
    rows = [
        [
            f"{row['pretension']:.0f} N",
            row["method"],
            f"{row['tolerance']:.0e}",
            f"{row['wall']:.3g}",
            f"{row['steps']:.0f}",
            f"{row['residual']:.1e}",
            *(f"{mean:.3g} ± {half:.1g}" for mean, half in row["forces"].values()),
        ]
        for row in record["long"]
    ]
    first = ("pretension", "method", "tolerance", "s/s", "steps", "residual")
    return table([*first, *names], rows)


def draw(record, path):
    """One panel a scene, each curve with its name."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(3, 3, figsize=(11.5, 13.5), layout="constrained")
    for axis, scene in zip(axes.flat, PANELS, strict=True):
        _panel(axis, scene, curves(record, scene))
        _mark_default(axis, record, scene)
    figure.suptitle(
        f"Run time against error: left and low is good. Ring: default accuracy, {DEFAULT:.0e} m.\n"
        f"{'; '.join(dict.fromkeys(record['machines'].values()))}",
        fontsize=13,
    )
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _panel(axis, scene, found):
    known = is_known(scene)
    unit = 1e3 if known else 1.0
    ends = []
    for method, colour in COLOURS.items():
        if method not in found:
            continue
        errors, times = found[method]
        own = method.startswith("rustchain")
        axis.plot(
            errors,
            unit * times,
            "o-" if own else ".-",
            color=colour,
            linewidth=2.6 if own else 1.2,
            markersize=6 if own else 5,
            zorder=3 if own else 2,
        )
        last = int(np.argmin(errors))
        ends.append([errors[last], unit * times[last], SHORT.get(method, method), colour, own])
    if scene in TARGETS:
        axis.plot((1e-2, 1e-3), TARGETS[scene], "*", color="#d62728", markersize=11, zorder=4)
    axis.set(xscale="log", yscale="log", title=scene)
    low, high = axis.get_xlim()
    high = min(high, 30.0)  # beyond, nothing is right
    axis.set_xlim(low / (high / low) ** 0.42, high)
    bottom, top = axis.get_ylim()
    axis.set_ylim(bottom, top * (top / bottom) ** 0.12)  # room for names that are moved up
    _label(axis, ends)
    if not known:
        axis.axhline(1.0, color="#bbbbbb", linewidth=0.8, zorder=1)
        axis.annotate(
            "real time", (1.0, 1.0), xycoords=("axes fraction", "data"), ha="right", va="bottom",
            xytext=(-3, 1), textcoords="offset points", fontsize=8, color="#999999",
        )  # fmt: skip
    what = "time [ms]" if known else "time per simulated second [s]"
    error = "error" if known else "largest link position error at the end [m]"
    if scene in TARGETS:
        error = "energy residual over dissipated (stars: goals)"
    axis.set(xlabel=error, ylabel=what)
    axis.grid(True, which="major", color="#e6e6e6", linewidth=0.6)
    axis.spines[["top", "right"]].set_visible(False)


def _mark_default(axis, record, scene):
    """Ring auto's point at the default accuracy, where that is what its tolerances are."""
    if is_known(scene):
        return
    for line in record["lines"]:
        here = line["scene"] == scene and line["method"] == "rustchain auto"
        if here and line["tolerance"] == DEFAULT and np.isfinite(error_of(line)):
            ring = {"marker": "o", "markersize": 13, "markerfacecolor": "none"}
            axis.plot(error_of(line), line["wall"], color="#111111", zorder=6, **ring)


def _label(axis, ends):
    """Names left of the most exact point of each curve, moved apart where they would meet."""
    from matplotlib import patheffects

    figure = axis.figure
    figure.draw_without_rendering()
    to_screen, back = axis.transData.transform, axis.transData.inverted().transform
    placed = []
    for error, time, name, colour, own in sorted(ends, key=lambda end: end[1]):
        x, y = to_screen((error, time)) - np.array([9 * figure.dpi / 72, 0.0])
        height = 13 * figure.dpi / 72
        width = 6.0 * len(name) * figure.dpi / 72
        clear = False
        while not clear:
            clear = True
            for other_x, other_y, other_width in placed:
                beside = x - width > other_x or other_x - other_width > x
                if not beside and abs(y - other_y) < height:
                    y = other_y + 1.001 * height  # not to meet it again by rounding
                    clear = False
        placed.append((x, y, width))
        spot = back((x, y))
        moved = abs(y - to_screen((error, time))[1]) > 2
        axis.annotate(
            name,
            (error, time),
            xytext=(spot[0], spot[1]),
            textcoords="data",
            ha="right",
            va="center",
            fontsize=9,
            color=colour,
            fontweight="bold" if own else "normal",
            path_effects=[patheffects.withStroke(linewidth=2.5, foreground="white")],
            zorder=5,
            arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.5} if moved else None,
        )
