"""Every example in a docstring runs and prints what it says."""

import ast
import doctest
from pathlib import Path

import numpy as np
import pytest

import rustchain as rc

PACKAGE = Path(rc.__file__).parent
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def examples():
    """Yield the examples of each docstring of the package.

    `doctest` finds modules' own functions alone, which decorated ones are not.
    """
    parser = doctest.DocTestParser()
    for path in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = ast.get_docstring(node) if isinstance(node, DOCUMENTED) else None
            if text and ">>>" in text:
                name = f"{path.relative_to(PACKAGE)}:{getattr(node, 'name', 'module')}"
                globs = {"rc": rc, "np": np}
                yield parser.get_doctest(text, globs, name, str(path), getattr(node, "lineno", 0))


EXAMPLES = list(examples())


def test_every_example_of_the_package_is_found():
    written = sum(path.read_text(encoding="utf-8").count(">>> ") for path in PACKAGE.rglob("*.py"))
    assert sum(len(one.examples) for one in EXAMPLES) == written > 0


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_prints_what_it_says(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told = []
    failed, _ = doctest.DocTestRunner(verbose=False).run(example, out=told.append)
    assert not failed, "".join(told)
