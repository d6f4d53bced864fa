"""Mistakes in drive files are told with file, line, column, key and remedy."""

import dataclasses
import json
import os
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rustchain as rc
from command import rustchain
from drive_files import EXAMPLE, changed, written
from rustchain.files.scene import SceneFile
from rustchain.files.source import Source, _read_json

OF_FORCE = "expected one; add " + " or ".join(
    f"type = '{kind}ForceAbove'" for kind in ("Hinge", "Tooth", "Joint", "Contact")
)


@pytest.mark.parametrize(
    ("old", "new", "line", "text"),
    [
        ("teeth = 25", "teeth = 3", 22, "drive.sprockets.2: Sprocket.teeth = 3: must be between"),
        ("teeth = 25", "teth = 25", 22, "drive.sprockets.2.teth: unknown key; did you "),
        ("teeth = 25", "teeth = '25'", 22, "drive.sprockets.2.teeth: '25': must be an integer"),
        ("teeth = 25", "teeth = true", 22, "drive.sprockets.2.teeth: True: must be an integer"),
        ("accuracy = 1e-9", "accuracy = true", 34, "solver.accuracy: True: must be a number"),
        ("teeth = 25", "", 21, "drive.sprockets.2: 'teeth' is missing"),
        ('"outside"', '"outsde"', 30, "sprockets.3.side: 'outsde': must be 'inside' or 'outside'"),
        ("[0.35, -0.05]", "[0.35]", 23, "Sprocket.center = (0.35,): must be two numbers"),
        ('"chain_drive"', '"chain_drve"', 7, "drive.type: 'chain_drve' is not known; did you mean"),
        ('"ANSI 40"', '"ANSI 41x"', 11, "'ANSI 41x' is not in the catalogue; did you mean"),
        ("elongation = 0.002", "elongation = 0.5", 15, "Chain.elongation = 0.5: must be between"),
        ('"machine.csv"', '"mashine.csv"', 24, "motion.curve.file: 'mashine.csv': "),
        ("torque = 0.0", "torqe = 0.0", 24, "drive.sprockets.2.motion.torqe: unknown key"),
        (
            "torque = 0.0, curve",
            "torqe = 0.0, curv",
            24,
            "drive.sprockets.2.motion.curv: unknown key",
        ),
        ("speed = [[0.0", "rpm = [[0.0", 19, "motion.rpm: unknown key; known: 'speed'"),
        ("[0.02, 12.566]", "[0.0, 12.566]", 19, "PrescribedSpeed.speed = 0 s after 0 s"),
        ("[simulation]", "[simulaton]", 32, "simulaton: unknown key; did you mean"),
        ("accuracy = 1e-9", "accuracy = -1", 34, "Solver.accuracy = -1: must be a positive"),
        ('"flores"', '"flors"', 33, "simulation.force_law.damping: 'flors': must be"),
        ("report_step", "report_stp", 38, "run.report_stp: unknown key; did you mean"),
        ("duration = 0.02", "duration = -1.0", 37, "run: duration = -1: must be a positive"),
        ('type = "ToothForceAbove"\n', "", 41, f"its keys fit several types; {OF_FORCE}"),
        ("force = 5000.0", "force = -1.0", 43, "ToothForceAbove.force = -1.0: must be a positive"),
        ("adjust = 3", "adjust = 7", 9, "drive: adjust = 7: must be the number of a sprocket"),
        ("[simulation]", "[simulation", 32, "is no TOML"),
    ],
)
def test_an_error_names_file_line_key_and_what_is_allowed(tmp_path, old, new, line, text):
    done = rustchain("run", changed(tmp_path, old, new), "--out", tmp_path / "run.nc")
    assert done.exit_code == 1
    assert "Traceback" not in done.output
    assert text in done.output
    assert re.search(rf"drive\.toml.*line {line}\b", done.output), done.output


