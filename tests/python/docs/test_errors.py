"""The index of errors and warnings has all of them, with their classes and messages."""

import builtins
import re
from pathlib import Path

import pytest

from rustchain import errors

ROOT = Path(__file__).parents[3]
PAGE = (ROOT / "docs" / "reference" / "errors.md").read_text(encoding="utf-8")
ROWS = {
    row[0].strip(" `"): row[2].strip(" `")
    for line in re.findall(r"^\| (`[A-Z]\w+`.*) \|$", PAGE, re.MULTILINE)
    for row in [line.split("|")]
}


def test_every_exception_and_warning_has_a_row():
    assert sorted(ROWS) == sorted(errors.__all__)


@pytest.mark.parametrize(("name", "also"), ROWS.items())
def test_the_standard_class_of_a_row_catches_it(name, also):
    found = getattr(errors, name)
    assert issubclass(found, getattr(builtins, also))
    base = errors.RustchainWarning if name.endswith("Warning") else errors.RustchainError
    assert issubclass(found, base)


def test_every_message_of_a_failed_run_has_a_row():
    source = (ROOT / "src" / "error.rs").read_text(encoding="utf-8")
    of_runs = [
        re.sub(r"\\\n\s*", "", text)
        for text in re.findall(r'#\[error\(\s*"((?:[^"\\]|\\.|\\\n)*)"', source)
        if not text.startswith("{")  # of descriptions
    ]
    messages = re.findall(r"^\| `([a-z][^`]*)` \|", PAGE, re.MULTILINE)
    assert len(of_runs) == len(messages) == 6
    for text in of_runs:
        start = re.split(r" ?\{", text)[0]
        assert any(message.startswith(start) for message in messages), start
