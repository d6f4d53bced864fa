"""Outputs of runs against closed formulae: wrap, polygon, moving strand, centrifugal tension."""

import math

import numpy as np
import pytest

import rustchain as rc
from checks import sprockets, strands
from checks.check import hold
from rustchain.analysis.strands import natural_frequencies


@pytest.mark.parametrize(
    ("teeth", "flank"), [(13, 30), (17, 20), (17, 25), (17, 30), (25, 20), (25, 25), (40, 30)]
)
def test_load_along_the_wrap_is_a_geometric_series(teeth, flank):
    hold(sprockets.wrap_series(teeth, flank)[0])


@pytest.mark.parametrize("teeth", [(13, 13), (17, 25), (25, 17)])
@pytest.mark.parametrize("pitches", [16.0, 16.5])
def test_polygons_make_the_transmission_error(teeth, pitches):
    """Whole and half pitches of span. Amplitudes at the tooth order: 5e-5 to 2e-3 rad."""
    checks, _ = sprockets.polygon_action(teeth, pitches)
    hold(checks)
    if teeth == (13, 13) and pitches == 16.5:  # the textbook's worst case, far above the bound
        assert checks[0].ours > 1.5e-3


@pytest.mark.parametrize(
    ("pretension", "speed"), [(100.0, 0.4), (400.0, 0.4), (200.0, 6.0)], ids=str
)
def test_a_tight_moving_strand_sounds_its_natural_frequencies(pretension, speed):
    """At 6 m/s the motion lowers the frequencies by a tenth."""
    hold(strands.moving_strand(pretension, speed))


@pytest.mark.parametrize("modes", [1, 4])
@pytest.mark.parametrize(("tension", "speed"), [(50.0, 0.0), (50.0, 5.0), (400.0, 12.0)])
def test_long_strands_have_the_frequencies_of_a_string(modes, tension, speed):
    """f_n = n / (2 L) (c^2 - v^2) / c, c^2 = T / mu; short ones are lower."""
    made = rc.catalogue_chain("ANSI 40", 100)
    density = 0.5 * (made.inner.mass + made.outer.mass) / made.pitch
    wave = math.sqrt(tension / density)
    for pitches, bound in ((2000.0, 1e-4), (200.0, 1e-2)):
        mode = np.arange(1, modes + 1)
        length = pitches * made.pitch
        string = mode / (2 * length) * (wave**2 - speed**2) / wave
        found = natural_frequencies(made, pitches, tension, speed, modes)
        np.testing.assert_allclose(found, string, rtol=bound)
    assert np.isnan(natural_frequencies(made, 20.0, tension, 1.01 * wave, 1)).all()
    assert np.isnan(natural_frequencies(made, 20.0, -1.0, 0.0, 1)).all()


@pytest.mark.parametrize("shape", strands.SHAPES)
@pytest.mark.parametrize("speed", [3.0, 12.0])
def test_centrifugal_tension_is_independent_of_shape(shape, speed):
    hold(strands.centrifugal(shape, speed))


@pytest.mark.parametrize("sprocket", [1, 2])
def test_forces_on_teeth_at_rest_are_the_tensioner_force(sprocket):
    """The recipe of docs/reference/outputs.md for the force on a shaft."""
    drive = rc.two_sprocket_drive("ANSI 40", (17, 25), links=60, speed=0.0, pretension=50.0)
    result = rc.Simulation(drive, start="static").run(1e-3, record=["teeth"], progress=False)
    data = result.to_xarray()
    on_teeth = -data["tooth_force_vector"].where(data["tooth_sprocket"] == sprocket, 0.0)
    along = on_teeth.sum("bushing").to_numpy()[0, 0] * (1.0 if sprocket == 1 else -1.0)
    assert along == pytest.approx(drive.check().tension_force, rel=1e-6)