def test_three_mistakes_are_told_at_once_each_with_place_field_and_nearest_name(tmp_path):
    path = changed(tmp_path, "teeth = 25", "teth = 25")
    text = path.read_text().replace("torque = 0.0", "torqe = 0.0")
    path.write_text(text.replace("report_step", "report_stp").replace('"flores"', '"flors"'))
    with pytest.raises(rc.InvalidInput) as refused:
        rc.load_scene(path)
    told = str(refused.value).splitlines()
    line = f"{path}, line"
    assert told[2].startswith(f"{line} 33, column 31: simulation.force_law.damping: 'flors'")
    assert told[2].endswith("'hu-guo' or 'zhiying-qishao'; did you mean 'flores'?")
    assert told == [
        f"{line} 22, column 1: drive.sprockets.2.teth: unknown key; did you mean 'teeth'?",
        f"{line} 24, column 12: drive.sprockets.2.motion.torqe: unknown key; "
        "did you mean 'torque'?",
        told[2],
        f"{line} 38, column 1: run.report_stp: unknown key; did you mean 'report_step'?",
    ]


TOML = """
a = 1 # [x]
"q.r" = "=#["
[t.u]
b.c = [1, 2, [3, # remark
  {d = 4, e.f = "x,}"}],
]
m = \"\"\"
[no]
k = 2 \\\"\"\"\"
n = '''a''b'''
when = 1979-05-27 07:32:00
[[s]]
x = {y = [1979-05-27T07:32:00Z, true]}
[[s]]
[s.z]
w = 'l'
[[s.l]]
v = ""
"""


def keys_within(value, key=()):
    """Yield the key of everything in a value."""
    if isinstance(value, dict | list):
        items = value.items() if isinstance(value, dict) else enumerate(value)
        for name, inside in items:
            yield (*key, name)
            yield from keys_within(inside, (*key, name))


@pytest.mark.parametrize("text", [TOML, TOML.replace("\n", "\r\n"), EXAMPLE.read_text()])
def test_every_key_of_a_file_has_its_line_and_column(tmp_path, text):
    path = tmp_path / "keys.toml"
    path.write_bytes(text.encode())
    source = Source.of(path)
    lines = text.splitlines()
    assert set(source.places) == set(keys_within(source.content))
    for key, (line, column) in source.places.items():
        written = lines[line - 1][column - 1 :]
        if isinstance(key[-1], str):
            assert re.match(rf"(\[*|([\w.\"]+\.)?)[\w.\"]*{re.escape(key[-1])}", written), (
                key,
                written,
            )
        else:
            assert re.match("[\\[{'\"t0-9-]", written)


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        ("speed,torque\n0,1\n", "line 1: 'speed' is no number; put '#' before a line of names"),
        ("# speed, torque\n0,1\n\n1,2,3\n", "line 4 has 3 numbers, line 2 has 2"),
        ("0,1\n1,2 # two\n2;3\n", "line 3: '2;3' is no number"),
        ("# nothing\n", "has no row of numbers"),
    ],
)
def test_a_table_that_is_none_is_told_with_its_line(tmp_path, rows, text):
    path = changed(tmp_path, "duration = 0.02", "duration = 0.01")
    (tmp_path / "machine.csv").write_text(rows)
    with pytest.raises(rc.InvalidInput, match=r"line 24, column 36: .*'machine\.csv': ") as refused:
        rc.load_scene(path)
    assert f"{text}: give a file of rows of numbers" in str(refused.value)


def test_files_and_options_that_are_none_are_refused(tmp_path):
    for command in ("run", "check"):
        done = rustchain(command, tmp_path / "no.toml")
        assert done.exit_code == 1
        assert "is no file" in done.output
    out = tmp_path / "run.nc"
    done = rustchain("run", EXAMPLE, "--pretension", 3, "--duration", 1e-3, "--out", out)
    assert done.exit_code == 0, done.output
    assert rc.load_result(out).drive.tensioner == rc.Tensioner(3.0)
    with pytest.raises(FileNotFoundError, match=r"no\.toml: cannot be read"):
        rc.load_scene(tmp_path / "no.toml")


@pytest.mark.parametrize(
    ("run", "said"),
    [
        ("duration = -1.0", "duration"),
        ("duration = 0.02\nreport_step = 0.0", "report_step"),
        ('duration = 0.02\nrecord = ["hinges", "foo"]', "foo"),
        ('duration = 0.02\nout = "table.csv"', "table.nc"),
        ('duration = 0.02\nout = "."', "is a folder"),
    ],
)
def test_check_refuses_what_run_refuses(tmp_path, run, said):
    path = tmp_path / "scene.toml"
    path.write_text("[drive]\nteeth = [17, 17]\nlinks = 60\nspeed = 10.0\n\n[run]\n" + run + "\n")
    for command in ("check", "run"):
        done = rustchain(command, path)
        assert done.exit_code != 0
        assert said in done.output + str(done.stderr)


