"""Animations: frames between the rows, what is drawn, the files that are written."""

import stat
import time

import numpy as np
import pytest
from PIL import Image

import rustchain as rc
from rustchain.plot import between_rows, canvas, shapes
from rustchain.plot.animation import shapes_of
from rustchain.plot.looks import LOOKS

RECORD = ("hinges", "teeth", "sprockets", "bodies")
RESULT = rc.Simulation(rc.paper_drive(25.0)).run(duration=0.02, record=RECORD, progress=False)


def slider_crank():
    m = rc.Mechanism()
    m.add_body("crank", mass=0.3, inertia=6e-5, position=(0.025, 0.0, 0.0))
    m.add_body("rod", mass=0.21, inertia=2.5e-4, position=(0.11, 0.0, 0.0))
    m.add_body("slider", mass=0.14, inertia=1e-4, position=(0.17, 0.0, 0.0))
    m.add_revolute("bearing", "ground", "crank", at=(0.0, 0.0))
    m.add_revolute("crank pin", "crank", "rod", at=(0.05, 0.0))
    law = rc.SurfaceContact(rc.LankaraniNikravesh(), length=0.015)
    bore = {"bore_radius": 0.01, "pin_radius": 0.0099, "pin_point": (0.06, 0.0)}
    m.add_clearance_joint("wrist pin", "slider", "rod", law=law, **bore)
    m.add_prismatic("guide", "ground", "slider", direction=(1.0, 0.0))
    m.add_spring("spring", "ground", "slider", 100.0, point_a=(0.25, 0.0))
    m.add_driver("motor", "ground", "crank", speed=100.0)
    return m


def every(result, step):
    """The result with every so manieth row."""
    arrays = {name: values[::step] for name, values in result.arrays.items()}
    return type(result)(**vars(result) | {"arrays": arrays})


@pytest.mark.parametrize("bulge", [1.0, -1.0])
def test_a_profile_of_arcs_is_drawn_along_them(bulge):
    """Two half circles round the middle of two points, by a bulge of either sign."""
    m = rc.Mechanism()
    m.add_body("ball", mass=1.0, inertia=1e-3, position=(0.0, 0.5, 0.0))
    points = [(-0.2, 0.1), (0.2, 0.1)]
    law = rc.LinearContact(1e6)
    m.add_outline_contact("stop", "ground", "ball", points, 0.05, law, bulges=[bulge, bulge])
    (profile,) = (shape for shape in shapes_of(rc.Scene(m)).outlines if shape.kind == "profile")
    off = profile.outline - [0.0, 0.1]
    np.testing.assert_allclose(np.hypot(*off.T), 0.2, rtol=1e-12)
    turns = np.unwrap(np.arctan2(off[:, 1], off[:, 0]))
    assert turns[-1] - turns[0] == pytest.approx(bulge * 2.0 * np.pi)
    assert np.abs(np.diff(turns)).max() < 0.21


def test_a_part_of_one_row_has_no_animation(tmp_path):
    with pytest.raises(rc.InvalidInput, match="the result has one row; expected two or more"):
        RESULT.between(end=0.0).animate(tmp_path / "run.gif")


def test_between_the_rows_bodies_follow_a_cubic():
    """A crank that turns 0.1 rad a row: r phi^4/384 = 6.5e-9 m off at most; straight: 3e-5 m."""
    result = rc.Simulation(slider_crank()).run(5e-3, report_step=1e-3, progress=False)
    times = np.linspace(0.0, 5e-3, 101)
    crank = between_rows.poses_at(result, times)[:, 0]
    exact = 0.025 * np.stack([np.cos(100.0 * times), np.sin(100.0 * times)], axis=1)
    assert 1e-9 < np.abs(crank[:, :2] - exact).max() < 1e-8


def test_between_the_rows_of_an_impacting_chain_bodies_are_where_rows_left_out_have_them():
    found = between_rows.poses_at(every(RESULT, 4), RESULT.time)
    assert np.abs(found - RESULT.array("positions"))[:, :, :2].max() < 1e-5  # a tenth of a pixel


def test_forces_between_the_rows_are_linear_in_time():
    middle = 0.5 * (RESULT.time[150] + RESULT.time[151])
    force = RESULT.array("hinge_force_vector")
    found = between_rows.forces_at(RESULT, "hinge_force_vector", np.array([middle]))[0]
    np.testing.assert_allclose(found, 0.5 * (force[150] + force[151]), rtol=1e-9, atol=1e-9)


def test_an_arrow_is_as_long_as_its_force_and_none_where_there_is_none():
    at, force = np.array([[1.0, 2.0], [5.0, 5.0]]), np.array([[3.0, 4.0], [0.0, 0.0]])
    points = canvas.arrows(at, force, 0.2).reshape(2, -1, 2)
    np.testing.assert_allclose(points[0, 3], [4.0, 6.0])
    np.testing.assert_allclose(points[1], np.broadcast_to([5.0, 5.0], points[1].shape))


