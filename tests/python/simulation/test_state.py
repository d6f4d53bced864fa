"""A state is complete: whoever takes it over goes on to the same bits, in another process too."""

import copy
import errno
import functools
import json
import pickle
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rustchain as rc
from cores import CoreAround, cores_within

ALL = ("hinges", "teeth", "sprockets", "bodies", "energy")
REST = 1e-3  # [s]
LAWS = {
    "lankarani-nikravesh": rc.LankaraniNikravesh(),
    "johnson": rc.Johnson(damping="lankarani-nikravesh"),
    "enhanced-cylinder": rc.EnhancedCylinder(regions="sharp"),
}

# Goes on in a process of its own with nothing but the file, and leaves what came of it in another.
CHILD = """
import sys
import numpy as np
import rustchain as rc

loaded, left, duration, energy = sys.argv[1:]
simulation = rc.Simulation.load_state(loaded)
result = simulation.run(float(duration), 1e-5, record=("hinges", "teeth", "sprockets", "bodies"),
                        energy=energy == "True", progress=False)
simulation.save_state(left)
np.savez(left + ".rows", **result.arrays)
"""


def assert_same_state(one, other):
    assert one.keys() == other.keys()
    for key, value in one.items():
        np.testing.assert_array_equal(value, other[key], err_msg=key, strict=True)
    assert one["snapshot"] == other["snapshot"]


def assert_same_rows(one, other):
    assert one.keys() == set(other)
    for key, value in one.items():
        np.testing.assert_array_equal(value, other[key], err_msg=key, strict=True)


def assert_goes_on_alike(one, other, duration=REST, energy=True):
    rows = [s.run(duration, 1e-5, record=ALL, energy=energy, progress=False) for s in (one, other)]
    assert_same_rows(rows[0].arrays, rows[1].arrays)
    assert_same_state(one.state(), other.state())


@pytest.fixture(scope="module")
def under_way():
    """The paper's drive with 25 N after the first contacts, inside a step; not to be moved."""
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.run(5e-3, progress=False)
    return simulation


@pytest.fixture(scope="module")
def file(under_way, tmp_path_factory):
    path = tmp_path_factory.mktemp("state") / "under_way.npz"
    under_way.save_state(path)
    return path


# --- the rest is the same


@pytest.mark.parametrize("energy", [False, True])
@pytest.mark.parametrize("pretension", [0.0, 25.0])
@pytest.mark.parametrize("law", LAWS)
def test_a_new_process_goes_on_to_the_same_bits(law, pretension, energy, tmp_path):
    simulation = rc.Simulation(
        rc.paper_drive(pretension=pretension),
        LAWS[law],
        hinge_law=rc.Hertz(),
        solver=rc.Solver(rtol=2e-5, atol=1e-5),
        min_impact_velocity=2e-3,
    )
    simulation.run(4.5e-3, 1e-3, energy=energy, progress=False)
    simulation.step_to(5.000_001e-3)  # inside a step
    saved, left = tmp_path / "state", tmp_path / "left"
    simulation.save_state(saved)
    child = subprocess.run(
        [sys.executable, "-W", "error", "-c", CHILD, saved, left, str(REST), str(energy)],
        capture_output=True,
        text=True,
    )
    assert child.returncode == 0, child.stderr
    result = simulation.run(REST, 1e-5, record=ALL, energy=energy, progress=False)
    assert simulation.stats["onsets"] > 0
    assert_same_rows(result.arrays, np.load(f"{left}.rows.npz"))
    loaded = rc.Simulation.load_state(left)
    assert_same_state(loaded.state(), simulation.state())
    for name in ("drive", "hinge_law", "tooth_law", "solver", "min_impact_velocity"):
        assert getattr(loaded, name) == getattr(simulation, name)


@functools.cache
def line():
    """One run to hand over, and where it ends."""
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.step_to(8e-3)
    return simulation.state()


