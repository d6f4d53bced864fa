"""A random legal scene from a seed: what moves, its laws, its solver, its start."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import drives
import mechanisms
import parts
import rustchain as rc
from draw import Draw

# Kinds of scenes, and in how many of a hundred each is.
KINDS: dict[str, tuple[int, Callable[[Draw], rc.ChainDrive | rc.Mechanism]]] = {
    "two sprockets": (28, drives.two_sprockets),
    "layout": (18, drives.layout),
    "published drive": (12, drives.paper),
    "open chain": (16, drives.open_chain),
    "ideal hinges": (6, drives.ideal_hinges),
    "pendulum": (5, mechanisms.pendulum),
    "slider-crank": (6, mechanisms.slider_crank),
    "bouncing": (6, mechanisms.bouncing),
    "drive as mechanism": (3, mechanisms.of_a_drive),
}


@dataclass
class Scene:
    """What a seed stands for; `run` makes the descriptions, which may be refused."""

    seed: int

    def __post_init__(self) -> None:
        self.draw = Draw(self.seed)
        shares = [kind for kind, (share, _) in KINDS.items() for _ in range(share)]
        self.kind = self.draw.one_of(shares)

    def simulation(self) -> rc.Simulation:
        """Return the scene's simulation, at its start."""
        draw = self.draw
        described = KINDS[self.kind][1](draw)
        if isinstance(described, rc.Mechanism):
            keywords = {"solver": parts.solver(draw)} if draw.chance(0.3) else {}
            return rc.Simulation(described, **keywords)
        if described.hinges == "ideal":
            return rc.Simulation(described, force_law=parts.law(draw))
        laws = {"force_law": parts.law(draw) if draw.chance(0.5) else rc.LankaraniNikravesh()}
        if draw.chance(0.15, "other tooth law"):
            laws["tooth_law"] = parts.law(draw)
        if draw.chance(0.3):
            friction = parts.friction(draw)
            laws = {name: replace(law, friction=friction) for name, law in laws.items()}
        if draw.chance(0.15, "film"):
            film = rc.LubricantFilm(draw.log_between(0.005, 0.5))
            laws["hinge_law"] = replace(laws["force_law"], film=film)
        if draw.chance(0.2):
            laws["min_impact_velocity"] = draw.log_between(1e-5, 1e-1)
        start = "static" if draw.chance(0.25, "static") else "generated"
        return rc.Simulation(described, solver=parts.solver(draw), start=start, **laws)

    def run(self, longest: float) -> rc.Result:
        """Run the scene for 2 to 40 ms [s], `longest` at most, and return its result."""
        simulation = self.simulation()
        duration = min(longest, self.draw.log_between(2e-3, 4e-2))
        return simulation.run(duration, report_step=duration / 100.0, progress=False)
