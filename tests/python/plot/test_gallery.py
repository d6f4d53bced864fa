"""The pictures of the gallery are drawn again and compared with those that were looked at."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

PATH = Path(__file__).parents[3] / "docs" / "reference" / "gallery_page.py"
_SPEC = importlib.util.spec_from_file_location("gallery_page", PATH)
gallery = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(gallery)

# Root mean square of the difference of two pictures, 0 to 255. A curve drawn elsewhere in the range
# of its scatter gives up to 8, a missing legend or label of an axis more in its own tile.
WHOLE, TILE = 10.0, 70.0
REMEDY = "look at it; if it is right, run docs/reference/gallery_page.py"


def difference(one, other):
    """Root mean squares over the picture, and over the worst of tiles of 60 pixels."""
    squares = ((one.astype(float) - other.astype(float)) ** 2).mean(axis=2)
    height, width = (60 * (n // 60) for n in squares.shape)
    tiles = squares[:height, :width].reshape(height // 60, 60, width // 60, 60).mean(axis=(1, 3))
    return np.sqrt(squares.mean()), np.sqrt(tiles.max())


@pytest.mark.slow
@pytest.mark.parametrize("group", gallery.GROUPS)
def test_pictures_are_as_they_were_when_looked_at(group, tmp_path):
    page = gallery.PAGE.read_text(encoding="utf-8")
    for call, draw in gallery.GROUPS[group]().items():
        name = gallery.name_of(call)
        assert f"(../images/gallery/{name})" in page
        draw().savefig(tmp_path / name, dpi=gallery.DPI)
        pictures = [
            np.asarray(Image.open(folder / name).convert("RGB"))
            for folder in (tmp_path, gallery.IMAGES)
        ]
        assert pictures[0].shape == pictures[1].shape, f"{name}: {REMEDY}"
        whole, tile = difference(*pictures)
        assert whole < WHOLE, f"{name}: {whole:.1f}; {REMEDY}"
        assert tile < TILE, f"{name}: {tile:.1f} in a tile; {REMEDY}"


def test_a_picture_without_its_legend_is_told_apart():
    """The measure of difference sees what a reader would miss."""
    picture = np.asarray(Image.open(gallery.IMAGES / "tension.png").convert("RGB")).copy()
    without = picture.copy()
    without[:30] = 255
    assert difference(picture, picture) == (0.0, 0.0)
    assert difference(picture, without)[0] > WHOLE
    moved = np.roll(picture, 18, axis=1)
    assert difference(picture, moved)[0] > WHOLE


def test_every_picture_is_on_the_page():
    page = gallery.PAGE.read_text(encoding="utf-8")
    for path in gallery.IMAGES.iterdir():
        assert f"(../images/gallery/{path.name})" in page