@settings(max_examples=25)
@given(stops=st.lists(st.floats(0.0, 8e-3), max_size=4).map(sorted))
def test_wherever_it_is_handed_over_the_run_stays_the_same(stops):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    for stop in stops:
        simulation.step_to(stop)
        follower = rc.Simulation(rc.paper_drive(pretension=25.0))
        follower.set_state(simulation.state())
        assert follower.time == stop
        simulation = follower
    simulation.step_to(8e-3)
    assert_same_state(simulation.state(), line())


@pytest.mark.parametrize("change", ["onsets", "partings"])
def test_at_an_onset_and_after_a_parting_the_run_goes_on_alike(change):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.step_to(4e-3)
    seen = 0
    while simulation.time < 6e-3:
        t = simulation.time + 5e-7
        before = simulation.stats["onsets"]
        simulation.step_to(t)
        state = simulation.state()
        if change == "onsets":
            happened = simulation.stats["onsets"] > before
        else:
            happened = state["ended_hinges"].size or state["ended_tooth_pairs"].size
        if happened:
            seen += 1
            follower = rc.Simulation(rc.paper_drive(pretension=25.0))
            follower.set_state(state)
            follower.step_to(t + 2e-5)
            simulation.step_to(t + 2e-5)
            assert_same_state(follower.state(), simulation.state())
            if seen == 5:
                return
    pytest.fail(f"{seen} {change} seen")


def test_a_state_before_the_first_step_is_a_state():
    one, other = (rc.Simulation(rc.paper_drive()) for _ in range(2))
    one.step_to(1e-3)
    one.set_state(other.state())
    assert one.time == 0.0
    assert_goes_on_alike(one, other, 5e-3)


@pytest.mark.parametrize("name", ["run.nc", "state.toml", "state.NPY"])
def test_a_state_is_refused_under_the_name_of_another_kind_of_file(name, tmp_path):
    simulation = rc.Simulation(rc.paper_drive())
    path = tmp_path / name
    says = rf"ends in '{path.suffix}'; states are NumPy archives: .*; take {path.stem}\.npz$"
    with pytest.raises(rc.InvalidInput, match=says):
        simulation.save_state(path)
    assert not path.exists()
    for name in ("state", "state.NPZ", "at_25.5"):
        simulation.save_state(tmp_path / name)
        assert rc.Simulation.load_state(tmp_path / name).time == 0.0


class Interrupted(CoreAround):
    """A core that is interrupted after 800 slices without wall time, of a row or a few steps."""

    finished = ()

    def advance(self, budget):
        if self.finished:
            return self.core.advance(budget)
        # The machine does not decide the end.
        self.finished = [self.core.advance(0.0) for _ in range(800)]
        raise KeyboardInterrupt


def test_after_an_interrupted_run_the_state_goes_on_alike(tmp_path):
    with cores_within(Interrupted) as made:
        simulation = rc.Simulation(rc.paper_drive())
    result = simulation.run(5.0, 1e-5, progress=False)
    assert not any(made[0].finished)
    assert simulation.stats["onsets"] > 0
    assert result.status == "interrupted"
    simulation.save_state(tmp_path / "interrupted.npz")
    assert_goes_on_alike(rc.Simulation.load_state(tmp_path / "interrupted.npz"), simulation)


def test_after_a_failed_run_the_state_fails_alike(tmp_path):
    # So hard that no step can follow the first contact.
    drive = rc.paper_drive()
    chain = replace(drive.chain, material=rc.Material(elastic_modulus=1e300))
    simulation = rc.Simulation(replace(drive, chain=chain))
    with pytest.raises(rc.SimulationError):
        simulation.step_to(0.01)
    simulation.save_state(tmp_path / "failed.npz")
    loaded = rc.Simulation.load_state(tmp_path / "failed.npz")
    assert_same_state(loaded.state(), simulation.state())
    said = []
    for one in (simulation, loaded):
        with pytest.raises(rc.SimulationError) as caught:
            one.run(0.01, progress=False)
        said.append(str(caught.value))
    assert said[0] == said[1]
    assert_same_state(loaded.state(), simulation.state())


