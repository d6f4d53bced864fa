"""Bounds that every finished run holds, and how near a run came to them.

Positions of bushings and outlines of teeth are compared here without the contact search of the
package: a contact that it misses is seen.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

import rustchain as rc

Array = npt.NDArray[np.float64]

# A residual above this share of the energy dissipated must not be silent. Where less is dissipated
# than these shares of the energy exchanged and stored, it is held against them.
SHARE, OF_EXCHANGED, OF_STORED = 0.05, 1e-2, 2e-4

# The package has the energies of mechanisms at the ends of all steps. Their ranges may be larger by
# this than those at rows: seed 6419 was 4e-5 above the bound at rows, and below it at steps.
BETWEEN_ROWS = 0.02

# What moves at no more than so many times the error that steps are allowed in speeds rests, and
# all that passes in it is error. That error [m/s] is the accuracy [m] times 1e5/s, or `atol`.
AT_REST, SPEED_OF_ACCURACY, DEFAULT_ATOL = 3.0, 1e5, 1e-5

# Residuals of joints [m or rad] and of their rates, against the largest distance or speed in the
# scene. Positions are corrected after a step only where they have left the joints by more than the
# tolerances, which are 1e-5 at most here.
DRIFT, DRIFT_RATE = 1e-6, 1e-4

# Largest tolerance of lengths [m] with which contacts are resolved: penetrations are about 1e-6 m.
COARSEST = 1e-6

# Young's modulus [Pa] from which on a penetration by a whole radius is none of softness.
HARD = 1e9

# Bodies faster than this [m/s], or contacts under more force than this times the square of the
# pitch [Pa], may penetrate by a radius: a roller at 500 m/s has the elastic energy of half of it.
# Chains run below 40 m/s and break at 1e8 Pa. In mechanisms, radius times length is the area.
FASTEST, STRONGEST = 100.0, 1e9

# No array of a result has a number that is not finite but these: no contact near, no peak yet.
MAY_BE_INFINITE = ("hinge_penetration", "tooth_penetration", "roller_penetration")
MAY_BE_INFINITE += ("contact_penetration",)


@dataclass(frozen=True)
class Figure:
    """How near a run came to a bound: `value` as a share of it, and what it is called if above."""

    name: str
    value: float
    failure: str


def energies(result: rc.Result) -> dict[str, float]:
    """Return the largest residual of a run, and what its energy balance can be held against [J]."""
    energy = result.energy

    def spread(values: Array) -> float:
        return float(values.max() - values.min())

    dissipated = float(energy.dissipated[-1])
    moved = (energy.external_work, energy.kinetic, energy.gravity, energy.elastic)
    return {
        "residual": float(np.abs(energy.residual).max()),
        "dissipated": dissipated,
        "exchanged": max(dissipated, *map(spread, moved)),
        "kinetic": float(energy.kinetic.max()),
        "stored": float((energy.kinetic + energy.elastic).max()),
        "at rest": _at_rest(result.scene),
    }


def _at_rest(scene: rc.Scene) -> float:
    """Return the kinetic energy [J] up to which links or bodies are at rest."""
    system, error = scene.system, _tolerances(scene.solver)[1]
    if isinstance(system, rc.Mechanism):
        mass = sum(body.mass for body in system.bodies if not body.fixed)
    else:
        chain = system.chain
        mass = 0.5 * chain.links * chain.strands * (chain.inner.mass + chain.outer.mass)
        mass += sum(carried for _, carried in chain.carried)
        mass += sum(end.mass for end in system.ends or () if isinstance(end, rc.LoadedEnd))
    return 0.5 * mass * (AT_REST * error) ** 2


def _tolerances(solver: rc.Solver) -> tuple[float, float]:
    """Return the errors that steps are allowed in lengths [m] and speeds [m/s] near zero."""
    if solver.rtol is None and solver.atol is None:
        return solver.accuracy, solver.accuracy * SPEED_OF_ACCURACY
    error = DEFAULT_ATOL if solver.atol is None else solver.atol
    return error, error


def balance(energy: dict[str, float]) -> float:
    """Return the residual over that which may be missing in silence; NaN is an imbalance."""
    at_rest = energy["at rest"]
    if energy["kinetic"] <= at_rest and energy["residual"] <= max(at_rest, energy["stored"]):
        return 0.0
    scale = max(
        energy["dissipated"], OF_EXCHANGED * energy["exchanged"], OF_STORED * energy["stored"]
    )
    bound = (1.0 + BETWEEN_ROWS) * SHARE * scale
    return energy["residual"] / bound if scale > 0.0 else np.inf


def figures(result: rc.Result) -> Iterator[Figure]:
    """Yield the figures of a run but that of its energy balance."""
    arrays = result.arrays
    system = result.scene.system
    for name, values in arrays.items():
        odd = np.isnan(values) if name in MAY_BE_INFINITE else ~np.isfinite(values)
        if odd.any():
            yield Figure(f"numbers that are not finite, {name}", np.inf, "not finite")
    accuracy = result.scene.solver.accuracy
    if accuracy > COARSEST:
        return
    if isinstance(system, rc.Mechanism):
        yield from _mechanism(system, arrays)
        return
    chain = system.chain
    if system.hinges == "ideal":
        drift = np.hypot(*np.moveaxis(arrays["hinge_eccentricity"], -1, 0)).max()
        yield Figure("drift of hinges", float(drift / (DRIFT * chain.pitch)), "drift")
    if _beyond_chains(chain, arrays):
        return
    if (
        system.hinges == "clearance"
        and chain.link_stiffness is None
        and _hard(result.scene.law_of_hinges, chain.material, chain.hinge.length)
    ):
        yield _depth("hinge", arrays["hinge_penetration"], chain.hinge.pin_radius)
    if _hard(result.scene.law_of_teeth, chain.material, chain.tooth_contact_length):
        yield _depth("tooth", arrays["tooth_penetration"], chain.contact_radius)
        yield from _through_teeth(system, arrays)


def _hard(law: rc.ForceLaw, material: rc.Material, length: float) -> bool:
    """Return whether a penetration by a whole radius is none of softness."""
    # A linear law has a stiffness of its own; a hard surface has about HARD times the length.
    soft = isinstance(law, rc.Linear) and law.stiffness < HARD * length
    return material.elastic_modulus >= HARD and not soft


def _beyond_chains(chain: rc.Chain, arrays: dict[str, Array]) -> bool:
    """Return whether speeds or forces are far above those of chains."""
    speed = np.abs(arrays["velocities"][..., :2]).max()
    force = max(arrays["peak_hinge_force"].max(), arrays["peak_tooth_force"].max(initial=0.0))
    return bool(speed > FASTEST or force > STRONGEST * chain.strands * chain.pitch**2)


def _depth(name: str, penetration: Array, radius: float) -> Figure:
    deepest = float(penetration.max(initial=0.0)) / radius
    return Figure(f"penetration of a {name} over the radius", deepest, "through a part")


def _mechanism(system: rc.Mechanism, arrays: dict[str, Array]) -> Iterator[Figure]:
    """Yield the drift of joints, and penetrations where surfaces are hard."""
    if system.joints:
        size = max(1.0, float(np.abs(arrays["positions"]).max()))
        drift = float(np.abs(arrays["joint_position_residual"]).max())
        yield Figure("drift of joints", drift / (DRIFT * size), "drift")
        speed = max(1.0, float(np.abs(arrays["velocities"]).max()))
        rate = float(np.abs(arrays["joint_velocity_residual"]).max())
        yield Figure("drift of speeds of joints", rate / (DRIFT_RATE * speed), "drift")
    for k, contact in enumerate(system.contacts):
        law, radius = contact.law, contact.radius
        if not isinstance(law, rc.SurfaceContact):
            continue
        beyond = arrays["peak_contact_force"][:, k].max() > STRONGEST * radius * law.length
        if _hard(law.law, law.material, law.length) and not beyond:
            yield _depth("contact", arrays["contact_penetration"][:, k], radius)


def _through_teeth(drive: rc.ChainDrive, arrays: dict[str, Array]) -> Iterator[Figure]:
    """Yield how far the centre of a bushing came inside the outline of a wheel."""
    chain, poses = drive.chain, arrays["positions"]
    bushings = _bushings(drive, poses)
    for k, sprocket in enumerate(drive.sprockets):
        angle = arrays["sprocket_angle"][:, k, None]
        turned = angle + sprocket.eccentricity_angle
        center = arrays["sprocket_center"][:, k, None, :]
        teeth = center + sprocket.eccentricity * _unit(turned)
        outline = sprocket.outline(chain, points=12)
        depth = _inside(outline, bushings - teeth, angle)
        # A centre on the outline is a penetration by the radius.
        share = 1.0 + depth / chain.contact_radius
        yield Figure("bushing's centre in a tooth", float(share.max()), "through a part")
    first = drive.hinge_count * (1 if chain.roller is None else 2) + len(drive.sprockets)
    for k, guide in enumerate(drive.guides):
        if isinstance(guide, rc.SmoothIdler) and guide.material is None:
            away = bushings - poses[:, first + k, None, :2]
            share = 1.0 + (guide.radius - np.hypot(away[..., 0], away[..., 1])) / (
                chain.contact_radius
            )
            yield Figure("bushing's centre in an idler", float(share.max()), "through a part")


def _bushings(drive: rc.ChainDrive, poses: Array) -> Array:
    """Return the centres of the hinges at the fronts of links [m], (times, links, 2).

    A free end behind an outer link, every second one, has no bushing.
    """
    links = drive.chain.links
    if drive.ends is not None and isinstance(drive.ends[1], rc.FreeEnd) and links % 2 == 0:
        links -= 1
    half = 0.5 * drive.chain.link_pitches[:links, None]
    return poses[:, :links, :2] + half * _unit(poses[:, :links, 2])


def _unit(angle: Array) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _inside(outline: Array, points: Array, angle: Array) -> Array:
    """Return how far points are inside a closed outline along the ray from its middle [m]."""
    around = np.arctan2(outline[:, 1], outline[:, 0])
    order = np.argsort(around)
    radius = np.hypot(outline[:, 0], outline[:, 1])
    place = np.arctan2(points[..., 1], points[..., 0]) - angle
    limit = np.interp(place, around[order], radius[order], period=2.0 * np.pi)
    return limit - np.hypot(points[..., 0], points[..., 1])
