"""Lubricant in hinges: against Reynolds' equation, the NumPy reference, and as users meet it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

import rustchain as rc
from checks.check import hold
from checks.contacts import CLEARANCE, LENGTH, RADII, film_at
from reference.compare import assert_within
from reference.dynamics import DriveEquations

pytest.importorskip("scipy", minversion="1.11")
from scipy.sparse import diags_array, eye_array, kron

LN = rc.LankaraniNikravesh()


@pytest.mark.parametrize("ratio", [0.05, 0.2, 0.4, 0.6, 0.8, 0.9])
@pytest.mark.parametrize("viscosity", [0.01, 0.5])
def test_force_is_that_of_reynolds_equation(ratio, viscosity):
    hold([film_at(ratio, viscosity)])


def leaking(ratio: float, velocity: np.ndarray, around: int, along: int) -> np.ndarray:
    """Return force along the eccentricity and left of it where oil leaks at both ends of the pin.

    Reynolds' equation by cells around the pin and along it, no pressure at the ends; what is
    negative is cut off.
    """
    turn, width = 2.0 * np.pi / around, LENGTH / along
    middle = (np.arange(around) + 0.5) * turn
    thickness = CLEARANCE * (1.0 - ratio * np.cos(middle))
    walls = CLEARANCE * (1.0 - ratio * np.cos(np.arange(around) * turn))
    to_last = walls**3 * width / (12.0 * RADII[0] * turn)
    outward = thickness**3 * RADII[0] * turn / (12.0 * width)
    to_next = np.roll(to_last, -1)
    ring = diags_array(to_last + to_next) - (shift := diags_array(to_next) @ rolled(around))
    ring = ring - shift.T
    chain = diags_array(
        [[-1.0] * (along - 1), [2.0] * along, [-1.0] * (along - 1)], offsets=[-1, 0, 1]
    )
    ends = diags_array(np.r_[1.0, np.zeros(along - 2), 1.0])  # an end is half a cell away
    matrix = kron(ring, eye_array(along)) + kron(diags_array(outward), chain + ends)
    sinks = (velocity[0] * np.cos(middle) + velocity[1] * np.sin(middle)) * RADII[0] * turn * width
    pressure = spsolve(matrix.tocsc(), np.repeat(sinks, along)).reshape(around, along)
    film = np.clip(pressure, 0.0, None).sum(axis=1) * width * RADII[0] * turn
    return -np.array([np.cos(middle) @ film, np.sin(middle) @ film])


def rolled(count: int):
    """Return the matrix that takes from every cell of a ring the next one."""
    return diags_array([np.ones(count - 1), [1.0]], offsets=[1, 1 - count])


@pytest.mark.parametrize(
    ("ratio", "squeezed", "dragged"),
    [(0.3, 0.747, 0.622), (0.6, 0.824, 0.686), (0.9, 0.898, 0.833)],
)
def test_oil_that_leaks_at_the_ends_takes_a_tenth_to_two_fifths(ratio, squeezed, dragged):
    film = rc.LubricantFilm(1.0, tension=0.0)
    for velocity, share in [((2e-3, 0.0), squeezed), ((0.0, 2e-3), dragged)]:
        finite = np.hypot(*leaking(ratio, np.array(velocity), 200, 20))
        long = np.hypot(*film.force(ratio * CLEARANCE, velocity, RADII, LENGTH))
        # Measured with four times the cells; these are 0.004 off at most.
        assert finite / long == pytest.approx(share, abs=0.01)


def test_wedge_alone_and_squeeze_alone_are_the_textbooks():
    mu, c, ratio = 0.1, CLEARANCE, np.array([0.05, 0.3, 0.6, 0.9])
    spin = 12.0  # sum of both [rad/s]: seen from their mean the centre goes back at half of it
    wedge = np.stack([0.0 * ratio, -0.5 * spin * ratio * c], axis=-1)
    film = rc.LubricantFilm(mu, tension=0.0)
    force = film.force(ratio * c, wedge, RADII, LENGTH)
    scale = mu * RADII[0] ** 3 * LENGTH / c**2
    rest = 1.0 - ratio**2
    across = 6.0 * np.pi * scale * spin * ratio / ((2.0 + ratio**2) * np.sqrt(rest))
    along = -12.0 * scale * spin * ratio**2 / ((2.0 + ratio**2) * rest)
    assert np.allclose(force, np.stack([along, across], axis=-1), rtol=1e-12)
    closing = np.stack([c + 0.0 * ratio, 0.0 * ratio], axis=-1)
    force = film.force(ratio * c, closing, RADII, LENGTH)
    arc = np.pi + 2.0 * np.arcsin(ratio) + 2.0 * ratio * np.sqrt(rest)
    assert np.allclose(force[:, 0], -6.0 * scale * arc / rest**1.5, rtol=1e-12)
    # Closing and opening together have both halves: the full film.
    opening = film.force(ratio * c, -closing, RADII, LENGTH)
    full = 12.0 * np.pi * scale / rest**1.5
    assert np.allclose(opening[:, 0] - force[:, 0], full, rtol=1e-12)
    # So has what is pulled at less than it bears.
    gentle = rc.LubricantFilm(mu, tension=1e5).force(ratio * c, -1e-6 * closing, RADII, LENGTH)
    assert np.allclose(gentle[:, 0], 1e-6 * full, rtol=1e-4)


FILMS = {
    "thin oil": (rc.LubricantFilm(0.01), None),
    "thick oil, half film": (rc.LubricantFilm(0.5, handover=0.8, tension=0.0), None),
    "short, with friction": (rc.LubricantFilm(0.1, length=6e-3), rc.Coulomb(0.1)),
}


@pytest.mark.parametrize("which", FILMS)
def test_forces_and_accelerations_agree_to_round_off(which, paper, states_with_seat):
    film, friction = FILMS[which]
    simulation = rc.Simulation(
        paper, replace(LN, friction=friction), hinge_law=replace(LN, film=film, friction=friction)
    )
    equations = DriveEquations(
        paper, replace(LN, film=film, friction=friction), replace(LN, friction=friction)
    )
    thick = 0
    for positions, velocities in states_with_seat("pitch-circle"):
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        assert_within(
            e.hinge_force_vector,
            expected.hinge_force_vector,
            expected.hinge_vector_bound[..., None],
            "forces in hinges as vectors",
        )
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        thick += expected.film_power > 0.0
    assert thick > 90


def test_what_a_film_loses_is_a_place_of_its_own():
    simulation = rc.Simulation(
        rc.paper_drive(25.0), hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    )
    result = simulation.run(0.02, 1e-3, progress=False)
    energy = result.energy
    assert energy.hinge_film is not None
    assert np.all(np.diff(energy.hinge_film) > 0.0)
    assert abs(energy.residual[-1]) < 1e-2 * energy.dissipated[-1]
    assert "hinge_film" in result.power_balance()["channel"].to_numpy()
    film_force = result.hinge(3).film_force
    assert film_force is not None
    assert film_force.max() > 0.0
    dry = rc.Simulation(rc.paper_drive(25.0)).run(2e-3, 1e-3, progress=False)
    assert dry.energy.hinge_film is None
    assert dry.hinge(3).film_force is None


def test_a_state_with_a_film_is_saved_and_goes_on(tmp_path):
    simulation = rc.Simulation(
        rc.paper_drive(25.0), hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    )
    simulation.step_to(3e-3)
    simulation.save_state(tmp_path / "state.npz")
    again = rc.Simulation.load_state(tmp_path / "state.npz")
    for run in (simulation, again):
        run.step_to(5e-3)
    assert np.array_equal(simulation.positions, again.positions)
    assert simulation.hinge_law == rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))


def test_a_sweep_has_the_viscosity_as_a_parameter():
    found = rc.sweep(
        rc.paper_drive(25.0),
        {"hinge_law.film": [None, rc.LubricantFilm(0.1)]},
        lambda result: result.hinge(3).force.max(),
        duration=8e-3,
        report_step=1e-4,
        progress=False,
    )
    assert not found.errors
    assert found.values[0] != found.values[1]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: rc.LubricantFilm(0.0), "LubricantFilm.viscosity = 0.*leave the film out"),
        (lambda: rc.LubricantFilm(0.1, length=0.0), "LubricantFilm.length"),
        (lambda: rc.LubricantFilm(0.1, handover=1.0), "LubricantFilm.handover"),
        (lambda: rc.LubricantFilm(0.1, tension=-1.0), "LubricantFilm.tension"),
        (lambda: rc.Hertz(film=0.1), "Hertz.film"),
        (
            lambda: rc.Simulation(rc.paper_drive(), tooth_law=rc.Hertz(film=rc.LubricantFilm(0.1))),
            "only hinges have a film",
        ),
        (
            lambda: rc.Simulation(
                replace(rc.paper_drive(25.0), hinges="ideal"),
                hinge_law=rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1)),
            ),
            "film.*whose hinges have no contact",
        ),
        (lambda: rc.LubricantFilm(0.1).force(1e-6, (0.0, 0.0), (2.0e-3, 2.0e-3), 0.01), "radii"),
        (
            lambda: rc.LubricantFilm(0.1).force(-1e-5, (1e-3, 0.0), RADII, LENGTH),
            "eccentricity = -0.00001",
        ),
        *[
            (
                lambda given=given: rc.LubricantFilm(0.1).force(*given, RADII, LENGTH),
                r"got shape \(\d?,?\) with eccentricity of shape .*; expected \(\.\.\., 2\) and",
            )
            for given in (([1e-6, 2e-6], (1e-3, 0.0)), (1e-6, 1e-3))
        ],
    ],
)
def test_a_film_that_means_nothing_is_refused_and_so_are_arguments_of_its_force(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()


@pytest.mark.parametrize("length", [None, 0.011])
def test_each_of_several_strands_has_a_film_of_the_given_length(length):
    paper = rc.paper_drive()
    law = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1, length=length))

    def film_force(strands):
        drive = replace(paper, chain=replace(paper.chain, strands=strands))
        result = rc.Simulation(drive, hinge_law=law).run(
            2e-4, report_step=1e-4, record=["hinges"], progress=False
        )
        return result.array("hinge_film_force")[1]

    # Masses and films are three times those of one: the films carry the motion before contact.
    one, three = film_force(1), film_force(3)
    assert np.max(one) > 0.0
    np.testing.assert_allclose(three, 3.0 * one, rtol=1e-6, atol=1e-9 * np.max(one))


def test_hinge_forces_and_their_peaks_are_those_of_contact_and_film_together():
    law = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.1))
    drive = rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=25.0, torque=-3.0, pretension=60.0
    )
    result = rc.Simulation(drive, hinge_law=law).run(0.03, progress=False)
    force = result.array("hinge_force")
    size = np.linalg.norm(result.array("hinge_force_vector"), axis=-1)
    np.testing.assert_allclose(force, size, rtol=1e-12, atol=1e-12)
    assert size.max() > 50.0
    assert np.all(result.peaks.hinge_force >= size * (1.0 - 1e-12))
    mean = result.peaks.hinge_impulse[1:].sum(0) / result.time[-1]
    np.testing.assert_allclose(mean, 0.5 * (force[1:] + force[:-1]).mean(0), rtol=0.05, atol=0.5)
    assert result.summary()["hinge_force_largest"] == result.peaks.hinge_force.max()
    stopped = rc.Simulation(drive, hinge_law=law).run(
        0.03, progress=False, stop=rc.HingeForceAbove(0.5 * size.max())
    )
    assert stopped.status == "stopped"


@pytest.mark.filterwarnings("ignore:start = 'static'")
def test_the_largest_forces_of_a_thick_film_do_not_depend_on_the_accuracy():
    # Loaded hinges begin in dry contact, and films are rebuilt where a hinge unloads.
    law = rc.LankaraniNikravesh(film=rc.LubricantFilm(0.5))
    drive = rc.two_sprocket_drive(
        "ANSI 40", teeth=(17, 25), links=60, speed=rc.rpm(1500), torque=-5.0, pretension=100.0
    )

    def largest(accuracy):
        solver = rc.Solver(accuracy=accuracy)
        scene = rc.Scene(drive, force_law=law, start="static", solver=solver)
        simulation = rc.Simulation(scene)
        result = simulation.run(0.02, 1e-5, record=("hinges",), energy=False, progress=False)
        return result.peaks.hinge_force.max()

    # Single impacts of a chaotic motion differ. Corrections with the slope of the other side of a
    # film, which is up to a hundred times softer, left ten times the force.
    assert 0.5 < largest(1e-9) / largest(1e-11) < 2.0