def test_a_start_of_ones_own_is_in_the_file(tmp_path):
    calm = rc.Simulation(rc.paper_drive())
    velocities = calm.velocities.copy()
    velocities[:38] += [0.1, -0.05, 0.0]
    simulation = rc.Simulation(rc.paper_drive(), positions=calm.positions, velocities=velocities)
    simulation.step_to(2e-3)
    simulation.save_state(tmp_path / "own.npz")
    assert_goes_on_alike(rc.Simulation.load_state(tmp_path / "own.npz"), simulation)


def test_counts_go_on_and_wall_times_begin(under_way, file):
    loaded = rc.Simulation.load_state(file)
    counts, own = loaded.stats, under_way.stats
    for name in ("steps", "rejected", "evaluations", "onsets", "onsets_at_minimum_velocity"):
        assert counts[name] == own[name]
    assert min(counts["steps"], counts["rejected"], counts["onsets"]) > 0
    assert counts["wall_stepping"] == 0.0
    stats = loaded.run(1e-4, progress=False).stats
    assert 0 < stats["steps"] < own["steps"]


def test_a_law_past_its_end_is_said_once_to_each_who_goes_on(tmp_path):
    soft = replace(rc.paper_drive().chain, material=rc.Material(elastic_modulus=1e6))
    simulation = rc.Simulation(replace(rc.paper_drive(), chain=soft), rc.Johnson())
    with pytest.warns(rc.RangeWarning) as said:
        simulation.step_to(0.02)
    messages = {str(warning.message) for warning in said}
    assert len(messages) == 2  # a hinge and a tooth
    assert all("past the end" in message for message in messages)
    simulation.save_state(tmp_path / "past.npz")
    simulation.set_state(simulation.state())  # says nothing: a warning is an error here
    with pytest.warns(rc.RangeWarning) as again:
        loaded = rc.Simulation.load_state(tmp_path / "past.npz")
    assert {str(warning.message) for warning in again} == messages
    assert {warning.filename for warning in again} == {__file__}
    loaded.set_state(simulation.state())


# --- the dict


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda state: pickle.loads(pickle.dumps(state))]
)
def test_a_copy_of_a_state_is_as_good(copied, under_way):
    state = copied(under_way.state())
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.set_state(state)
    assert_same_state(simulation.state(), under_way.state())


def test_a_state_is_the_users_own(under_way):
    kept = under_way.state()
    mine = under_way.state()
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    simulation.set_state(mine)
    for value in mine.values():
        if isinstance(value, np.ndarray):
            value[...] = 1
    mine["snapshot"] = b""
    for one in (under_way, simulation):
        assert_same_state(one.state(), kept)


def test_an_input_that_is_set_after_a_state_goes_back_without_a_standstill():
    mechanism = rc.Mechanism(gravity=(0.0, 0.0))
    mechanism.add_body("wheel", 1.0, 0.5)
    mechanism.add_revolute("axle", "ground", "wheel")
    mechanism.add_torque("load", "wheel", torque=0.1)
    solver = rc.Solver(method="pece", rtol=1e-9, atol=1e-9, max_step=1.0)
    simulation = rc.Simulation(mechanism, solver=solver)
    simulation.step_to(9.3)  # the integrator is half a second ahead
    simulation.set_state(simulation.state())
    simulation.set_torque("load", rc.Sines([(1.0, 3e5, 0.0)]))
    # More than 1e5 steps, in which the mean step size is taken.
    simulation.step_to(9.9)
    assert simulation.stats["steps"] > 1e5