SHORT = "[drive]\nteeth = [17, 17]\nlinks = 60\nspeed = 10.0\n"
DEEP = 5000


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SHORT + "gravity = " + "[" * DEEP + "]" * DEEP, "nested more than 32 deep"),
        (SHORT + "gravity = " + "[" * 40 + "]" * 40, "nested more than 32 deep"),
        ("drive = " + "{a = " * 500 + "1" + "}" * 500, "nested more than 32 deep"),
        ("[drive." + ".".join("a" * 500) + "]\nb = 1", "nested more than 32 deep"),
        (SHORT + "name = " + "1" * DEEP, "is no TOML"),
        (
            SHORT + "type = ['a']",
            "line 5, column 1: drive.type: ['a'] is not known; known: 'ChainDrive'",
        ),
        (SHORT + "[run]\nstop = [{type = {}}]", "run.stop.1.type: {} is not known"),
        (SHORT + f"[run]\nout = {DEEP}", f"run.out: {DEEP}: must be a text"),
    ],
)
def test_a_file_that_nests_or_counts_without_end_is_refused_with_its_name(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(rc.InvalidInput) as refused:
        rc.load_scene(path)
    assert str(refused.value).startswith(str(path))
    assert said in str(refused.value)


def test_a_long_value_is_shortened_in_a_message(tmp_path):
    path = written(tmp_path, SHORT + f"[run]\nout = {['long'] * 1000}")
    with pytest.raises(rc.InvalidInput, match=r"run\.out: \['long'") as refused:
        rc.load_scene(path)
    assert len(str(refused.value)) < 600


def test_brackets_in_a_text_of_many_lines_are_read_at_once(tmp_path):
    """The expression that found headers took a time that grew with the third power of spaces."""
    path = written(tmp_path, SHORT + 'type = "two_sprocket_drive"\nspeeds = """\n[' + " " * 30000)
    with pytest.raises(rc.InvalidInput, match="is no TOML"):
        rc.load_scene(path)
    path.write_text(path.read_text() + '\n"""\n')
    with pytest.raises(rc.InvalidInput, match=r"line 6, column 1: drive\.speeds: unknown key"):
        rc.load_scene(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no FIFOs here")
def test_fifos_and_devices_are_no_drive_files_nor_tables(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    for name, kind in ((tmp_path / "fifo", "FIFO"), ("/dev/zero", "device")):
        with pytest.raises(OSError, match=rf"cannot be read \(Is a {kind}; expected"):
            rc.load_scene(name)
        path = written(tmp_path, SHORT.replace("10.0", f'{{ file = "{name}" }}'))
        with pytest.raises(
            rc.InvalidInput, match=rf"line 4, column 11: drive\.speed\.file: .* Is a {kind}"
        ):
            rc.load_scene(path)


def test_a_scene_without_a_duration_says_where_to_write_it(tmp_path):
    for text in (SHORT, SHORT + "[run]\nreport_step = 1e-4\n"):
        path = written(tmp_path, text + '[simulation]\nforce_law = { type = "Hertz" }\n')
        scene = SceneFile.read(path)
        simulation = scene.simulate()
        for call in (scene.run_simulation, scene.check_run):
            with pytest.raises(rc.InvalidInput, match=r"drive\.toml.*run: duration: is missing;"):
                call(simulation)
        assert simulation.time == 0.0


def test_a_key_of_json_that_is_there_twice_is_refused(tmp_path):
    path = tmp_path / "drive.json"
    path.write_text('{"drive": {"type": "paper_drive", "pretension": 1, "pretension": 2}}')
    with pytest.raises(
        rc.InvalidInput, match="'pretension' is there twice in one object, at line 1, column 52"
    ):
        rc.load_scene(path)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"drive": {"type": "paper_drive",\n  "pretension": }}',
         r"is no JSON \(Expecting value, at line 2, column 17\)"),
        ('{"drive": {"type": "paper_drive",\n  "pretension": "x",\n\n "spede": [1, {}]}}',
         r"line 2, column 3: drive.pretension: 'x': must be a number\n.*"
         r"line 4, column 2: drive.spede: unknown key"),
        ('{"drive": {"type": "paper_drive"},\n "run": {\n"stop": [\n {"type": "ToothJump"},\n'
         ' {"type": "TimeReached", "a\\\\\\":{": 1}]}}',
         r"line 5, column 26: run.stop.2.a.*: unknown key"),
        ('{"drive": {"type": "two_sprocket_drive", "chain": "ANSI 40", "links": 38,\n "speed": 1,'
         '\n "teeth": [3, 17]}}',
         r"line 3, column 2: drive: teeth = \(3, 17\): must be"),
    ],
)  # fmt: skip
def test_errors_in_json_have_line_and_column(tmp_path, text, told):
    path = tmp_path / "drive.json"
    path.write_text(text)
    with pytest.raises(rc.InvalidInput, match=told):
        rc.load_scene(path)


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(),
        lambda inside: st.lists(inside) | st.dictionaries(st.text(), inside),
        max_leaves=20,
    ),
    st.sampled_from([None, 0, 2]),
)
def test_each_key_and_item_of_json_has_its_place(value, indent):
    text = json.dumps({"value": value}, indent=indent)
    content, places = _read_json(text)
    lines = text.split("\n")

    def check(found, key):
        line, column = places[key]
        rest = lines[line - 1][column - 1 :]
        assert rest.startswith(json.dumps(key[-1] if isinstance(key[-1], str) else found)[:1])
        if isinstance(found, dict | list):
            below = found.items() if isinstance(found, dict) else enumerate(found)
            for name, each in below:
                check(each, (*key, name))

    check(content["value"], ("value",))


