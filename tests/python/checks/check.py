"""One comparison with an answer found without this code, and tables of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any, TypeAlias

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Check:
    """A number of this code beside an independent one.

    Attributes
    ----------
    subject : str
        What is compared, with the scene.
    ours, other : float
        The number of this code, and the independent one, both in `unit`.
    bound : float
        Largest allowed error; relative to `other` where `relative`.
    test : str
        ``path::name`` of the test that asserts the bound, below ``tests/``.
    error : float, optional
        Largest error of a comparison of many numbers, of which `ours` and `other` are one.
    error_unit : str, optional
        Unit of `error` and `bound`, where it is not `unit`.
    """

    subject: str
    ours: float
    other: float
    bound: float
    test: str
    unit: str = ""
    relative: bool = False
    error: float | None = None
    error_unit: str | None = None

    @property
    def off(self) -> float:
        """Absolute or relative error."""
        if self.error is not None:
            return self.error
        off = abs(self.ours - self.other)
        return off / abs(self.other) if self.relative else off

    @property
    def kind(self) -> str:
        """Unit of the error and of the bound."""
        if self.error_unit is not None:
            return self.error_unit
        return "relative" if self.relative else self.unit

    @property
    def holds(self) -> bool:
        """Whether the error is within the bound; an undefined error is not."""
        return self.off <= self.bound

    def __str__(self) -> str:
        kind = self.kind
        numbers = f"{self.ours:.9g}, expected {self.other:.9g} {self.unit}"
        return f"{self.subject}: {numbers}; error {self.off:.2g}, bound {self.bound:g} {kind}"


@dataclass(frozen=True)
class Range:
    """A number of this code and the range of an independent answer that has no single value."""

    subject: str
    ours: float
    low: float
    high: float
    test: str
    unit: str = ""

    @property
    def holds(self) -> bool:
        """Whether the number is in the range."""
        return self.low <= self.ours <= self.high

    def __str__(self) -> str:
        return (
            f"{self.subject}: {self.ours:.4g}, expected {self.low:g} to {self.high:g} {self.unit}"
        )


Row: TypeAlias = "Check | Range"


def hold(checks: Iterable[Row]) -> None:
    """Assert that every check is within its bound."""
    wrong = [str(check) for check in checks if not check.holds]
    assert not wrong, "\n".join(wrong)


def exists(test: str) -> bool:
    """Return whether ``path::name`` is a test below ``tests/``."""
    path, _, name = test.partition("::")
    file = ROOT / "tests" / path
    keyword = "fn" if file.suffix == ".rs" else "def"
    return file.is_file() and bool(
        re.search(rf"^{keyword} {re.escape(name)}\(", file.read_text(encoding="utf-8"), re.M)
    )


@dataclass(frozen=True)
class Table:
    """A table of checks for a notebook."""

    checks: tuple[Row, ...]

    def _repr_html_(self) -> str:
        ranges = isinstance(self.checks[0], Range)
        heads = [
            "check",
            "rustchain",
            *(["allowed"] if ranges else ["independent", "error", "bound"]),
        ]
        rows = ""
        for test, group in groupby(self.checks, key=lambda check: check.test):
            rows += "".join(_row(_cells(check)) for check in group)
            path, name = test.split("::")
            named = f"<code>tests/{escape(path)}</code> <code>{escape(name)}</code>"
            rows += f'<tr class="test"><td colspan="{len(heads)}">test: {named}</td></tr>'
        head = _row(heads, "th")
        return f'<table class="checks"><thead>{head}</thead><tbody>{rows}</tbody></table>'


def table(*checks: Row | Iterable[Row] | Iterable[Iterable[Row]]) -> Table:
    """Return a table of checks, and of lists of them, after asserting that they hold."""
    flat = tuple(_flat(checks))
    hold(flat)
    missing = [check.test for check in flat if not exists(check.test)]
    assert not missing, f"no such tests: {missing}"
    return Table(flat)


def _flat(checks: Iterable[Any]) -> Iterator[Row]:
    for each in checks:
        if isinstance(each, (Check, Range)):
            yield each
        else:
            yield from _flat(each)


def _cells(check: Row) -> list[str]:
    ours = f"{check.ours:.6g} {check.unit}"
    if isinstance(check, Range):
        allowed = f"{check.low:g} to {check.high:g} {check.unit}"
        if check.high == float("inf"):
            allowed = f"at least {check.low:g} {check.unit}"
        return [escape(check.subject), ours, allowed]
    other = f"{check.other:.6g} {check.unit}"
    error, bound = f"{check.off:.1e} {check.kind}", f"{check.bound:.2g} {check.kind}"
    return [escape(check.subject), ours, other, error, bound]


def _row(cells: list[str], tag: str = "td") -> str:
    return "<tr>" + "".join(f"<{tag}>{cell}</{tag}>" for cell in cells) + "</tr>"