def test_a_state_does_not_move_on_with_its_simulation():
    simulation = rc.Simulation(rc.paper_drive())
    simulation.step_to(4e-3)
    state = simulation.state()
    kept = copy.deepcopy(state)
    simulation.step_to(6e-3)
    assert_same_state(state, kept)
    end = simulation.state()
    simulation.set_state(state)
    assert simulation.time == 4e-3
    simulation.step_to(6e-3)
    assert_same_state(simulation.state(), end)


# --- what is refused


def refusal(simulation, state):
    """What set_state says; the simulation must be what it was."""
    before = simulation.state()
    with pytest.raises(rc.InvalidInput) as caught:
        simulation.set_state(state)
    assert_same_state(simulation.state(), before)
    return str(caught.value)


PAPER = rc.paper_drive(pretension=25.0)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda: rc.Simulation(rc.paper_drive(pretension=26.0)), "state, drive = model"),
        (
            lambda: rc.Simulation(PAPER, rc.Hertz()),
            "state, hinge law = .*: the simulation has hertz",
        ),
        (lambda: rc.Simulation(PAPER, rc.Johnson()), "state, hinge law = .*: the simulation has"),
        (lambda: rc.Simulation(PAPER, min_impact_velocity=2e-3), "state, min_impact_velocity = "),
        (lambda: rc.Simulation(PAPER, solver=rc.Solver(rtol=1e-6)), "state, Solver.rtol = "),
        (
            lambda: rc.Simulation(PAPER, solver=rc.Solver(accuracy=1e-9)),
            "state, Solver.accuracy = 1e-10: the simulation has 1e-9: make",
        ),
        (lambda: rc.Simulation(PAPER, solver=rc.Solver(max_order=5)), "state, Solver.max_order"),
        (
            lambda: rc.Simulation(rc.two_sprocket_drive("ANSI 40", (17, 25), links=60)),
            "state, links = 38: the simulation has 60: make the simulation with the drive",
        ),
        (
            lambda: rc.Simulation(rc.two_sprocket_drive("ANSI 40", (16, 18), links=38)),
            r"state, teeth = \[17, 17\]: the simulation has \[16, 18\]",
        ),
    ],
)
def test_a_state_of_another_scene_is_refused_with_what_differs(made, said, under_way):
    simulation = made()
    simulation.step_to(1e-4)
    message = refusal(simulation, under_way.state())
    assert re.search(said, message), message


@pytest.mark.parametrize("value", [None, 1, [], {}, b"", {"snapshot": "text"}, {"time": 0.0}])
def test_what_is_no_state_is_refused(value):
    message = refusal(rc.Simulation(rc.paper_drive()), value)
    assert "pass what Simulation.state() gave" in message


def test_a_state_that_was_changed_is_refused_with_the_field(under_way):
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    taken = under_way.state()
    for name, value in taken.items():
        if name == "snapshot":
            continue
        changed = {**taken, name: np.append(value, 1.0) if np.ndim(value) else value + 1e-9}
        assert f"state['{name}'] was changed" in refusal(simulation, changed)
        missing = {key: value for key, value in taken.items() if key != name}
        assert f"state['{name}'] is missing" in refusal(simulation, missing)
    taken["positions"][3, 1] += 1e-12
    assert "make a Simulation with positions=" in refusal(simulation, taken)


@settings(max_examples=200)
@given(data=st.data())
def test_damaged_bytes_are_refused(data, under_way):
    state = under_way.state()
    whole = bytearray(state["snapshot"])
    kind = data.draw(st.sampled_from(["flip", "cut", "append"]))
    place = data.draw(st.integers(0, len(whole) - 1))
    if kind == "flip":
        whole[place] ^= data.draw(st.integers(1, 255))
    elif kind == "cut":
        del whole[place:]
    else:
        whole += data.draw(st.binary(min_size=1))
    simulation = rc.Simulation(rc.paper_drive(pretension=25.0))
    refusal(simulation, {**state, "snapshot": bytes(whole)})


# --- the file


