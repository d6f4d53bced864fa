"""A chain drive as a mechanism: its links, hinges, sprockets and tensioner as parts."""

from __future__ import annotations

import math
from dataclasses import replace

from rustchain import _rustchain
from rustchain.arguments import admitted, shown
from rustchain.description.drive import AppliedTorque, ChainDrive, Hinges, PrescribedSpeed
from rustchain.description.laws.force import ForceLaw, LankaraniNikravesh
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.mechanism.parts import GROUND, SurfaceContact, Table, TimeFunction
from rustchain.errors import InvalidInput
from rustchain.simulation.simulation import Simulation
from rustchain.simulation.tensioner_mechanism import add_tensioner, mass_beside_an_arm
from rustchain.typing import Array

_STEEL_DENSITY = 7850.0  # [kg/m^3], as the generator's discs


def drive_mechanism(
    drive: ChainDrive,
    hinges: Hinges,
    force_law: ForceLaw | None,
    min_impact_velocity: float,
    placed: tuple[Array | None, Array | None] = (None, None),
) -> Mechanism:
    """Return the mechanism that `ChainDrive.to_mechanism` promises.

    `placed` holds positions and velocities, (bodies, 3) each, in place of the generated ones.
    """
    force_law = admitted("to_mechanism(force_law)", force_law, ForceLaw | None)
    if hinges not in ("clearance", "ideal"):
        msg = f"hinges = {shown(hinges)}: must be 'clearance' or 'ideal'"
        raise InvalidInput(msg)
    if drive.chain.roller is not None:
        msg = (
            "Chain.roller: a mechanism has no rollers as bodies; give it a chain with "
            "rollers='fixed', or run the drive itself with hinges='clearance'"
        )
        raise InvalidInput(msg)
    if drive.ends is not None:
        msg = "ChainDrive.ends: an open chain is no mechanism yet; it has clearance in its hinges"
        raise InvalidInput(msg)
    drive = replace(drive, hinges=hinges)
    chain, law = drive.chain, force_law or LankaraniNikravesh()
    with_clearance = replace(drive, hinges="clearance")
    generated = Simulation(with_clearance)
    if placed[0] is not None:  # which must have what is held in its place, as with clearance
        places = placed[0].copy()
        if places.shape == generated.positions.shape:
            places[: chain.links] = generated.positions[: chain.links]
        Simulation(with_clearance, positions=places, velocities=generated.velocities)
    start = (
        generated.positions if placed[0] is None else placed[0],
        generated.velocities if placed[1] is None else placed[1],
    )
    if drive.guides:
        msg = f"ChainDrive.guides: {len(drive.guides)} of them; a mechanism takes none, leave them"
        raise InvalidInput(msg)
    if chain.link_stiffness is not None:
        msg = (
            f"Chain.link_stiffness = {chain.link_stiffness}: must be None in a mechanism, whose "
            "links are rigid; ideal hinges have no contact for it to be in series with"
        )
        raise InvalidInput(msg)
    mechanism = Mechanism(drive.gravity, drive.name)
    for number, sprocket in enumerate(drive.sprockets):
        if sprocket.eccentricity:
            msg = (
                f"ChainDrive.sprockets[{number}].eccentricity = {sprocket.eccentricity}: must be 0 "
                "in a mechanism, whose teeth are concentric"
            )
            raise InvalidInput(msg)
    table = _rustchain.chain_links(chain)
    links = chain.links
    for k, (_, mass, inertia, _) in enumerate(table):
        mechanism.add_body(f"link_{k + 1}", mass, inertia, start[0][k], start[1][k])
    for k in range(len(drive.sprockets)):
        _add_sprocket(mechanism, drive, k, start)

    def surfaces(length: float) -> SurfaceContact:
        return SurfaceContact(law, length, chain.material, min_impact_velocity)

    for k in range(links):
        behind = (k + 1) % links
        front, rear = 0.5 * float(table[k, 0]), -0.5 * float(table[behind, 0])
        ends = ((f"link_{k + 1}", (front, 0.0)), (f"link_{behind + 1}", (rear, 0.0)))
        inner, outer = ends if table[k, 3] else ends[::-1]
        name = f"hinge_{k + 1}"
        if hinges == "ideal":
            mechanism.add_revolute(name, inner[0], outer[0], inner[1], outer[1])
        else:
            mechanism.add_clearance_joint(
                name,
                inner[0],
                outer[0],
                chain.hinge.bore_radius,
                chain.hinge.pin_radius,
                surfaces(chain.strands * chain.hinge.length),
                inner[1],
                outer[1],
            )
        for s, sprocket in enumerate(drive.sprockets):
            mechanism.add_sprocket_contact(
                f"bushing_{k + 1}_on_sprocket_{s + 1}",
                f"sprocket_{s + 1}",
                inner[0],
                sprocket,
                chain,
                surfaces(chain.strands * chain.tooth_contact_length),
                inner[1],
            )
    return mechanism


def _add_sprocket(
    mechanism: Mechanism, drive: ChainDrive, k: int, start: tuple[Array, Array]
) -> None:
    """Add sprocket `k` with its bearing, motor and tensioner."""
    sprocket, chain, name = drive.sprockets[k], drive.chain, f"sprocket_{k + 1}"
    radius = chain.pitch / (2.0 * math.sin(math.pi / sprocket.teeth))
    disc = _STEEL_DENSITY * math.pi * radius**2 * chain.strands * chain.tooth_contact_length
    mass = disc if sprocket.mass is None else sprocket.mass
    inertia = 0.5 * mass * radius**2 if sprocket.inertia is None else sprocket.inertia
    inertia += sprocket.load_inertia
    row = chain.links + k
    position = start[0][row]
    left = mass_beside_an_arm(drive.tensioner, k + 1, mass)
    mechanism.add_body(name, left, inertia, position, start[1][row])
    center = (float(position[0]), float(position[1]))
    tensioner = drive.tensioner
    if tensioner is not None and tensioner.sprocket == k + 1:
        add_tensioner(mechanism, drive, (mass, position, start[1][row]))
    elif sprocket.bearing == "fixed":
        mechanism.add_revolute(f"bearing_{k + 1}", GROUND, name, at=center)
    if isinstance(sprocket.motion, PrescribedSpeed):
        speed = _function(sprocket.motion.speed)
        mechanism.add_driver(f"motor_{k + 1}", GROUND, name, speed=speed)
    elif isinstance(sprocket.motion, AppliedTorque):
        mechanism.add_torque(f"motor_{k + 1}", name, _function(sprocket.motion.torque))
        if (curve := sprocket.motion.curve) is not None:
            rows = curve if isinstance(curve, tuple) else ((0.0, curve), (1.0, curve))
            mechanism.add_torque(f"curve_{k + 1}", name, by_speed=rows)


def _function(value: object) -> TimeFunction:
    """Return a number or a table of time."""
    return Table(value) if isinstance(value, tuple) else float(value)  # type: ignore[arg-type]
