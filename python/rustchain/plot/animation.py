"""Animations of a result: frames drawn from the recorded bodies, written as GIF, MP4 or HTML."""

from __future__ import annotations

import math
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rustchain.analysis.window import rows_between
from rustchain.arguments import shown
from rustchain.description.mechanism.builder import Mechanism
from rustchain.description.scene import Scene
from rustchain.errors import InvalidInput, MissingExtra
from rustchain.names import suggest
from rustchain.paths import check_writable, path_of, write_whole
from rustchain.plot.canvas import Canvas
from rustchain.plot.drive_shapes import shapes_of_drive
from rustchain.plot.mechanism_shapes import shapes_of_mechanism
from rustchain.plot.shapes import Forces, Shapes
from rustchain.typing import Array, FilePath, Time

if TYPE_CHECKING:
    from rustchain.results.result import Result

_SECONDS = 10.0  # that an animation lasts, unless slow motion is given
_FRAMES = 20_000  # more are refused: thirteen minutes at 25 a second
_FORMS = (".gif", ".mp4", ".html")
_LEAST_OF_GIF = 100.0 / 65535.0  # frames a second: delays are 16 bits of hundredths
_COLORS = 96  # of a GIF; with twice as many it is a fifth larger and looks the same


def shapes_of(scene: Scene) -> Shapes:
    """Return the shapes of a drive or of a mechanism."""
    if isinstance(scene.system, Mechanism):
        return shapes_of_mechanism(scene.system)
    return shapes_of_drive(scene.system)


def check_options(
    bodies: Sequence[str],
    camera: str,
    slow_motion: float | None,
    fps: float,
    view: float | None,
    width: int,
) -> None:
    """Refuse options of an animation of these bodies that are out of their ranges."""
    names = ("scene", *bodies)
    if camera not in names:
        msg = (
            f"animate(camera): got {shown(camera)}; expected 'scene' or the name of a "
            f"body; {suggest(camera, names)}"
        )
        raise InvalidInput(msg)
    for name, value in (("slow_motion", slow_motion), ("fps", fps), ("view", view)):
        if value is not None and not 0.0 < value < math.inf:
            msg = f"animate({name}): got {shown(value)}; expected a positive number"
            raise InvalidInput(msg)
    if not 100 <= width <= 4000:
        msg = f"animate(width): got {shown(width)}; expected 100 to 4000 pixels"
        raise InvalidInput(msg)


def check_file(path: Path, fps: float) -> None:
    """Refuse a file that cannot be made of an animation with so many frames a second."""
    form = path.suffix.lower()
    if form not in _FORMS:
        msg = f"path = {str(path)!r}: ends in {form!r}; expected .gif, .mp4 or .html"
        raise InvalidInput(msg)
    if form == ".gif" and fps < _LEAST_OF_GIF:
        msg = f"animate(fps): got {shown(fps)}; a GIF has at least {_LEAST_OF_GIF:.3g} a second"
        raise InvalidInput(msg)
    if form == ".mp4" and shutil.which("ffmpeg") is None:
        msg = (
            "ffmpeg is not installed, which .mp4 needs: apt install ffmpeg, brew install ffmpeg or "
            "conda install ffmpeg; or name a .gif or .html"
        )
        raise MissingExtra(msg, name="ffmpeg")


