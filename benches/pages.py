"""Tables of measurements, and their places in pages of the documentation."""

from __future__ import annotations

from collections.abc import Iterable


def table(columns: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Return the lines of a table."""
    head, *rest = ["| " + " | ".join(row) + " |" for row in (columns, *rows)]
    return [head, "|" + "---|" * len(list(columns)), *rest]


def put(page: str, name: str, lines: Iterable[str]) -> str:
    """Return the text of a page with these lines between the marks of this name."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, mark, rest = page.partition(begin)
    _, end_mark, after = rest.partition(end)
    if not mark or not end_mark:
        raise SystemExit(f"error: the page has no marks {begin} and {end}")
    return "\n".join([f"{before}{begin}", "", *lines, "", f"{end}{after}"])
