"""Mutation testing of Python modules: one small change at a time, which some test has to notice.

    python tests/stress/mutants.py rustchain.analysis.rainflow --tests tests/python/analysis

Each test first runs in a child that records which functions it calls. Each living mutant of one of
them then meets the test in a child of its own, where the code of the function is exchanged.
Fixtures are made once, by the parent. Changes: + and -, * and /, ** to *; order and (in)equality of
comparisons; and/or; not and the minus sign left out; numbers (integers + 1, others doubled, 0 to
1); True and False; min and max, sin and cos, floor and ceil, any and all. Messages stay.
"""

from __future__ import annotations

import argparse
import ast
import copy
import importlib
import inspect
import json
import os
import pickle
import signal
import sys
import types
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

LONGEST = 5.0  # processor time of a test with a mutant [s]; what is longer is noticed
ARITHMETIC = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
ARITHMETIC |= {ast.Pow: ast.Mult, ast.Mod: ast.Mult, ast.FloorDiv: ast.Div}
ARITHMETIC |= {ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd}
COMPARISONS = {ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.GtE), ast.Eq: (ast.NotEq,)}
COMPARISONS |= {ast.Gt: (ast.GtE, ast.Lt), ast.GtE: (ast.Gt, ast.LtE), ast.NotEq: (ast.Eq,)}
COMPARISONS |= {ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,), ast.In: (ast.NotIn,)}
COMPARISONS |= {ast.NotIn: (ast.In,)}
PAIRS = (("min", "max"), ("sin", "cos"), ("floor", "ceil"), ("any", "all"), ("argmin", "argmax"))
NAMES = {**dict(PAIRS), **{second: first for first, second in PAIRS}}


@dataclass
class Mutant:
    """A change: its place, the function it is in, and that function's code with it."""

    module: str
    function: str
    line: int
    text: str
    code: types.CodeType
    defaults: tuple[object, ...] = ()
    state: str = "no test"

    def __str__(self) -> str:
        return f"{self.state}: {self.module}:{self.line} {self.function}: {self.text}"


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield a node with each of its changes."""
    new = copy.copy(node)
    if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in ARITHMETIC:
        new.op = ARITHMETIC[type(node.op)]()
        yield new
    elif isinstance(node, ast.Compare):
        for k, op in enumerate(node.ops):
            for other in COMPARISONS[type(op)]:
                new = copy.copy(node)
                new.ops = [*node.ops[:k], other(), *node.ops[k + 1 :]]
                yield new
    elif isinstance(node, ast.BoolOp):
        new.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield new
    elif isinstance(node, ast.UnaryOp) and not isinstance(node.op, ast.Invert):
        yield copy.copy(node.operand)  # its place in the source is changed by the caller
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool | int | float):
        value = node.value
        new.value = (
            not value if value in (True, False) and isinstance(value, bool)
            else value + 1 if isinstance(value, int)
            else 2.0 * value or 1.0
        )  # fmt: skip
        yield new
    elif isinstance(node, ast.Name | ast.Attribute):
        name = "id" if isinstance(node, ast.Name) else "attr"
        if getattr(node, name) in NAMES and isinstance(node.ctx, ast.Load):
            setattr(new, name, NAMES[getattr(node, name)])
            yield new


def places(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int | None, ast.AST]]:
    """Yield parent, field, place in it and node, of what is neither annotation nor message."""
    for field, value in ast.iter_fields(tree):
        if field in ("annotation", "returns", "decorator_list") or isinstance(tree, ast.Raise):
            continue
        for k, child in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(child, ast.AST) or isinstance(child, ast.JoinedStr):
                continue
            yield tree, field, k if isinstance(value, list) else None, child
            yield from places(child)


def functions(module: types.ModuleType) -> dict[str, types.FunctionType]:
    """Return the functions and methods that a module defines, by qualified name."""
    found: dict[str, types.FunctionType] = {}
    for owner in (module, *(v for v in vars(module).values() if inspect.isclass(v))):
        for value in vars(owner).values():
            value = getattr(value, "fget", None) or getattr(value, "func", None) or value
            value = inspect.unwrap(getattr(value, "__func__", value))
            if isinstance(value, types.FunctionType) and value.__module__ == module.__name__:
                found[value.__qualname__] = value
    return found


def codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yield the codes of functions inside a code, those in functions left out."""
    for const in code.co_consts:
        if isinstance(const, types.CodeType):
            yield const
            if not const.co_flags & inspect.CO_NEWLOCALS:  # of a class
                yield from codes(const)


