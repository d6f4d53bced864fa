"""The canvas of animations: artists that are moved from frame to frame, the rest drawn once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch, Polygon
from matplotlib.path import Path

from rustchain.plot.between_rows import forces_at, large_force, poses_at, round_number
from rustchain.plot.colors import INK, PAPER, in_theme
from rustchain.plot.looks import FORCE_COLORS, LOOKS
from rustchain.plot.shapes import Bar, Forces, Shape, force_points, outlines_at
from rustchain.plot.style import current_theme, styled
from rustchain.typing import Array

if TYPE_CHECKING:
    from rustchain.plot.animation import Animation

_SAMPLES = 24  # rows from which the view is chosen
_ARROW = 2.0  # length of the arrow of a large force, in sizes of a part
_LONGEST = 0.4  # of the scene: longer arrows of a single body would leave the view
THICKNESS = 0.16  # of arrows, in sizes of a part
_VIEW = 8.0  # width of a view that follows a body, in sizes of a part
_MARGIN = 0.6  # round all that moves, in sizes of a part
_TALLEST = 1.25  # height of a frame over its width
_HEAD, _FOOT = 44, 28  # [pixels] above and below the scene, for the scales and the time


def view_of(animation: Animation) -> tuple[Array, Array]:
    """Return the middle of the view, relative to the followed body, and its width and height."""
    result, shapes = animation.result, animation.shapes
    rows = np.linspace(animation.rows.start, animation.rows.stop - 1, _SAMPLES).astype(int)
    margin = _MARGIN * shapes.size
    if animation.camera == "scene":
        low, high = shapes.extent(result.array("positions")[rows])
        size = high - low + 2.0 * margin
        if animation.view is not None:
            size *= animation.view / size[0]
            size[1] = min(size[1], _TALLEST * size[0])
        return 0.5 * (low + high), size
    width = _VIEW * shapes.size if animation.view is None else animation.view
    if animation.view is None and animation.camera.startswith("sprocket_"):
        body = result.body_names.index(animation.camera)
        own = [s for s in shapes.outlines if isinstance(s, Shape) and s.bodies == (body,)]
        reach = max(float(np.hypot(*s.outline.T).max()) for s in own)
        return np.zeros(2), np.full(2, 2.0 * reach + 4.0 * margin)
    return np.zeros(2), np.array([width, 0.6 * width])


def arrow_scale(animation: Animation, large: float) -> float:
    """Return the length of an arrow for each newton [m/N], from a large force [N]."""
    if not large > 0.0:
        return 0.0
    _, size = view_of(animation.of_scene())
    return min(_ARROW * animation.shapes.size, _LONGEST * float(size.max())) / large


class Canvas:
    """A matplotlib canvas whose artists are moved from frame to frame, the rest drawn once."""

    def __init__(self, animation: Animation) -> None:
        self.animation = animation
        self.result = animation.result
        self.theme = current_theme()
        self.center, self.size = view_of(animation)
        self.follow = None
        if animation.camera != "scene":
            self.follow = self.result.body_names.index(animation.camera)
        large = large_force(self.result, animation.shapes.forces, animation.rows)
        self.force_shown = round_number(large)
        self.arrow = arrow_scale(animation, large)
        self._set_up()

    @styled
    def _set_up(self) -> None:
        """Make the figure with all artists, and keep what does not move as a background."""
        dpi, width = 100.0, 2 * (self.animation.width // 2)  # video codecs need even numbers
        tall = int(np.clip(width * self.size[1] / self.size[0], 0.25 * width, _TALLEST * width))
        height = 2 * ((tall + _HEAD + _FOOT) // 2)
        size = width / dpi, height / dpi
        self.figure = Figure(figsize=size, dpi=dpi, facecolor=in_theme(PAPER, self.theme))
        self.figure.set_layout_engine("none")
        self.canvas = cast("Any", FigureCanvasAgg(self.figure))  # which has no types
        self.axes = self.figure.add_axes(
            (0.0, _FOOT / height, 1.0, (height - _HEAD - _FOOT) / height)
        )
        self.axes.set_axis_off()
        pixels = np.array([width, height - _HEAD - _FOOT])
        half = 0.5 * pixels * (self.size / pixels).max()  # one scale for x and y
        self.axes.set(xlim=(-half[0], half[0]), ylim=(-half[1], half[1]))
        outlines = self.animation.shapes.outlines
        self.parts: list[tuple[list[Shape | Bar], PathPatch]] = []
        for kind, look in LOOKS[self.theme].items():
            for closed in (True, False):
                shapes = [s for s in outlines if s.kind == kind and s.closed == closed]
                if shapes:
                    filled = look.face is not None and closed
                    face = to_rgba(look.face or "none", look.opacity) if filled else "none"
                    width_of_line = 0.8 if closed else 1.2
                    patch = self._patch(_codes(shapes), face, look.edge, width_of_line)
                    self.parts.append((shapes, patch))
        self.arrows: list[tuple[Forces, PathPatch]] = []
        for group in self.animation.shapes.forces:
            color = FORCE_COLORS[self.theme][group.kind]
            one = [Path.MOVETO, *[Path.LINETO] * 6, Path.CLOSEPOLY]
            codes = np.tile(np.array(one, dtype=np.uint8), len(group.bodies))
            self.arrows.append((group, self._patch(codes, color, color, 0.4)))
        self._add_legend(width, height)
        self.clock = self.figure.text(
            10 / width, 8 / height, "", color=in_theme(INK, self.theme), va="bottom", fontsize=10.0
        )
        self.moving: list[Any] = [*(patch for _, patch in (*self.parts, *self.arrows)), self.clock]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.background = self.canvas.copy_from_bbox(self.figure.bbox)

    def _patch(self, codes: Any, face: Any, edge: str, width: float) -> PathPatch:  # noqa: ANN401
        """Add one patch for many outlines, whose points are set in every frame."""
        patch = PathPatch(
            Path(np.zeros((len(codes), 2)), codes),
            facecolor=face,
            edgecolor=edge,
            linewidth=width,
            joinstyle="round",
        )
        self.axes.add_artist(patch)
        return patch

    def _add_legend(self, width: int, height: int) -> None:
        """Draw the scale of lengths and an arrow of each kind with its force, at the top."""
        ink = in_theme(INK, self.theme)
        low, high = self.axes.get_xlim()
        pixels = width / (high - low)  # a metre
        line = height - 0.6 * _HEAD
        length = round_number(0.15 * (high - low))
        entries: list[tuple[float, str, str | None]] = [(length, _length_text(length), None)]
        for group, _ in self.arrows if self.arrow > 0.0 else ():
            text = f"{group.label} {self.force_shown:g} N"
            color = FORCE_COLORS[self.theme][group.kind]
            entries.append((self.arrow * self.force_shown, text, color))
        x = width - 14.0
        for metres, text, arrow in entries:
            drawn = self.figure.text(
                x / width, line / height, text, color=ink, va="center", ha="right", fontsize=8.5
            )
            x -= drawn.get_window_extent(self.canvas.get_renderer()).width + 8.0
            long = pixels * metres
            if arrow is None:
                ticks = [[-long, 4], [-long, -4], [-long, 0], [0, 0], [0, 4], [0, -4]]
                outline = np.array(ticks, dtype=float) + [x, line]
            else:
                outline = arrows(np.array([[x - long, line]]), np.array([[long, 0.0]]), 10.0)[:-1]
            self.figure.add_artist(
                Polygon(
                    outline / [width, height],
                    closed=arrow is not None,
                    fill=arrow is not None,
                    color=arrow or ink,
                    linewidth=0.4 if arrow else 1.0,
                )
            )
            x -= long + 22.0

    def draw(self, time: float) -> Array:
        """Return the frame at a time [s]."""
        poses = poses_at(self.result, np.array([time]))[0]
        shift = -self.center if self.follow is None else -poses[self.follow, :2] - self.center
        for shapes, patch in self.parts:
            points = [_points(shape, poses) for shape in shapes]
            _set_points(patch, np.concatenate(points) + shift)
        for group, patch in self.arrows:
            at = force_points(group, poses) + shift
            vectors = self.arrow * forces_at(self.result, group.array, np.array([time]))[0]
            _set_points(patch, arrows(at, vectors, THICKNESS * self.animation.shapes.size))
        slow = self.animation.slowdown
        times, word = (slow, "slower") if slow >= 1.0 else (1.0 / slow, "faster")
        speed = f"{times:.0f} times {word}" if times >= 100.0 else f"{times:.3g} times {word}"
        self.clock.set_text(f"t = {1e3 * time:.2f} ms, {speed}")
        self.canvas.restore_region(self.background)
        renderer = self.canvas.get_renderer()
        for artist in self.moving:
            artist.draw(renderer)
        frame: Array = np.asarray(self.canvas.buffer_rgba())[..., :3].copy()
        return frame


def _set_points(patch: PathPatch, points: Array) -> None:
    """Move a patch to points, as many as it has."""
    vertices: Any = patch.get_path().vertices
    vertices[:] = points


def _codes(shapes: list[Shape | Bar]) -> Any:  # noqa: ANN401
    """Return the codes of the outlines of shapes: move, lines, close."""
    codes: list[Any] = []
    for shape in shapes:
        outlines = outlines_at(shape, np.zeros((1 + max((0, *shape.bodies)), 3)))
        one = [Path.MOVETO, *[Path.LINETO] * (outlines.shape[1] - 1)]
        codes += [*one, *[Path.CLOSEPOLY] * shape.closed] * len(outlines)
    return np.array(codes, dtype=np.uint8)


def _points(shape: Shape | Bar, poses: Array) -> Array:
    """Return all points of outlines in a row; each closed one has its first point again."""
    outlines = outlines_at(shape, poses)
    if shape.closed:
        outlines = np.concatenate([outlines, outlines[:, :1]], axis=1)
    return outlines.reshape(-1, 2)


def arrows(at: Array, vectors: Array, width: float) -> Array:
    """Return arrows from points along vectors: seven points each, and the first again."""
    length = np.hypot(vectors[:, 0], vectors[:, 1])[:, None]
    along = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    head = np.minimum(2.4 * width, 0.6 * length)
    wide = np.where(length > 0.0, head / 2.4, 0.0)
    tail = at + along * (length - head)
    corners = [
        at + 0.3 * wide * across,
        tail + 0.3 * wide * across,
        tail + wide * across,
        at + along * length,
        tail - wide * across,
        tail - 0.3 * wide * across,
        at - 0.3 * wide * across,
        at + 0.3 * wide * across,
    ]
    found: Array = np.nan_to_num(np.stack(corners, axis=1).reshape(-1, 2))
    return found


def _length_text(length: float) -> str:
    return f"{1e3 * length:g} mm" if length < 1.0 else f"{length:g} m"
