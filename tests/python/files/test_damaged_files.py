"""Damaged, truncated and hostile files: refused with a message, or read as they were written."""

import io
import json
import zipfile

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rustchain as rc
from rustchain.results.values import equal

EXAMPLES = 600  # 10 to 30 s each


def drive():
    return rc.Simulation(rc.paper_drive(25.0))


def pendulum():
    mechanism = rc.Mechanism(name="pendulum")
    mechanism.add_body("bar", 1.0, 0.1, position=(0.5, 0.0, 0.0))
    mechanism.add_revolute("pin", "ground", "bar", point_b=(-0.5, 0.0))
    return rc.Simulation(mechanism)


def content_of(loaded):
    """Return all that a file says, as values that can be compared."""
    if isinstance(loaded, rc.Scene):
        return {"scene": loaded}
    if isinstance(loaded, rc.Simulation):
        return {"scene": loaded.scene} | loaded.state()
    about = {name: value for name, value in vars(loaded).items() if name != "arrays"}
    return about | {f"array {name}": loaded.arrays[name] for name in loaded.arrays}


def write_scene(ending):
    def write(path):
        made = path.with_suffix(ending)
        rc.save_scene(rc.Scene(rc.paper_drive(25.0)), made)
        return made

    return write


def write_with(write):
    def written(path):
        write(path)
        return path

    return written


SHORT = {"duration": 3e-4, "progress": False}
KINDS = {
    "result": (write_with(lambda p: drive().run(**SHORT).save(p)), rc.load_result),
    "stream": (write_with(lambda p: drive().run(**SHORT, out=p)), rc.load_result),
    "stream of a mechanism": (
        write_with(lambda p: pendulum().run(0.03, out=p, memory="60 kB", progress=False)),
        rc.load_result,
    ),
    "state": (write_with(lambda p: drive().save_state(p)), rc.Simulation.load_state),
    "toml": (write_scene(".toml"), rc.load_scene),
    "json": (write_scene(".json"), rc.load_scene),
}


@pytest.fixture(scope="module", params=KINDS)
def file(request, tmp_path_factory):
    """A file of each kind: where it is, its bytes, what they say, and what reads them."""
    write, load = KINDS[request.param]
    path = write(tmp_path_factory.mktemp("whole") / "file")
    return path, path.read_bytes(), content_of(load(path)), load


def same(one, other):
    """Return whether two files say the same, to the last bit."""
    return one.keys() == other.keys() and all(equal(one[name], other[name]) for name in one)


def refused_or_read(file, content):
    """Read `content` in the place of a file: what it says, or None where it was refused."""
    path, whole, _, load = file
    path.write_bytes(content)
    try:
        return content_of(load(path))
    except rc.InvalidInput:
        return None
    finally:
        path.write_bytes(whole)


PLACES = st.floats(0.0, 1.0, exclude_max=True)
EDITS = st.lists(
    st.one_of(
        st.tuples(st.just("flip"), PLACES, st.integers(0, 7)),
        st.tuples(st.just("set"), PLACES, st.integers(0, 255)),
        st.tuples(st.just("insert"), PLACES, st.binary(min_size=1, max_size=16)),
        st.tuples(st.just("delete"), PLACES, st.integers(1, 600)),
        st.tuples(st.just("zero"), PLACES, st.integers(1, 5000)),
        st.tuples(st.just("cut"), PLACES, st.none()),
    ),
    min_size=1,
    max_size=3,
)


def edited(whole, edits):
    content = bytearray(whole)
    for kind, place, value in edits:
        at = int(place * len(content))
        if kind == "flip" and content:
            content[at] ^= 1 << value
        elif kind == "set" and content:
            content[at] = value
        elif kind == "insert":
            content[at:at] = value
        elif kind == "delete":
            del content[at : at + value]
        elif kind == "zero":
            content[at : at + value] = bytes(len(content[at : at + value]))
        elif kind == "cut":
            del content[at:]
    return bytes(content)


