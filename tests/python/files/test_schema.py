"""The JSON Schema of drive files says the same as their reader."""

import json
from pathlib import Path

import jsonschema
import pytest

import rustchain as rc
from command import rustchain

tomllib = pytest.importorskip("tomllib")  # Python 3.11
EXAMPLE = Path(__file__).parents[3] / "examples" / "three_shafts.toml"


@pytest.fixture(scope="module")
def schema(tmp_path_factory):
    path = tmp_path_factory.mktemp("schema") / "drive.schema.json"
    done = rustchain("schema", "--out", path)
    assert done.exit_code == 0, done.output
    printed = rustchain("schema")
    assert printed.output == path.read_text(encoding="utf-8")
    return json.loads(printed.output)


@pytest.fixture(scope="module")
def validator(schema):
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_example_is_valid(validator):
    assert validator.is_valid(tomllib.loads(EXAMPLE.read_text()))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("teeth = 25", "teth = 25"),
        ("teeth = 25", "teeth = '25'"),
        ("teeth = 25", ""),
        ('"outside"', '"outsde"'),
        ("[simulation]", "[simulaton]"),
        ("report_step", "report_stp"),
        ('"flores"', '"flors"'),
        ("[0.35, -0.05]", "[0.35]"),
    ],
)
def test_what_the_reader_refuses_is_invalid(validator, old, new):
    text = EXAMPLE.read_text()
    assert text.count(old) == 1
    assert not validator.is_valid(tomllib.loads(text.replace(old, new)))


def test_every_key_has_a_description_and_defaults_are_those_of_the_classes(schema):
    top = {"the file": schema} | {k: schema["properties"][k] for k in ("simulation", "run")}
    missing = [
        (name, key)
        for name, table in (schema["$defs"] | top).items()
        for key, value in table["properties"].items()
        if key != "type" and "description" not in value
    ]
    assert missing == []
    material = schema["$defs"]["Material"]["properties"]
    assert material["restitution"]["default"] == rc.Material().restitution
    assert "Restitution coefficient" in material["restitution"]["description"]
    solver = schema["properties"]["simulation"]["properties"]["solver"]
    assert solver["$ref"] == "#/$defs/Solver"
