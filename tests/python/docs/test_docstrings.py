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


def long_signatures():
    """Yield the public functions, methods and commands with more than eight parameters."""
    for path in sorted(PACKAGE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        owners = {
            child: node
            for node in ast.walk(tree)
            if isinstance(node, ast.ClassDef)
            for child in node.body
        }
        for node in ast.walk(tree):
            if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                continue
            given = [one for one in node.args.args if one.arg not in ("self", "cls")]
            if len(given) + len(node.args.kwonlyargs) > 8:
                # The parameters of a class are described in the docstring of the class.
                told = owners[node] if node.name == "__init__" else node
                told = None if path.parent.name == "cli" else told
                yield pytest.param(node, told, id=f"{path.stem}.{node.name}")


LONG = list(long_signatures())


def test_long_signatures_are_found():
    names = {one.id for one in LONG}
    known = {"simulation.__init__", "standard.two_sprocket_drive", "study.study", "run.run"}
    assert known | {"many.study", "show.animate"} <= names


@pytest.mark.parametrize(("function", "told"), LONG)
def test_of_more_than_eight_parameters_each_is_described_and_most_are_keywords(function, told):
    """At most two parameters with a default can be given by position; the others are keywords."""
    assert len(function.args.defaults) <= 2
    if told is None:  # a command, whose arguments and options have a help text each
        assert len(function.args.args) == 1
        return
    section = (ast.get_docstring(told) or "").partition("Parameters\n----------\n")[2]
    arguments = [*function.args.args, *function.args.kwonlyargs]
    names = [one.arg for one in arguments if one.arg not in ("self", "cls")]
    heads = [line.split(" : ")[0] for line in section.partition("\n\n")[0].splitlines()]
    described = {name.strip() for head in heads if head[:1] != " " for name in head.split(",")}
    assert [name for name in names if name not in described] == []
