"""What several test files share: the paper's drive, and states of it to evaluate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import cycle, product

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

import rustchain as rc
from reference.dynamics import DriveEquations
from reference.states import (
    FIRST_OF_WRAP,
    LAST_OF_WRAP,
    State,
    in_chosen_regions,
    jiggled,
)

STATES = 100
REAL_TIMES = (4.5e-3, 6e-3, 9e-3, 15e-3)  # [s], after the first contacts

# Every run of the tests tries the same examples, however busy the machine is.
settings.register_profile(
    "fixed",
    derandomize=True,
    database=None,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
settings.load_profile("fixed")


def with_seat(drive: rc.ChainDrive, seat: str) -> rc.ChainDrive:
    """Return the drive with both sprockets' seats where ``seat`` says."""
    sprockets = [
        replace(sprocket, profile=replace(sprocket.profile, seat=seat))
        for sprocket in drive.sprockets
    ]
    return replace(drive, sprockets=sprockets)


@pytest.fixture(scope="session")
def paper() -> rc.ChainDrive:
    """The paper's drive with 25 N, so that gravity, tensioner and driver all act."""
    return rc.paper_drive(pretension=25.0)


@pytest.fixture(scope="session")
def paper_with_seat(paper: rc.ChainDrive) -> Callable[[str], rc.ChainDrive]:
    return lambda seat: with_seat(paper, seat)


@pytest.fixture(scope="session")
def real_states(paper: rc.ChainDrive) -> list[State]:
    """The start of the paper's drive and what it comes to in a few milliseconds."""
    # With one corrector all along: when the other one takes over is no part of these states. A
    # state of the default solver's path goes past the bound of tooth forces, 1.3 times: its bushing
    # is nearly concentric with the seat, where rounding turns the normal and so the rate of
    # penetration, which that bound leaves out (`DriveEquations._bound` has it for rollers).
    simulation = rc.Simulation(paper, solver=rc.Solver(method="pece"))
    states = [State(simulation.positions.copy(), simulation.velocities.copy())]
    for time in REAL_TIMES:
        simulation.step_to(time)
        states.append(State(simulation.positions.copy(), simulation.velocities.copy()))
    return states


@pytest.fixture(scope="session")
def states_with_seat(
    paper: rc.ChainDrive, real_states: list[State]
) -> Callable[[str], list[State]]:
    """A hundred random states around the real ones, with contacts in every region of the tooth.

    A third have every coordinate moved by micrometres; the rest have a bushing placed on a region
    at one end of a wrap, every region in turn.
    """
    made: dict[str, list[State]] = {}

    def make(seat: str) -> list[State]:
        law = rc.LankaraniNikravesh()
        equations = DriveEquations(with_seat(paper, seat), law, law)
        rng = np.random.default_rng(20101)
        bases = cycle(real_states)
        states = [jiggled(equations, next(bases), rng) for _ in range(STATES // 3)]
        firsts = [(sprocket, 0, region) for sprocket, region in product((0, 1), FIRST_OF_WRAP)]
        lasts = [(sprocket, 1, region) for sprocket, region in product((0, 1), LAST_OF_WRAP)]
        ends = cycle(firsts + lasts)
        while len(states) < STATES:
            sprocket, end, region = next(ends)
            regions = [0, 0, 0, 0]
            regions[2 * sprocket + end] = region
            # The start has clear wraps; later states only serve the jiggled third.
            states.append(in_chosen_regions(equations, real_states[0], regions, rng))
        return states

    def states(seat: str) -> list[State]:
        if seat not in made:
            made[seat] = make(seat)
        return made[seat]

    return states
