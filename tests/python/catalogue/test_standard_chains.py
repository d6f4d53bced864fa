"""Chains and drives by name: lengths, masses and options against numbers worked out by hand."""

import math
from dataclasses import replace

import pytest

import rustchain as rc

INCH = 0.0254  # [m]
ROLLER = 0.3125 * INCH  # of no. 40
BUSHING = 0.705 * ROLLER
BORE = BUSHING + 1e-4
WIDTH = 0.3125 * INCH


def test_a_pin_bears_on_the_whole_bushing_with_its_ends_in_the_inner_plates():
    """No. 40: 5/16 in between plates of 0.060 in; pins of 0.1565 in in bores of 0.1575 in."""
    hinge = rc.catalogue_chain("ANSI 40", 60).hinge
    assert hinge.pin_radius == pytest.approx(0.1565 * INCH / 2)
    assert hinge.bore_radius == pytest.approx(0.1575 * INCH / 2)
    assert hinge.length == pytest.approx((0.3125 + 2 * 0.060) * INCH)


def test_links_stretch_where_elastic_plates_are_asked_for():
    """Two plates of 0.060 in, 0.95 and 0.82 pitches high."""
    assert rc.catalogue_chain("ANSI 40", 60).link_stiffness is None
    found = rc.catalogue_chain("ANSI 40", 60, plates="elastic").link_stiffness
    assert found.inner_section == pytest.approx(2 * 0.060 * INCH * 0.95 * 0.5 * INCH)
    assert found.outer_section == pytest.approx(2 * 0.060 * INCH * 0.82 * 0.5 * INCH)


def test_rollers_that_are_bodies_leave_the_inner_links():
    """Two rollers, half a pitch from the middle: Steiner's theorem; the total mass stays."""
    fixed = rc.catalogue_chain("ANSI 40", 60)
    rolling = rc.catalogue_chain("ANSI 40", 60, rollers="bodies")
    assert fixed.roller is None
    assert fixed.bushing_radius == pytest.approx(ROLLER / 2)
    roller = rolling.roller
    assert roller.radius == pytest.approx(ROLLER / 2)
    assert roller.bore_radius == pytest.approx(BORE / 2)
    assert roller.length == pytest.approx(WIDTH)
    assert rolling.bushing_radius == pytest.approx(BUSHING / 2)
    assert rolling.outer == fixed.outer
    assert rolling.inner.mass + 2 * roller.mass == pytest.approx(fixed.inner.mass)
    away = roller.mass * (0.25 * INCH) ** 2
    turning = 2 * (roller.inertia + away)
    assert rolling.inner.inertia + turning == pytest.approx(fixed.inner.inertia)
    # A hollow cylinder, less than half of the inner link.
    assert roller.inertia == pytest.approx(roller.mass * (ROLLER**2 + BORE**2) / 8)
    assert 0.0 < 2 * roller.mass < 0.5 * fixed.inner.mass


def test_a_chain_without_rollers_has_none_that_turn():
    with pytest.raises(rc.InvalidInput, match="ANSI 25 is a chain without rollers"):
        rc.catalogue_chain("ANSI 25", 60, rollers="bodies")


def test_the_published_drive_has_the_published_numbers():
    """38 links round 17 teeth: strands of (38 - 17) / 2 pitches; 0.817 kg, 588.29e-6 kg m^2."""
    drive = rc.paper_drive()
    first, second = drive.sprockets
    assert (first.mass, first.inertia) == (second.mass, second.inertia) == (0.817, 588.29e-6)
    assert first.motion.speed == pytest.approx(120 * 2 * math.pi / 60)
    assert second.center == (pytest.approx(10.5 * 0.0127, rel=1e-4), 0.0)
    assert (drive.chain.inner.inertia, drive.chain.roller) == (0.1795e-6, None)


def test_the_published_chain_keeps_its_mass_and_inertia_with_rollers():
    """The published inertia of an inner link does not count what turns on it."""
    fixed, rolling = rc.paper_drive().chain, rc.paper_drive(rollers="bodies").chain
    assert rolling.inner.inertia == fixed.inner.inertia
    assert rolling.inner.mass + 2 * rolling.roller.mass == pytest.approx(fixed.inner.mass)
    assert rolling.roller.radius == pytest.approx(fixed.bushing_radius)
    assert rolling.bushing_radius == pytest.approx(BUSHING / 2)


@pytest.mark.parametrize("pretension", [0.0, None])
def test_without_pretension_the_centres_are_fixed(pretension):
    assert rc.paper_drive(pretension).tensioner is None
    assert rc.two_sprocket_drive(links=60, pretension=pretension).tensioner is None


def test_a_pretension_is_that_of_a_tensioner_on_sprocket_2():
    for drive in (rc.paper_drive(1.0), rc.two_sprocket_drive(links=60, pretension=1.0)):
        assert (drive.tensioner.sprocket, drive.tensioner.pretension) == (2, 1.0)


def test_a_chain_that_is_given_has_its_own_links_rollers_and_plates():
    chain = rc.catalogue_chain("ANSI 40", 62, rollers="bodies", plates="elastic")
    drive = rc.two_sprocket_drive(chain, (17, 17), rollers="bodies", plates="elastic")
    assert drive.chain == chain
    assert drive.sprockets[1].center[0] == pytest.approx((62 - 17) / 2 * 0.0127, rel=1e-4)
    shorter = rc.two_sprocket_drive(chain, (17, 17), links=58)
    assert shorter.chain == replace(chain, links=58)
    assert shorter.sprockets[1].center[0] == pytest.approx((58 - 17) / 2 * 0.0127, rel=1e-4)
    plain = rc.catalogue_chain("ANSI 40", 62)
    with pytest.raises(rc.InvalidInput, match=r"rollers = 'bodies': the chain given has none"):
        rc.two_sprocket_drive(plain, rollers="bodies")
    with pytest.raises(rc.InvalidInput, match=r"plates = 'elastic': the chain given is rigid"):
        rc.two_sprocket_drive(plain, plates="elastic")
