"""A random legal scene from a seed: what moves, its laws, its solver, its start, its run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

import drives
import mechanisms
import parts
import rustchain as rc
from draw import Draw

ROWS = 100  # of a run

# Kinds of scenes, and in how many of a hundred each is.
KINDS: dict[str, tuple[int, Callable[[Draw], rc.ChainDrive | rc.Mechanism]]] = {
    "two sprockets": (26, drives.two_sprockets),
    "layout": (17, drives.layout),
    "published drive": (10, drives.paper),
    "open chain": (15, drives.open_chain),
    "ideal hinges": (6, drives.ideal_hinges),
    "tree of joints": (8, mechanisms.tree),
    "slider-crank": (5, mechanisms.slider_crank),
    "gears": (4, mechanisms.gears),
    "bouncing": (6, mechanisms.bouncing),
    "drive as mechanism": (3, mechanisms.of_a_drive),
}


@dataclass(frozen=True)
class Trial:
    """A scene and how it is run."""

    scene: rc.Scene
    duration: float
    restart: bool = False
    """Whether the second half runs twice, the second time from the state in a file."""
    features: list[str] = field(default_factory=list, compare=False)


@dataclass
class Seeded:
    """What a seed stands for; `trial` makes the descriptions, which may be refused."""

    seed: int
    longest: float = 0.04

    def __post_init__(self) -> None:
        self.draw = Draw(self.seed)
        shares = [kind for kind, (share, _) in KINDS.items() for _ in range(share)]
        self.kind = self.draw.one_of(shares)

    @property
    def name(self) -> str:
        """What the scene is called in tables."""
        return str(self.seed)

    def trial(self) -> Trial:
        """Return the scene, which runs for 2 to 40 ms [s], `longest` at most."""
        draw = self.draw
        scene = _scene(draw, KINDS[self.kind][1](draw))
        duration = min(self.longest, draw.log_between(2e-3, 4e-2))
        return Trial(scene, duration, draw.chance(0.2, "restart"), draw.features)


def _scene(draw: Draw, described: rc.ChainDrive | rc.Mechanism) -> rc.Scene:
    """Return the scene of a drive or a mechanism with laws, solver and start."""
    if isinstance(described, rc.Mechanism):
        keywords = {"solver": parts.solver(draw)} if draw.chance(0.4) else {}
        if draw.chance(0.15, "static"):
            keywords["start"] = "static"
        return rc.Scene(described, **keywords)
    laws = {"force_law": parts.law(draw) if draw.chance(0.5) else rc.LankaraniNikravesh()}
    ideal = described.hinges == "ideal"  # without contact in the hinges: no friction, no film
    if draw.chance(0.15, "other tooth law"):
        laws["tooth_law"] = parts.law(draw)
    if draw.chance(0.3):
        friction = parts.friction(draw)
        rubbing = {"tooth_law": laws.get("tooth_law", laws["force_law"])} if ideal else laws
        laws |= {name: replace(law, friction=friction) for name, law in rubbing.items()}
    if not ideal and draw.chance(0.15, "film"):
        law = laws["force_law"] if draw.chance(0.7) else parts.law(draw)
        laws["hinge_law"] = replace(law, film=parts.film(draw))
    if draw.chance(0.2, "impact velocity"):
        laws["min_impact_velocity"] = draw.log_between(1e-7, 1e-1)
    start = "static" if draw.chance(0.2, "static") else "generated"
    scene = rc.Scene(described, solver=parts.solver(draw), start=start, **laws)
    if not ideal and start == "generated" and draw.chance(0.04, "own start"):
        scene = _moved(draw, scene)
    return scene


def _moved(draw: Draw, scene: rc.Scene) -> rc.Scene:
    """Return the scene with links that begin with velocities of their own."""
    simulation = rc.Simulation(scene)
    velocities = np.array(simulation.velocities)
    links = scene.drive.chain.links
    random = np.random.default_rng(draw.integer(0, 2**32))
    velocities[:links, :2] += random.normal(0.0, draw.log_between(1e-3, 1.0), (links, 2))
    return replace(scene, positions=simulation.positions, velocities=velocities)