def test_forces_act_where_hinges_and_bushings_are():
    drawn = shapes_of(RESULT.scene)
    poses = RESULT.array("positions")[-1]
    hinges = shapes.force_points(drawn.forces[0], poses)
    following = poses[(np.arange(38) + 1) % 38]
    half = 0.5 * RESULT.drive.chain.pitch
    rear = following[:, :2] - half * np.stack(
        [np.cos(following[:, 2]), np.sin(following[:, 2])], axis=1
    )
    assert np.abs(hinges - rear).max() < 2.0 * RESULT.drive.chain.hinge.clearance


def test_the_first_contact_pulls_an_arrow_from_the_bushing_to_the_outside_of_the_tooth():
    """A tooth pushes a bushing away from the sprocket's centre, or along its circle."""
    force = RESULT.array("tooth_force_vector")[-1]
    wheel = RESULT.array("tooth_sprocket")[-1]
    poses = RESULT.array("positions")[-1]
    at = shapes.force_points(shapes_of(RESULT.scene).forces[1], poses)
    touching = np.hypot(*force.T) > 1.0
    assert touching.any()
    outward = at[touching] - poses[38 + wheel[touching] - 1, :2]
    assert (np.einsum("ij,ij->i", outward, force[touching]) > 0.0).all()


@pytest.mark.parametrize("camera", ["scene", "sprocket_2", "link_6"])
def test_the_body_that_the_camera_follows_stays_in_the_middle(camera):
    film = RESULT.animate(camera=camera, width=300)
    drawing = canvas.Canvas(film)
    middles = []
    for row in (20, 180):
        drawing.draw(RESULT.time[row])
        (parts, patch) = next(p for p in drawing.parts if p[0][0].kind == "sprocket")
        assert len(parts) == 2
        middles.append(patch.get_path().vertices.mean(axis=0))
    moved = np.hypot(*(middles[1] - middles[0]))
    link = np.hypot(*np.diff(RESULT.array("positions")[[20, 180], 5, :2], axis=0)[0])
    assert link > 1e-3
    expected = link if camera == "link_6" else 0.0
    assert abs(moved - expected) < 0.2e-3


def test_a_gif_has_its_frames_and_they_move(tmp_path):
    path = tmp_path / "run.gif"
    film = RESULT.animate(path, slow_motion=20.0, fps=20.0, width=300)
    assert film.frame_count == 8
    with Image.open(path) as image:
        assert image.n_frames == 8
        assert image.size[0] == 300
        assert image.info["duration"] == 50
        assert image.info["loop"] == 0
        frames = []
        for k in (0, 7):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB"), dtype=int))
    assert (np.abs(frames[1] - frames[0]).max(axis=2) > 60).mean() > 0.01


@pytest.mark.parametrize(
    ("fps", "delay", "frames"), [(15.0, 70, 6), (30.0, 30, 14), (60.0, 20, 20), (1e3, 20, 20)]
)
def test_a_gif_keeps_its_slow_motion_at_the_nearest_delay_it_can_have(tmp_path, fps, delay, frames):
    path = tmp_path / "run.gif"
    RESULT.animate(path, slow_motion=20.0, fps=fps, width=100)  # 20 ms in 0.4 s
    with Image.open(path) as image:
        assert image.info["duration"] == delay
        assert image.n_frames == frames
        assert image.n_frames * delay == pytest.approx(400, abs=delay)


def test_slow_motion_and_a_part_of_the_time_set_the_frames():
    film = RESULT.animate(start=0.005, end=0.015, slow_motion=100.0, fps=25.0)
    assert film.frame_count == 25
    assert film.times[0] == pytest.approx(0.005)
    assert np.diff(film.times) == pytest.approx(0.01 / 25)
    assert RESULT.animate().frame_count == 250  # ten seconds


def test_without_forces_recorded_or_wanted_there_are_no_arrows():
    assert RESULT.animate(forces=False).shapes.forces == ()
    bare = rc.Simulation(rc.paper_drive()).run(1e-3, record=("bodies",), progress=False)
    film = bare.animate(width=200)
    assert film.shapes.forces == ()
    assert next(film.frames()).shape[1:] == (200, 3)


@pytest.mark.parametrize("hinges", ["clearance", "ideal", None])
def test_mechanisms_are_drawn_from_what_is_attached_to_bodies(hinges, tmp_path):
    scene = slider_crank() if hinges is None else rc.paper_drive().to_mechanism(hinges=hinges)
    result = rc.Simulation(scene).run(2e-3, progress=False)
    film = result.animate(tmp_path / "run.gif", slow_motion=100.0, width=300)
    low, high = film.shapes.extent(result.array("positions")[-1])
    assert np.all(high - low < 0.4)
    frame = next(film.frames())
    assert (frame < 250).any(axis=2).mean() > 0.02


