"""Elastic links: plates in series with the contacts of their hinges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import rustchain as rc
from reference.compare import assert_within
from reference.dynamics import DriveEquations

LAWS = {
    "lankarani-nikravesh": rc.LankaraniNikravesh(),
    "johnson": rc.Johnson(),
    "enhanced": rc.EnhancedCylinder(damping="lankarani-nikravesh"),
}


def elastic(drive: rc.ChainDrive, stiffness: float | None) -> rc.ChainDrive:
    return replace(drive, chain=replace(drive.chain, link_stiffness=stiffness))


@pytest.mark.parametrize("stiffness", [1e7, 3e8])
@pytest.mark.parametrize("which", LAWS)
def test_forces_and_accelerations_agree_to_round_off(which, stiffness, paper, states_with_seat):
    law, drive = LAWS[which], elastic(paper, stiffness)
    simulation = rc.Simulation(drive, law)
    equations = DriveEquations(drive, law, law)
    pressed = 0
    for positions, velocities in states_with_seat("pitch-circle")[::5]:
        expected = equations.evaluate(positions, velocities, 0.04)
        e = simulation.evaluate(positions=positions, velocities=velocities, time=0.04)
        assert_within(e.hinge_force, expected.hinge_force, expected.hinge_force_bound, "hinges")
        assert_within(
            e.accelerations, expected.accelerations, expected.acceleration_bound, "accelerations"
        )
        pressed += np.count_nonzero(expected.hinge_force > 0.0)
    assert pressed > 50


@pytest.mark.parametrize("which", LAWS)
def test_a_tight_chain_is_longer_by_its_plates_and_its_contacts(which):
    stiffness, law = 5e7, LAWS[which]
    drive = rc.paper_drive(pretension=100.0)
    chain = drive.chain
    simulation = rc.Simulation(elastic(drive, stiffness), law, start="static")
    still = simulation.evaluate(
        positions=simulation.positions, velocities=np.zeros_like(simulation.velocities)
    )
    force, depth = still.hinge_force, still.hinge_penetration
    radii = (chain.hinge.pin_radius, chain.hinge.bore_radius)
    assert force.max() > 50.0
    expected = []
    for pull in force:

        def missing(d: float, pull: float = pull) -> float:
            return float(law.elastic_force(d, radii, chain.hinge.length)) - pull

        expected.append(brentq(missing, 0.0, 1e-4, xtol=1e-16, rtol=1e-14) + pull / stiffness)
    assert np.allclose(depth, expected, rtol=1e-9, atol=1e-15)
    assert depth.sum() == pytest.approx(np.sum(expected), rel=1e-12)


def test_the_energy_balance_closes_with_elastic_links():
    found = rc.Simulation(elastic(rc.paper_drive(25.0), 5e7)).run(0.02, 1e-3, progress=False)
    assert abs(found.energy.residual[-1]) < 1e-2 * found.energy.dissipated[-1]


def test_a_linear_contact_and_its_plates_are_two_springs_in_series():
    contact, plates = 3e8, 1e8
    both = contact * plates / (contact + plates)
    runs = [
        rc.Simulation(
            elastic(rc.paper_drive(25.0), plates), hinge_law=rc.Linear(stiffness=contact)
        ),
        rc.Simulation(rc.paper_drive(25.0), hinge_law=rc.Linear(stiffness=both)),
    ]
    for run in runs:
        run.step_to(2e-3)
    series, single = (run.positions for run in runs)
    assert np.abs(series - single).max() < 1e-9


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: elastic(rc.paper_drive(), 0.0), "Chain.link_stiffness"),
        (
            lambda: rc.Simulation(
                replace(elastic(rc.paper_drive(25.0), 1e8), hinges="ideal"),
            ),
            "Chain.link_stiffness.*ideal hinges",
        ),
    ],
)
def test_a_stiffness_of_links_that_means_nothing_is_refused(make, message):
    with pytest.raises(rc.InvalidInput, match=message):
        make()


@pytest.mark.parametrize("name", ["ANSI 40", "ANSI 120", "ISO 08B", "ISO 32B"])
def test_plates_of_the_catalogue_are_bars_of_twice_height_times_thickness(name):
    size = rc.chain_sizes()[name]
    chain = rc.catalogue_chain(name, links=20, strands=2, plates="elastic")
    modulus, pitch = chain.material.elastic_modulus, chain.pitch
    # An inner and an outer link, one behind the other.
    inner = 2 * modulus * size.inner_plate_height * size.inner_plate_thickness / pitch
    outer = 2 * modulus * size.outer_plate_height * size.outer_plate_thickness / pitch
    assert chain.axial_stiffness == pytest.approx(2 * 2 / (1 / inner + 1 / outer), rel=1e-14)
    assert rc.catalogue_chain(name, links=20).axial_stiffness is None
    shown = f"{2e6 * size.inner_plate_height * size.inner_plate_thickness:10.3f} mm^2"
    assert any(shown in line and line.endswith("derived") for line in str(size).splitlines())


def test_plates_may_be_of_another_material_than_the_chain():
    plates = rc.Plates(inner_section=4e-5, outer_section=4e-5, elastic_modulus=1e11)
    chain = replace(rc.paper_drive().chain, link_stiffness=plates)
    assert chain.axial_stiffness == pytest.approx(1e11 * 4e-5 / chain.pitch, rel=1e-14)
    steel = replace(chain, link_stiffness=replace(plates, elastic_modulus=None))
    assert steel.axial_stiffness == pytest.approx(2.07 * chain.axial_stiffness, rel=1e-14)
    assert rc.Chain.from_json(chain.to_json()) == chain
    assert replace(chain, link_stiffness=3e8, strands=3).axial_stiffness == pytest.approx(9e8)


@pytest.mark.parametrize(
    "make",
    [
        lambda **k: rc.two_sprocket_drive("ANSI 40", links=60, **k),
        lambda **k: rc.chain_drive("ANSI 40", [rc.Sprocket(17), rc.Sprocket(25, (0.3, 0.0))], **k),
        lambda **k: rc.open_chain(
            "ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(1.0)), 12, **k
        ),
    ],
)
def test_every_generator_offers_elastic_plates(make):
    stiffness = rc.catalogue_chain("ANSI 40", 20, plates="elastic").axial_stiffness
    assert make(plates="elastic").chain.axial_stiffness == stiffness
    assert make().chain.axial_stiffness is None
    with pytest.raises(rc.InvalidInput, match="plates: got 'soft'; expected 'rigid' or 'elastic'"):
        make(plates="soft")


def test_elastic_plates_of_a_chain_that_has_none_are_refused():
    with pytest.raises(rc.InvalidInput, match="plates = 'elastic': the chain given is rigid"):
        rc.two_sprocket_drive(rc.paper_drive().chain, (17, 17), plates="elastic")


@pytest.mark.parametrize("links", [6, 25])
def test_a_chain_under_load_stretches_by_load_over_stiffness_times_links(links):
    load = 200.0

    def place(stiffness: float | None) -> float:
        chain = replace(rc.paper_drive().chain, link_stiffness=stiffness)
        drive = rc.open_chain(chain, (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(load)), links)
        return float(rc.Simulation(drive, start="static").positions[links, 1])

    stretch = place(None) - place(1e7)
    chain = rc.paper_drive().chain
    weight = 9.81 * links * 0.5 * (chain.inner.mass + chain.outer.mass)
    # The mean tension of all links is that of the load and half of their own weight.
    assert stretch == pytest.approx((9.81 * load + 0.5 * weight) / 1e7 * links, rel=1e-4)


def test_a_file_may_give_plates(tmp_path):
    path = tmp_path / "drive.toml"
    path.write_text(
        """
        [drive]
        type = "two_sprocket_drive"
        links = 60
        [drive.chain]
        type = "catalogue_chain"
        name = "ANSI 40"
        links = 60
        link_stiffness = { type = "Plates", inner_section = 4e-5, outer_section = 3e-5 }
        [run]
        duration = 1e-3
        """,
        encoding="utf-8",
    )
    chain = rc.load_scene(path).drive.chain
    assert chain.link_stiffness == rc.Plates(4e-5, 3e-5)
    path.write_text(path.read_text(encoding="utf-8").replace("{ type", "3e8 # { type"))
    assert rc.load_scene(path).drive.chain.axial_stiffness == 3e8