def mutants_of(module: types.ModuleType) -> Iterator[Mutant]:
    """Yield all mutants of the functions of a module; module-level code is left out."""
    path = str(module.__file__)
    tree = ast.parse(Path(path).read_text())
    flags = compile(tree, path, "exec").co_flags & 0x1000000  # from __future__ import annotations
    originals = functions(module)
    for parent, field, k, node in list(places(tree)):
        for new in changes(node):
            ast.copy_location(new, node)
            text = f"{ast.unparse(node)} -> {ast.unparse(new)}"
            _put(parent, field, k, new)
            changed = compile(tree, path, "exec", flags)
            _put(parent, field, k, node)
            for code in codes(changed):
                original = originals.get(code.co_qualname)
                if original is not None and code != original.__code__:
                    line = getattr(node, "lineno", original.__code__.co_firstlineno)
                    yield Mutant(module.__name__, code.co_qualname, line, text, code)


def _put(parent: ast.AST, field: str, k: int | None, node: ast.AST) -> None:
    if k is None:
        setattr(parent, field, node)
    else:
        getattr(parent, field)[k] = node


class Runner:
    """A plugin of pytest: every test with the mutants that it can notice."""

    def __init__(self, modules: list[types.ModuleType]) -> None:
        self.functions = {m.__name__: functions(m) for m in modules}
        self.mutants = [mutant for module in modules for mutant in mutants_of(module)]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Run the mutants before the test, which may leave values that were computed in caches."""
        called = self.called(item)
        for mutant in self.mutants:
            if mutant.state != "killed" and (mutant.module, mutant.function) in called:
                mutant.state = "survived" if self.passes(item, mutant) else "killed"
        return (yield)

    def called(self, item: pytest.Item) -> set[tuple[str, str]]:
        """Return module and name of each function that a test calls."""
        out, into = os.pipe()
        child = os.fork()
        if not child:
            known = {
                f.__code__: (m, n) for m, each in self.functions.items() for n, f in each.items()
            }
            seen = set()
            sys.setprofile(lambda frame, event, arg: seen.add(known.get(frame.f_code)))
            _quietly(item)
            sys.setprofile(None)
            with os.fdopen(into, "wb") as pipe:
                pipe.write(pickle.dumps(seen - {None}))
            os._exit(0)
        os.close(into)
        with os.fdopen(out, "rb") as pipe:
            content = pipe.read()
        os.waitpid(child, 0)
        return pickle.loads(content) if content else set()

    def passes(self, item: pytest.Item, mutant: Mutant) -> bool:
        """Return whether a test passes with a mutant in place."""
        child = os.fork()
        if not child:
            signal.signal(signal.SIGPROF, signal.SIG_DFL)
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
            self.functions[mutant.module][mutant.function].__code__ = mutant.code
            os._exit(not _quietly(item))
        return os.waitpid(child, 0)[1] == 0


def _quietly(item: pytest.Item) -> bool:
    """Run a test in a child; return whether it passes."""
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    try:
        item.runtest()
    except BaseException:
        return False
    return True


def main() -> int:
    """Make the mutants of modules, run tests, print the survivors and the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("modules", nargs="+")
    parser.add_argument("--tests", nargs="+", required=True)
    given, others = parser.parse_known_args()  # others: arguments of pytest
    runner = Runner([importlib.import_module(name) for name in given.modules])
    print(len(runner.mutants), "mutants", flush=True)
    options = ["-q", "-p", "no:cacheprovider", "-p", "no:xdist", *others]
    pytest.main([*options, *given.tests], plugins=[runner])
    for mutant in runner.mutants:
        if mutant.state != "killed":
            print(mutant)
    for name in given.modules:
        states = [mutant.state for mutant in runner.mutants if mutant.module == name]
        counts = {state: states.count(state) for state in ("killed", "survived", "no test")}
        print(name, len(states), json.dumps(counts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