def test_an_open_chain_with_rollers_is_drawn():
    drive = rc.open_chain(
        "ISO 08B", [rc.AnchoredEnd((0.0, 0.0)), rc.LoadedEnd(5.0, arm=0.02)], 10, rollers="bodies"
    )
    result = rc.Simulation(drive).run(2e-3, record=RECORD, progress=False)
    kinds = {shape.kind for shape in result.animate().shapes.outlines}
    assert {"anchor", "load", "roller", "pin", "inner", "outer"} <= kinds
    assert next(result.animate(width=200).frames()).std() > 5.0


def test_every_kind_of_outline_has_a_look_in_both_themes():
    assert set(LOOKS["light"]) == set(LOOKS["dark"]) == set(shapes.Kind.__args__)


def test_without_bodies_the_remedy_is_told():
    result = rc.Simulation(rc.paper_drive()).run(1e-3, progress=False)
    with pytest.raises(rc.NotRecorded, match=r"record=\(.*'bodies'\)"):
        result.animate()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"camera": "sproket_1"}, "did you mean 'sprocket_1'"),
        ({"slow_motion": -1.0}, r"animate\(slow_motion\): got -1.0; expected a positive number"),
        ({"slow_motion": 1e6}, "makes 500000 frames; expected at most"),
        ({"width": 20}, "100 to 4000 pixels"),
        ({"start": 1.0}, "no rows there"),
        ({"path": "run.avi"}, "ends in '.avi'; expected .gif, .mp4 or .html"),
        ({"slowmotion": 3}, "slow_motion"),
    ],
)
def test_what_cannot_be_is_refused_with_what_is_expected(options, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises((rc.InvalidInput, TypeError), match=told):
        RESULT.animate(**options)
    assert not list(tmp_path.iterdir())


def test_without_ffmpeg_the_remedy_is_named(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(rc.MissingExtra, match=r"ffmpeg.*apt install ffmpeg.*\.gif or \.html"):
        RESULT.animate(tmp_path / "run.mp4")


def _program(folder, text):
    path = folder / "ffmpeg"
    path.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


def test_ffmpeg_is_given_every_frame(tmp_path, monkeypatch):
    """A program in its place keeps what it is given."""
    _program(tmp_path, 'for last; do :; done\necho "$@" > told\nexec cat > "$last"')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    film = RESULT.animate("run.mp4", slow_motion=10.0, width=200)
    frame = next(film.frames())
    assert (tmp_path / "run.mp4").stat().st_size == film.frame_count * frame.size
    height, width = frame.shape[:2]
    assert f"-s {width}x{height} -r 25" in (tmp_path / "told").read_text(encoding="utf-8")
    assert height % 2 == width % 2 == 0  # as the codec needs


def test_what_ffmpeg_says_is_told(tmp_path, monkeypatch):
    _program(tmp_path, "echo 'no such codec' >&2\nexit 3")
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(OSError, match="code 3: no such codec"):
        RESULT.animate(tmp_path / "run.mp4", slow_motion=10.0, width=200)


@pytest.mark.slow
def test_a_frame_takes_less_than_a_third_of_the_time_of_a_film_of_one(tmp_path):
    def film(frames):
        start = time.process_time()
        made = RESULT.animate(tmp_path / "run.gif", slow_motion=frames / 25 / 0.02)
        assert made.frame_count == frames
        return time.process_time() - start

    film(1)  # which loads the libraries
    assert film(300) < 100 * min(film(1), film(1))


def test_a_view_has_its_width_where_the_scene_is_tall():
    drive = rc.open_chain("ANSI 40", (rc.AnchoredEnd((0.0, 0.0)), rc.FreeEnd()), links=30)
    result = rc.Simulation(drive).run(1e-3, record=("bodies",), progress=False)
    left, right = canvas.Canvas(result.animate(view=0.1)).axes.get_xlim()
    assert right - left == pytest.approx(0.1, rel=0.01)  # frames have whole pixels


def test_a_large_force_on_a_single_body_is_inside_the_view():
    m = rc.Mechanism()
    m.add_body("rotor", mass=0.5, inertia=2e-3)
    m.add_revolute("bearing", "ground", "rotor")
    animation = rc.Simulation(m).run(1e-2, progress=False).animate()
    drawn = canvas.Canvas(animation)
    assert drawn.arrow * 0.5 * 9.81 < 0.5 * drawn.size.min()  # from the middle


def test_the_slow_motion_is_told_in_digits():
    drawn = canvas.Canvas(RESULT.animate(slow_motion=5000.0))
    drawn.draw(0.01)
    assert drawn.clock.get_text() == "t = 10.00 ms, 5000 times slower"


def test_points_of_a_body_turn_counterclockwise_with_it():
    poses = np.array([[1.0, 2.0, np.pi / 2], [0.0, 0.0, np.pi]])
    corner = np.array([[3.0, 0.5]])
    expected = [[0.5, 5.0], [-3.0, -0.5]]
    np.testing.assert_allclose(shapes.placed(poses, corner)[:, 0], expected, atol=1e-12)
    forces = shapes.Forces("hinge", "hinge_force_vector", (0, 1), np.repeat(corner, 2, axis=0))
    np.testing.assert_allclose(shapes.force_points(forces, poses), expected, atol=1e-12)
