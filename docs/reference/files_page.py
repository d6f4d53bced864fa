"""Write the tables of keys in files.md from the descriptions and their docstrings."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import rustchain as rc
from rustchain.description.docstrings import descriptions_of
from rustchain.files.models import makers_of

PAGE = Path(__file__).with_name("files.md")
MARK = "## Every key\n"
BESIDE = "Any key of `Chain` but `pitch` may stand beside these, in place of the catalogue's."
GROUPS: dict[str, list[Callable[..., Any]]] = {
    "drive": [rc.chain_drive, rc.open_chain, rc.two_sprocket_drive, rc.paper_drive, rc.ChainDrive],
    "drive.chain": [
        rc.catalogue_chain,
        rc.Chain,
        rc.Link,
        rc.ClearanceHinge,
        rc.Roller,
        rc.Plates,
        rc.Material,
    ],
    "drive.sprockets": [rc.Sprocket, rc.PrescribedSpeed, rc.AppliedTorque, rc.Free],
    "drive.sprockets.motion.speed": [rc.Table, rc.Spline, rc.Sines, rc.SmoothStep],
    "drive.sprockets.profile": [
        rc.AnsiTooth,
        rc.IsoTooth,
        rc.StraightTooth,
        rc.CustomTooth,
        rc.ToothLine,
        rc.ToothArc,
    ],
    "drive.tensioner": [rc.Tensioner],
    "drive.guides": [rc.GuideRail, rc.GuideArm, rc.SmoothIdler],
    "drive.ends": [rc.AnchoredEnd, rc.LoadedEnd, rc.FreeEnd],
    "simulation": [rc.Scene, rc.Solver],
    "simulation.force_law": [*makers_of(rc.ForceLaw).values()],
    "simulation.force_law.friction": [rc.Coulomb, rc.LuGre],
    "simulation.force_law.film": [rc.LubricantFilm],
    "run": [rc.Simulation.run],
    "run.stop": [*makers_of(rc.StopCondition).values()],
}
LONG = 60  # characters of a text that is written once in a section
LEFT_OUT = {rc.Scene: {"system"}, rc.Simulation.run: {"self", "progress", "callback"}}


def rows(target: Callable[..., Any], above: dict[tuple[str, str], str]) -> Iterator[str]:
    """Yield a row of the table for each key; a long text of a table above is referred to."""
    texts = descriptions_of(target)
    for name, parameter in inspect.signature(target).parameters.items():
        if name in LEFT_OUT.get(target, ()):
            continue
        needed = parameter.default is parameter.empty
        default = parameter.default
        if needed:
            shown = "needed"
        elif default is None or default == ():
            shown = ""
        elif isinstance(default, int | float | str | tuple):
            shown = f"`{json.dumps(default)}`"
        else:
            shown = f"`{type(default).__name__}`"
        text = texts.get(name, "").replace("|", "/")
        first = above.setdefault((name, text), target.__name__)
        if first != target.__name__ and len(text) > LONG:
            text = f"See `{first}`."
        yield f"| `{name}` | {shown} | {text} |"


def tables() -> str:
    """Return all tables."""
    parts = [MARK]
    for key, targets in GROUPS.items():
        parts.append(f"\n### {key}\n")
        above: dict[tuple[str, str], str] = {}
        for target in targets:
            is_table = target not in LEFT_OUT
            lines = list(rows(target, above))
            first = inspect.cleandoc(target.__doc__ or "").split("\n")[0]
            name = target.__name__
            parts.append(f"\n`{name}`: {first}\n" if is_table else "\n")
            if target is rc.catalogue_chain:
                parts.append(f"{BESIDE}\n")
            if lines:
                parts.append("\n| key | default | |\n|---|---|---|\n" + "\n".join(lines) + "\n")
    return "".join(parts)


def main() -> None:
    """Write the page."""
    kept = PAGE.read_text(encoding="utf-8").split(MARK)[0]
    PAGE.write_text(kept + tables(), encoding="utf-8")


if __name__ == "__main__":
    main()