@dataclass(frozen=True)
class Animation:
    """The motion that a result recorded, as frames; shows the player in a notebook.

    Attributes
    ----------
    result : Result
        What is shown. Its bodies must be recorded.
    start, end : float, optional
        Part of the time [s].
    slow_motion : float, optional
        Seconds of animation for one of simulation; by default such that it lasts ten seconds.
    fps : float
        Frames a second.
    camera : str
        "scene", or the name of the body that stays in the middle.
    view : float, optional
        Width of the view [m]; by default the whole scene, or eight pitches about a body.
    forces : bool
        Whether contact forces and joint reactions are drawn as arrows.
    width : int
        Width of a frame [pixels].
    """

    result: Result
    start: Time = None
    end: Time = None
    slow_motion: float | None = None
    fps: float = 25.0
    camera: str = "scene"
    view: float | None = None
    forces: bool = True
    width: int = 900
    rows: slice = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the options."""
        self.result.array("positions")
        object.__setattr__(self, "rows", rows_between(self.result, self.start, self.end))
        check_options(
            self.result.body_names, self.camera, self.slow_motion, self.fps, self.view, self.width
        )
        if self._frames > _FRAMES:
            msg = (
                f"animate(): makes {self._frames:.6g} frames; expected at most {_FRAMES}; give a "
                "smaller slow_motion or a shorter part by start and end"
            )
            raise InvalidInput(msg)

    @property
    def slowdown(self) -> float:
        """Seconds of animation for one of simulation."""
        span = self._span
        if self.slow_motion is not None:
            return self.slow_motion
        return _SECONDS / span if span > 0.0 else 1.0

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return max(1, math.ceil(self._frames - 1e-9))

    @property
    def times(self) -> Array:
        """Time of each frame [s]."""
        first = self.result.time[self.rows.start]
        steps: Array = first + np.arange(self.frame_count) / (self.fps * self.slowdown)
        last = float(self.result.time[self.rows.stop - 1])
        return np.minimum(steps, last)

    @property
    def _frames(self) -> float:
        return self._span * self.slowdown * self.fps

    @property
    def _span(self) -> float:
        time = self.result.time[self.rows]
        return float(time[-1] - time[0])

    @cached_property
    def shapes(self) -> Shapes:
        """Outlines of the scene, with those groups of forces that were recorded."""
        found = shapes_of(self.result.scene)
        there = [each for each in found.forces if self.forces and self._recorded(each)]
        return Shapes(found.outlines, tuple(there), found.size)

    def of_scene(self) -> Animation:
        """Return the same with the whole scene in view."""
        return replace(self, camera="scene", view=None)

    def _recorded(self, forces: Forces) -> bool:
        array = self.result.arrays.get(forces.array)
        return array is not None and array.shape[1] == len(forces.bodies)

    def save(self, path: FilePath) -> None:
        """Write a GIF, an MP4 video or a page with the player, as the name ends.

        Raises
        ------
        InvalidInput
            The name ends in something else.
        MissingExtra
            matplotlib is missing, or of ".mp4" the program ffmpeg.
        OSError
            The file cannot be written.
        """
        where = path_of(path)
        check_file(where, self.fps)
        check_writable(where)
        form = where.suffix.lower()
        if form == ".html":
            from rustchain.plot.player import player_page

            write_whole(where, player_page(self).encode())
        elif form == ".gif":
            write_whole(where, _gif(self))
        else:
            write_whole(where, _mp4(self))

    def _repr_html_(self) -> str:
        """Return the player for a notebook."""
        from rustchain.plot.player import player_frame

        return player_frame(self)

    def frames(self, rows: Array | None = None) -> Iterator[Array]:
        """Yield the frames, (height, width, 3) of 8 bits; those of `rows` alone where given."""
        canvas = Canvas(self)
        times = self.times if rows is None else self.times[rows]
        for time in times:
            yield canvas.draw(float(time))


def _gif(animation: Animation) -> bytes:
    """Return the frames as a GIF that repeats; all frames share the colours of some."""
    from PIL import Image

    # Delays of a GIF are hundredths of a second; no viewer shows less than two.
    delay = 10 * max(2, round(100.0 / animation.fps))
    animation = replace(animation, fps=1000.0 / delay)
    count = animation.frame_count
    picked = np.unique(np.linspace(0, count - 1, 5).astype(int))
    sample = np.concatenate(list(animation.frames(picked)))
    palette = Image.fromarray(sample).quantize(_COLORS, Image.Quantize.MEDIANCUT)
    # The nearest of these colours for each of 32^3, which is quicker to look up than to search.
    steps = np.rint(np.linspace(0.0, 255.0, 32)).astype(np.uint8)
    cube = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(32, -1, 3)
    nearest = Image.fromarray(cube).quantize(palette=palette, dither=Image.Dither.NONE)
    table = np.asarray(nearest).ravel()
    colors = np.array(palette.getpalette()).reshape(-1, 3)

    def entries(frame: Array) -> Array:
        red, green, blue = np.right_shift(frame, 3).astype(np.int32).transpose(2, 0, 1)
        found: Array = table[(red << 10) | (green << 5) | blue]
        return found

    corner = sample[-1:, -1:]
    colors[entries(corner)] = corner  # the ground, not the mean of colours near it

    def image_of(frame: Array) -> Image.Image:
        image = Image.fromarray(entries(frame), "P")
        image.putpalette(colors.ravel().tolist())
        return image

    images = map(image_of, animation.frames())
    file = BytesIO()
    next(images).save(
        file, "GIF", save_all=True, append_images=images, duration=delay, loop=0, optimize=False
    )
    return file.getvalue()


def _mp4(animation: Animation) -> bytes:
    """Return the frames as an MP4 video for browsers and presentations."""
    frames = animation.frames()
    first = next(frames)
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "film.mp4"
        command = [
            "ffmpeg", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{first.shape[1]}x{first.shape[0]}", "-r", f"{animation.fps:g}", "-i", "-",
            "-an", "-vcodec", "libx264", "-crf", "20", "-pix_fmt", "yuv420p",
            "-movflags", "+faststart", str(target),
        ]  # fmt: skip
        with tempfile.TemporaryFile() as told:
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=told)
            assert process.stdin is not None
            try:
                with process.stdin as pipe:
                    pipe.write(first.tobytes())
                    for frame in frames:
                        pipe.write(frame.tobytes())
            except BrokenPipeError:
                pass  # it says why below
            except BaseException:
                process.kill()
                process.wait()
                raise
            if process.wait() != 0:
                told.seek(0)
                reason = told.read().decode(errors="replace").strip().splitlines()[-1:]
                msg = f"ffmpeg ended with code {process.returncode}: {' '.join(reason)}"
                raise OSError(msg)
        return target.read_bytes()