@pytest.mark.slow
def test_a_damaged_file_is_refused_or_says_what_it_said(file):
    path, whole, said, _ = file
    text = path.suffix in (".toml", ".json")
    outcomes = []

    @settings(max_examples=EXAMPLES)
    @given(EDITS)
    def damage(edits):
        content = edited(whole, edits)
        found = refused_or_read(file, content)
        outcomes.append(found is None)
        # In a text, another number is another scene.
        assert text or found is None or same(found, said)

    damage()
    assert sum(outcomes) > EXAMPLES // 10


def test_a_truncated_file_is_refused(file):
    _, whole, said, _ = file
    for length in (0, 1, 8, 9, 100, len(whole) // 2, len(whole) - 1):
        found = refused_or_read(file, whole[:length])
        # A text without its last line end, and a file without the unused end of a block.
        assert found is None or (length == len(whole) - 1 and same(found, said)), length


def test_the_marks_of_a_file_that_is_written_are_read_and_damage_to_it_is_refused(tmp_path):
    """The file of a process that was killed, made by copying one during its run."""
    path, copy = tmp_path / "run.nc", tmp_path / "copy.nc"

    def look(simulation):
        if simulation.time < 0.02:
            return False
        copy.write_bytes(path.read_bytes())
        try:
            rc.load_result(copy)
        except rc.InvalidInput:  # no piece is complete yet
            return False
        return True

    drive().run(0.03, 4e-5, progress=False, out=path, memory="10 MB", callback=look)
    whole = copy.read_bytes()
    assert whole[11] != 0
    said = content_of(rc.load_result(copy))
    assert said["status"] == "interrupted"
    kind = (copy, whole, said, rc.load_result)
    used = len(whole.rstrip(b"\0"))  # behind it is room for the next piece
    assert 200_000 < used < len(whole)
    for length in (12, 47, 48, 49, 5000, used // 3, used - 100):
        assert refused_or_read(kind, whole[:length]) is None, length
    refused = []
    place = np.random.default_rng(1)
    for _ in range(20):
        content = bytearray(whole)
        content[place.integers(len(whole))] ^= 1 << place.integers(8)
        found = refused_or_read(kind, bytes(content))
        refused.append(found is None)
        assert found is None or same(found, said)
    assert any(refused)


JUNK = {
    "zeros": bytes(10_000),
    "ones": b"\xff" * 10_000,
    "only the signature of HDF5": b"\x89HDF\r\n\x1a\n",
    "only the signature of a stream": b"\x89HDF\r\n\x1a\n\x03" + bytes(5000),
    "only the signature of a zip": b"PK\x03\x04" + bytes(100),
    "many brackets": b"[" * 200_000,
    "many braces": b'{"a":' * 100_000,
    "a deep table": b"[" + b"a." * 50_000 + b"a]\n",
    "a deep list": b"a = " + b"[" * 100_000,
    "a long number": b"duration = " + b"9" * 100_000,
    "no UTF-8": b'[drive]\ntype = "\xff\xfe"\n',
    "NUL": b"[drive]\x00",
}


@pytest.mark.parametrize("junk", JUNK)
def test_junk_is_refused(junk, file):
    assert refused_or_read(file, JUNK[junk]) is None


def hostile_stream(path, change):
    """Write a streamed file, changed by a program that keeps all checksums of HDF5."""
    drive().run(**SHORT, out=path)
    with h5py.File(path, "r+") as file:
        change(file)
    return path


def header_with(file, old, new):
    """Replace a part of the header, with the checksum that HDF5 keeps of it."""
    text = file["run/header"][:].tobytes()
    assert old in text
    del file["run/header"]
    file["run"]["header"] = np.frombuffer(text.replace(old, new), np.uint8)


def other_scene(file):
    header_with(file, b"0.0127", b"0.0128")


def no_scene(file):
    header_with(file, b'"scene"', b'"scone"')


def no_end(file):
    del file["run/end"]


def no_text(file):
    del file["run/end"]
    file["run"]["end"] = np.frombuffer(b"{not json", np.uint8)


def no_time(file):
    del file["time"]


def time_of_text(file):
    del file["time"]
    file["time"] = np.array([b"a", b"b"], dtype="S1")


def group_for_rows(file):
    del file["hinge_force"]
    file.create_group("hinge_force")


def link_elsewhere(file):
    del file["hinge_force"]
    file["hinge_force"] = h5py.ExternalLink("/etc/passwd", "/")


def fewer_columns(file):
    values = file["hinge_force"][:, :3]
    del file["hinge_force"]
    made = file.create_dataset("hinge_force", data=values, maxshape=(None, 3))
    assert made.shape[1] == 3


@pytest.mark.parametrize("change", [other_scene, no_scene, no_end, no_text, no_time, time_of_text])
def test_a_stream_that_a_program_changed_is_refused(change, tmp_path):
    path = hostile_stream(tmp_path / "run.nc", change)
    with pytest.raises(rc.InvalidInput, match=r"run\.nc: is no result, or is damaged"):
        rc.load_result(path)


@pytest.mark.parametrize("change", [group_for_rows, link_elsewhere])
def test_what_is_no_array_of_a_stream_is_not_recorded(change, tmp_path):
    path = hostile_stream(tmp_path / "run.nc", change)
    try:
        loaded = rc.load_result(path)
    except rc.InvalidInput:
        return
    with pytest.raises((rc.NotRecorded, rc.InvalidInput)):
        loaded.array("hinge_force")


def test_an_array_of_another_width_is_refused_where_it_is_used(tmp_path):
    loaded = rc.load_result(hostile_stream(tmp_path / "run.nc", fewer_columns))
    with pytest.raises((rc.InvalidInput, IndexError)):
        loaded.hinge(6)


def state_with(path, **members):
    drive().save_state(path)
    with np.load(path) as file:
        found = {name: file[name] for name in file.files}
    archive = io.BytesIO()
    np.savez(archive, **(found | members))
    path.write_bytes(archive.getvalue())
    return path


@pytest.mark.parametrize(
    "members",
    [
        {"state.snapshot": np.zeros(0, np.uint8)},
        {"state.snapshot": np.full(10_000, 255, np.uint8)},
        {"state.positions": np.zeros((2, 3))},
        {"start.positions": np.zeros((3, 2))},
        {"start.positions": np.array("text")},
        {"scene": np.array('{"type": "os.system"}')},
        {"scene": np.array("[" * 100_000)},
        {"format": np.array([1, 2])},
        {"format": np.array("two")},
    ],
    ids=lambda members: next(iter(members)),
)
def test_a_state_that_a_program_changed_is_refused(members, tmp_path):
    path = state_with(tmp_path / "state.npz", **members)
    with pytest.raises(rc.InvalidInput):
        rc.Simulation.load_state(path)


def test_a_state_with_a_pickle_is_refused_and_not_run(tmp_path):
    class Runs:
        def __reduce__(self):
            return (open, (str(tmp_path / "made"), "w"))

    path = state_with(tmp_path / "state.npz")
    archive = io.BytesIO()
    np.save(archive, np.array(Runs(), dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "a") as file:
        file.writestr("extra.npy", archive.getvalue())
    with pytest.raises(rc.InvalidInput, match="holds no state"):
        rc.Simulation.load_state(path)
    assert not (tmp_path / "made").exists()


def test_a_state_that_grows_when_it_is_unpacked_is_refused(tmp_path):
    path = state_with(tmp_path / "state.npz")
    archive = io.BytesIO()
    np.save(archive, np.zeros(10_000_000))
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("extra.npy", archive.getvalue())
    with pytest.raises(rc.InvalidInput, match="holds no state"):
        rc.Simulation.load_state(path)


def test_a_scene_in_a_file_makes_nothing_but_descriptions(tmp_path):
    path = tmp_path / "scene.json"
    for kind in ("os.system", "Simulation", "Path", "__import__", "Result"):
        path.write_text(json.dumps({"drive": {"type": kind, "path": "/"}}))
        with pytest.raises(rc.InvalidInput):
            rc.load_scene(path)


@pytest.mark.parametrize("text", ["1", "null", "[]", '{"a": 1}'])
def test_a_state_whose_scene_is_no_scene_is_refused(text, tmp_path):
    path = tmp_path / "state.npz"
    pendulum().save_state(path)
    with np.load(path) as file:
        members = dict(file)
    np.savez(path, **members | {"scene": np.array(text)})
    with pytest.raises(rc.InvalidInput, match="holds no state"):
        rc.Simulation.load_state(path)
