"""Names of the source in the theory and developer pages exist in the source.

Checked are the tables with a column "name in code", and every Rust file that a page names.
"""

import ast
import itertools
import re
from pathlib import Path

import pytest

tomllib = pytest.importorskip("tomllib", reason="Python 3.11")
ROOT = Path(__file__).parents[3]
PAGES = sorted(
    page for folder in ("theory", "development") for page in (ROOT / "docs" / folder).glob("*.md")
)
RUST = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "src").rglob("*.rs"))]
PYTHON = [path.read_text(encoding="utf-8") for path in sorted((ROOT / "python").rglob("*.py"))]
RUST_TYPE = r"\b(?:struct|enum|trait|type) {}\b"
RUST_MEMBER = r"\b(?:fn|const|type) {0}\b|^\s+(?:pub(?:\([a-z]+\))? )?{0}: "
PYTHON_TYPE = r"^class {}\b"
PYTHON_MEMBER = r"^    {0}\b|^    def {0}\b"
COLUMN = "name in code"


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def names_in_code(page: Path) -> list[str]:
    """Return the names in backticks of the column of this title."""
    found, column = [], None
    for line in page.read_text(encoding="utf-8").splitlines():
        if not line.startswith("|"):
            column = None
        elif COLUMN in cells(line):
            column = cells(line).index(COLUMN)
        elif column is not None:
            found += re.findall(r"`([^`]+)`", cells(line)[column])
    return found


def occurs(patterns: tuple[str, ...], texts: list[str]) -> bool:
    """Return whether one text has all patterns."""
    return any(all(re.search(p, text, re.MULTILINE) for p in patterns) for text in texts)


def missing(name: str, owner: str) -> list[str]:
    """Return the parts of a name of a table that the source does not have.

    ``Type::member`` and ``Type::{member, member}`` are of Rust, ``Type.member`` is of Python.
    ``.member`` belongs to the Python type ``owner`` before it. A name alone may be of either.
    """
    if name.endswith((".rs", "/")):
        return [] if (ROOT / "src" / name).exists() else [name]
    if "::" in name:
        kind, members = name.split("::")
        return [
            f"{kind}::{member}"
            for member in re.findall(r"\w+", members)
            if not occurs((RUST_TYPE.format(kind), RUST_MEMBER.format(member)), RUST)
        ]
    if "." in name:
        kind, member = name.split(".")
        patterns = (PYTHON_TYPE.format(kind or owner), PYTHON_MEMBER.format(member))
        return [] if occurs(patterns, PYTHON) else [f"{kind or owner}.{member}"]
    return [] if occurs((rf"\b{name}\b",), RUST + PYTHON) else [name]


@pytest.mark.parametrize(
    "page", [page for page in PAGES if names_in_code(page)], ids=lambda page: page.stem
)
def test_every_name_of_the_column_exists(page):
    lost, owner = [], ""
    for name in names_in_code(page):
        lost += missing(name, owner)
        if "." in name and not name.startswith("."):
            owner = name.split(".")[0]
    assert lost == []


def test_the_symbols_of_index_and_integrator_are_checked():
    checked = {page.stem: len(names_in_code(page)) for page in PAGES if names_in_code(page)}
    assert checked.keys() >= {"index", "integrator"}
    assert checked["index"] > 30


@pytest.mark.parametrize(
    "name",
    ["HertzPair::stiffness", "ToothProfile::seating", "ChainMatrix", "Chain.half_pitch", ".bore"],
)
def test_a_name_that_does_not_exist_is_found(name):
    assert missing(name, "ClearanceHinge")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_rust_file_of_a_page_exists(page):
    named = re.findall(r"`([\w/]+/\w+\.rs)`", page.read_text(encoding="utf-8"))
    assert [
        path for path in named if not any((ROOT / top / path).exists() for top in ("", "src"))
    ] == []


def test_the_order_of_the_packages_is_that_of_the_import_contract():
    page = (ROOT / "docs" / "development" / "architecture.md").read_text(encoding="utf-8")
    shown = re.search(r"^    typing, .*(?:\n    .*)*", page, re.MULTILINE)[0]
    order = [set(re.findall(r"[a-z]+", layer)) for layer in shown.split("->")]
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = settings["tool"]["importlinter"]["contracts"]
    layers = [layer.replace("rustchain.", "").split(" | ") for layer in contract["layers"]]
    assert order == [set(layer) for layer in reversed(layers)]
    package = ROOT / "python" / "rustchain"
    there = {path.stem for path in package.iterdir() if path.is_dir() or path.suffix == ".py"}
    assert {name for name in there if name.strip("_") == name} == set().union(*order)
    for edge in contract["ignore_imports"]:
        assert f"`{edge.split(' -> ')[0].removeprefix('rustchain.')}`" in page


def entries_of_the_tree() -> dict[str, str]:
    """Return the text beside each file of the tree of the architecture page, by its path."""
    page = (ROOT / "docs" / "development" / "architecture.md").read_text(encoding="utf-8")
    tree = page.split("## The tree\n")[1].split("\n## ")[0]
    entries, folders = {}, []
    for line in re.findall(r"^    .*$", tree, re.MULTILINE):
        indent, name, text = re.fullmatch(r"    ( *)(\S+) *(.*)", line).groups()
        folders = [folder for folder in folders if folder[0] < len(indent)]
        if name.endswith("/"):
            folders.append((len(indent), name))
        else:
            entries["".join(folder for _, folder in folders) + name] = text
    return entries


def heading(path: Path) -> str:
    """Return the first paragraph of the documentation of a file of Rust or Python."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return ast.get_docstring(ast.parse(text)).split("\n\n")[0]
    lines = itertools.takewhile(lambda line: line.startswith("//! "), text.splitlines())
    return " ".join(line.removeprefix("//! ") for line in lines)


def test_the_tree_of_the_architecture_has_every_file_with_its_heading():
    entries = entries_of_the_tree()
    shared = {"mod.rs", "tests.rs", "__init__.py"}  # the text of the folder, or unit tests
    files = {
        path.relative_to(ROOT).as_posix(): path
        for folder, ending in (("src", "*.rs"), ("python/rustchain", "*.py"))
        for path in (ROOT / folder).rglob(ending)
        if path.name not in shared
    }
    listed = {entry for entry in entries if entry.startswith(("src/", "python/"))}
    assert [entry for entry in listed if not (ROOT / entry).exists()] == []
    assert files.keys() - listed == set()
    words = re.compile(r"\w+")
    wrong = {
        name: heading(path)
        for name, path in files.items()
        if words.findall(entries[name].lower())
        != words.findall(heading(path).lower())[: len(words.findall(entries[name]))]
    }
    assert wrong == {}
