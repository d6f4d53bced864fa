"""Colours: told apart by everyone, and with a counterpart on a dark ground."""

from io import BytesIO
from itertools import combinations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from PIL import Image

import rustchain as rc
from rustchain.plot import colors, use_theme
from rustchain.plot.picture import draw_mechanism

# Machado, Oliveira and Fernandes (2009), severity 1; linear sRGB.
SIGHT = {
    "all": np.eye(3),
    "no red": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no green": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "no blue": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
RESULT = rc.Simulation(rc.paper_drive(25.0)).run(
    duration=0.01, record=("hinges", "teeth", "sprockets", "bodies", "energy"), progress=False
)


def linear(color):
    rgb = np.array(to_rgb(color))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """CIE 1976 L*a*b* of linear sRGB under D65."""
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    x, y, z = xyz @ np.clip(rgb, 0.0, 1.0) / np.array([0.9505, 1.0, 1.089])
    f, g, h = (np.cbrt(t) if t > 0.008856 else 7.787 * t + 16 / 116 for t in (x, y, z))
    return np.array([116 * g - 16, 500 * (f - g), 200 * (g - h)])


def apart(some, sight):
    seen = [lab(np.array(SIGHT[sight]) @ linear(color)) for color in some]
    return min(np.hypot.reduce(one - other) for one, other in combinations(seen, 2))


def contrast(color, ground):
    one, other = (np.array([0.2126, 0.7152, 0.0722]) @ linear(c) + 0.05 for c in (color, ground))
    return max(one, other) / min(one, other)


@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize(("theme", "least"), [("light", 15.0), ("dark", 10.0)])
def test_the_colours_of_curves_are_told_apart_by_everyone(theme, least, sight):
    cycle = [colors.in_theme(color, theme) for color in colors.CYCLE]
    assert apart(cycle, sight) > least
    if theme == "light":
        assert apart([*cycle[:4], colors.GREY], sight) > least


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_curves_and_text_stand_out_from_the_ground(theme):
    ground = colors.in_theme(colors.PAPER, theme)
    for color in colors.CYCLE:
        assert contrast(colors.in_theme(color, theme), ground) > 3.0
    assert contrast(colors.in_theme(colors.INK, theme), ground) > 12.0
    assert contrast(colors.in_theme(colors.GREY, theme), ground) > 3.9


@pytest.fixture
def _dark():
    use_theme("dark")
    yield
    use_theme("light")


@pytest.mark.usefixtures("_dark")
@pytest.mark.parametrize(
    "draw",
    [
        lambda plot: plot.drive(),
        lambda plot: plot.tension(),
        lambda plot: plot.orbit(6),
        lambda plot: plot.tooth_force(6),
        lambda plot: plot.polar_tooth_loads(1),
        lambda plot: plot.power_balance(),
    ],
)
def test_a_dark_figure_is_dark_with_bright_text(draw):
    figure = draw(RESULT.plot)
    assert np.allclose(figure.get_facecolor()[:3], to_rgb("#14181d"))
    image = np.asarray(Image.open(BytesIO(figure._repr_png_())).convert("RGB"))
    assert np.median(image) < 60
    for text in (text for axes in figure.axes for text in axes.texts):
        assert contrast(text.get_color(), "#14181d") > 3.0


def test_an_animation_has_the_theme_in_which_it_is_saved(tmp_path):
    record = ("hinges", "teeth", "bodies")
    result = rc.Simulation(rc.paper_drive(25.0)).run(1e-3, record=record, progress=False)
    film = result.animate(slow_motion=100.0, width=300)
    grounds = {"light": colors.PAPER, "dark": colors.in_theme(colors.PAPER, "dark")}
    for theme, ground in grounds.items():
        use_theme(theme)
        try:
            film.save(tmp_path / "run.gif")
            frame = next(film.frames())
        finally:
            use_theme("light")
        with Image.open(tmp_path / "run.gif") as saved:
            image = np.asarray(saved.convert("RGB"))
        expected = 255.0 * np.array(to_rgb(ground))
        for drawn in (frame, image):
            assert np.allclose(np.median(drawn, axis=(0, 1)), expected)
            assert np.ptp(drawn.mean(axis=2)) > 150.0  # text and outlines stand out


@pytest.mark.usefixtures("_dark")
def test_the_picture_of_a_mechanism_has_the_theme_and_the_style_of_all_figures():
    mechanism = rc.Mechanism()
    mechanism.add_body("bar", mass=1.0, inertia=0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", at=(0.0, 0.0))
    figure = draw_mechanism(mechanism, np.array([[0.5, 0.0, 0.0]]))
    assert np.allclose(figure.get_facecolor()[:3], to_rgb("#14181d"))
    assert figure.dpi == RESULT.plot.drive().dpi


@pytest.mark.usefixtures("_dark")
def test_given_axes_keep_their_ground():
    figure = Figure()
    RESULT.plot.tension(ax=figure.subplots())
    assert figure.get_facecolor()[:3] == (1.0, 1.0, 1.0)


def test_another_theme_is_refused():
    with pytest.raises(rc.InvalidInput, match="'light' or 'dark'"):
        use_theme("night")