def rewritten(file, path, **members):
    """Write the members of a state file anew, some of them changed; None leaves one out."""
    old = dict(np.load(file))
    new = {name: value for name, value in {**old, **members}.items() if value is not None}
    with path.open("wb") as target:
        np.savez(target, **new)
    return path


def test_the_file_shows_what_is_in_it_to_numpy_alone(file, under_way):
    members = np.load(file)
    np.testing.assert_array_equal(members["state.positions"], under_way.positions)
    assert members["state.time"] == under_way.time
    assert json.loads(str(members["scene"]))["system"]["type"] == "ChainDrive"
    assert members["rustchain_version"] == rc.__version__


def test_a_file_that_holds_no_state_is_refused(tmp_path):
    text, archive, result = (tmp_path / name for name in ("text", "archive.npz", "result.nc"))
    text.write_text("a state")
    np.savez(archive, positions=np.zeros((40, 3)))
    rc.Simulation(rc.paper_drive()).run(1e-4, progress=False).save(result)
    for path in (text, archive, result):
        with pytest.raises(rc.InvalidInput, match="holds no state of rustchain"):
            rc.Simulation.load_state(path)
    with pytest.raises(FileNotFoundError, match=r"none\.npz: there is no .*\.save_state"):
        rc.Simulation.load_state(tmp_path / "none.npz")


def test_parts_of_two_files_are_refused(file, tmp_path, under_way):
    other = rc.Scene(rc.paper_drive(pretension=26.0)).to_json()
    with pytest.raises(rc.InvalidInput, match="state, drive = model"):
        rc.Simulation.load_state(rewritten(file, tmp_path / "scene.npz", scene=other))
    moved = {"state.positions": under_way.positions + 1e-9}
    with pytest.raises(rc.InvalidInput, match=r"state\['positions'\] was changed"):
        rc.Simulation.load_state(rewritten(file, tmp_path / "moved.npz", **moved))
    with pytest.raises(rc.InvalidInput, match="has format 3, this rustchain reads 2"):
        rc.Simulation.load_state(rewritten(file, tmp_path / "newer.npz", format=3))
    with pytest.raises(rc.InvalidInput, match="holds no state"):
        rc.Simulation.load_state(rewritten(file, tmp_path / "none.npz", scene=None))


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path, under_way, monkeypatch):
    path = tmp_path / "state"  # and no other name
    under_way.save_state(str(path))
    before = path.read_bytes()

    def full(file, **members):
        file.write(before[: len(before) // 2])
        raise OSError(errno.ENOSPC, "no space left")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="no space left"):
        under_way.save_state(path)
    monkeypatch.undo()
    assert [p.name for p in tmp_path.iterdir()] == ["state"]
    assert path.read_bytes() == before
    rc.Simulation(rc.paper_drive()).save_state(path)
    assert rc.Simulation.load_state(path).time == 0.0


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("start.positions", lambda rows: rows[0]),
        ("start.positions", lambda rows: rows[None]),
        ("start.positions", lambda rows: rows.astype(str)),
        ("start.velocities", np.ravel),
        ("start.velocities", lambda rows: rows + 1j),
        ("scene", lambda text: np.array([str(text)] * 2)),
    ],
)
def test_a_start_of_another_shape_or_kind_is_refused(name, changed, file, tmp_path):
    other = changed(np.load(file)[name])
    with pytest.raises(rc.InvalidInput, match=r"other\.npz: holds no state .* or is damaged"):
        rc.Simulation.load_state(rewritten(file, tmp_path / "other.npz", **{name: other}))


def test_a_state_prints_its_names_also_when_copied():
    simulation = rc.Simulation(rc.paper_drive())
    for state in (simulation.state(), pickle.loads(pickle.dumps(simulation.state()))):
        assert repr(state).startswith("<state at t = 0.0 s: time, positions, velocities, ")
        assert len(repr(state)) < 200
        simulation.set_state(state)
    state["time"] = None
    assert repr(state).startswith("<state at t = None s: ")
