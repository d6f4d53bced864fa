"""Key figures and spectra of open chains, whose arrays have places without a hinge or a bushing."""

from dataclasses import replace

import numpy as np
import pytest

import rustchain as rc


@pytest.mark.parametrize(
    ("first", "last", "links", "hinges", "bushings"),
    [
        (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0), 10, {11}, {11}),
        (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd(), 4, {4, 5}, {4, 5}),
        (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd(), 5, {5, 6}, {6}),
        (rc.FreeEnd(), rc.AnchoredEnd((0.0, 0.0)), 4, {5, 6}, {5}),
    ],
)
def test_key_figures_count_the_hinges_and_bushings_that_there_are(
    first, last, links, hinges, bushings
):
    """Numbers from 1 of those that there are not; the first link is an inner one."""
    drive = rc.open_chain("ANSI 40", (first, last), links=links)
    result = rc.Simulation(drive, start="static").run(2e-3, progress=False)
    assert result.summary()["hinge_contact_share"] == 1.0  # all bear the weight below them
    numbers = np.arange(1, links + 3)
    force = np.tile(numbers.astype(float), (len(result.time), 1))
    arrays = {}
    for name, absent in (("hinge", hinges), ("tooth", bushings)):
        there = ~np.isin(numbers, list(absent))
        arrays[f"peak_{name}_force"] = np.where(there, force, np.nan)
    found = replace(result, arrays=result.arrays | arrays).summary()
    for name, absent in (("hinge", hinges), ("tooth", bushings)):
        expected = np.quantile([k for k in numbers if k not in absent], 0.99)
        assert found[f"{name}_force_p99"] == pytest.approx(expected, abs=0.5)


def test_the_mean_spectrum_of_an_open_chain_is_that_of_its_hinges():
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=10)
    result = rc.Simulation(drive).run(5e-3, progress=False)
    drawn = result.plot.spectrum("hinge_force").axes[0].lines[0].get_ydata()
    found = result.spectrum("hinge_force").sel(hinge=[*range(1, 10), 12])
    np.testing.assert_allclose(drawn, found.mean("hinge"), rtol=1e-12)


def test_joint_loads_of_an_open_chain_are_those_of_its_hinges():
    ends = (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd())
    drive = rc.open_chain("ANSI 40", ends, links=4, hinges="ideal")
    result = rc.Simulation(drive).run(2e-3, progress=False)
    largest, mean = (line.get_ydata() for line in result.plot.joint_loads().axes[0].lines)
    force = result.array("hinge_force")[:, [0, 1, 2, 5]]
    np.testing.assert_array_equal(largest, force.max(axis=1))
    np.testing.assert_array_equal(mean, force.mean(axis=1))
    assert mean[-1] > 0.0
    for name in ("hinge_4", "hinge_5"):
        with pytest.raises(rc.InvalidInput, match=f"joint: '{name}' is no joint with a load here"):
            result.plot.joint_loads(name)
    assert len(result.plot.joint_loads("hinge_6").axes[0].lines) == 1


@pytest.mark.parametrize(("links", "end"), [(40, (0.4, 0.0)), (41, (0.3, 0.2)), (6, (0.05, -0.02))])
def test_a_hanging_chain_with_roller_bodies_starts_as_near_to_rest_as_one_without(links, end):
    """Play in the hinges sets both apart from rest: generated hinges are concentric."""
    ends = rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd(end)
    apart = {}
    for rollers in ("fixed", "bodies"):
        drive = rc.open_chain("ANSI 40", ends, links, rollers=rollers)
        starts = (rc.Simulation(drive, start=start) for start in ("generated", "static"))
        generated, static = (simulation.positions[:links, :2] for simulation in starts)
        apart[rollers] = np.hypot(*(generated - static).T).max()
    clearance = drive.chain.hinge.clearance
    assert apart["fixed"] < links * clearance
    assert apart["bodies"] == pytest.approx(apart["fixed"], abs=0.01 * clearance)


def test_the_generated_polygon_of_a_chain_that_carries_a_mass_has_the_weight_of_its_rollers():
    apart = {}
    for rollers in ("fixed", "bodies"):
        chain = replace(rc.catalogue_chain("ANSI 40", 60, rollers=rollers), carried=[(12, 0.4)])
        ends = rc.AnchoredEnd((0.0, 0.0)), rc.AnchoredEnd((0.5, 0.1))
        drive = rc.open_chain(chain, ends, links=60)
        starts = (rc.Simulation(drive, start=start) for start in ("generated", "static"))
        generated, static = (simulation.positions[:60, :2] for simulation in starts)
        apart[rollers] = np.hypot(*(generated - static).T).max()
    # Without the rollers 3.3 mm; the rest is play.
    assert apart["bodies"] < 1.2 * apart["fixed"] < 1e-3


def test_the_pressure_of_an_open_chain_is_drawn_without_cycles():
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=10)
    result = rc.Simulation(drive).run(2e-3, progress=False)
    figure = result.plot.contact_pressure()
    assert "no revolution of the chain" in figure.axes[1].texts[0].get_text()


def test_a_stop_at_a_hinge_that_an_open_chain_does_not_have_is_refused():
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0)), links=10)
    with pytest.raises(rc.NoSuchPart, match="must be a hinge that this open chain has"):
        rc.Simulation(drive).run(1e-3, stop=[rc.HingeForceAbove(1.0, hinge=11)], progress=False)


def test_a_spectrum_of_an_open_chain_is_of_what_it_has():
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=10)
    result = rc.Simulation(drive).run(0.02, progress=False)
    with pytest.raises(rc.NoSuchPart, match="hinge 11: an open chain has none there"):
        result.plot.spectrum("hinge_force", hinge=11)
    still = replace(
        result, arrays={**result.arrays, "hinge_force": 0.0 * result.array("hinge_force")}
    )
    axes = still.plot.spectrum("hinge_force", hinge=1).axes[0]
    assert "nothing varies" in axes.texts[0].get_text()