@pytest.mark.parametrize("key", ["drive", "mechanism"])
@pytest.mark.parametrize("value", ["3", '"paper"', '[{type = "paper_drive"}]'])
def test_a_drive_or_mechanism_that_is_no_table_is_refused_at_its_place(tmp_path, key, value):
    path = written(tmp_path, f"# a file\n{key} = {value}\n")
    with pytest.raises(rc.InvalidInput, match=rf"line 2, column 1: {key}: .*: must be a table"):
        rc.load_scene(path)


def test_a_file_of_a_drive_and_a_mechanism_is_refused(tmp_path):
    body = '[[mechanism.bodies]]\nname = "a"\nmass = 1.0\ninertia = 1.0\n'
    path = written(tmp_path, f'[drive]\ntype = "paper_drive"\n{body}')
    with pytest.raises(rc.InvalidInput, match="has a drive and a mechanism; expected one of them"):
        rc.load_scene(path)


def test_a_scene_is_saved_as_toml_or_json_alone(tmp_path):
    with pytest.raises(rc.InvalidInput, match=r"path = .*run\.txt: expected a name that ends in"):
        rc.save_scene(rc.Scene(rc.paper_drive()), tmp_path / "run.txt")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("section", ["simulation", "run"])
def test_a_section_that_is_no_table_is_refused(tmp_path, section):
    path = written(tmp_path, f'{section} = 3\n[drive]\ntype = "paper_drive"\n')
    with pytest.raises(rc.InvalidInput, match=f"line 1, column 1: {section}: 3: must be a table"):
        rc.load_scene(path)


@pytest.mark.parametrize("section", ["simulation", "run"])
def test_a_type_of_a_table_that_has_none_is_an_unknown_key(tmp_path, section):
    path = written(tmp_path, f'[drive]\ntype = "paper_drive"\n[{section}]\ntype = "Scene"\n')
    with pytest.raises(rc.InvalidInput, match=f"line 4, column 1: {section}.type: unknown key"):
        rc.load_scene(path)


def test_a_lone_surrogate_is_refused_as_a_name_and_as_a_path(tmp_path):
    drive = dataclasses.replace(rc.paper_drive(), name="a\ud800b")
    with pytest.raises(rc.InvalidInput, match="expected text without lone surrogates"):
        rc.save_scene(rc.Scene(drive), tmp_path / "drive.toml")
    with pytest.raises(rc.InvalidInput, match=r"path = .* is no file name"):
        rc.load_scene("a\ud800b.toml")
