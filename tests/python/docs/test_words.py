"""Prose of README, pages and docstrings: the terms of the glossary, sentences of limited length.

`python tests/python/docs/test_words.py` lists the findings, and sentences over `ADVISED` words.
"""

import ast
import re
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[3]

# Regular expression of a wording that the project does not use, and the term that replaces it.
TERMS = {
    r"worked[- ]in\b": "external work",
    r"missing energy|balance(?:'s)? (?:misses|lacks)|energy (?:that is|is) missing": (
        "energy balance residual"
    ),
    r"contacts? (?:begins?|began|opens?|opened)\b|came to be": "contact onset",
    r"approach speed": "initial impact velocity",
    r"\bremembers?\b|\bremembered\b": "impact velocity memory, or: stores",
    r"how(?:ever)? deep\b|\bm deep\b": "penetration",
    r"\bfloor (?:of|speed)\b": "minimum impact velocity",
    r"\bwhat (?:came of|went wrong|was measured|turned out)\b": "outcome, error, measured value",
    r"\bgoes on\b|\bcannot go on\b": "continues",
    r"(?<!radial )(?<!joint )\bplay\b(?! (?:button|back))": "radial play, clearance",
    r"\bis pressed by\b|\bwas pressed by\b|\bpulls?\b": "contact force, tension, tensile force",
    r"chain's way|\b(?:along|of) (?:the|its|a) way\b|guide's way": "chain path, guide path",
    r"\blaid\b": "initial configuration, generated",
    r"auto's choice|\bvotes?\b|\bpatience\b": "corrector switching",
    r"\bforet(?:old|ells?)\b|prediction continued": "predicted value",
    r"\bsteps? stands?\b|\ba try\b|\bdoubt\b": "accepted step, error estimate",
    r"\ba look\b|\blooks at\b": "evaluation of the right-hand side",
    r"turned (?:round|back)\b|unseen touch|\bwatched\b": "located event, event screening",
    r"\boctets?\b|registers? of numbers|several numbers at once": "SIMD vector, lane, width",
    r"\btwin\b": "scalar reference implementation",
    r"\brivals?\b": "reference solver, other solvers",
    r"inside (?:the last|a|the|each|one) step\b": "dense output, within a step",
    r"\bhand(?:ed|s) on\b|carr(?:ied|ies) on\b": "checkpoint, restart",
    r"\bmeter(?:s|ed)\b": "energy quadrature, integrates",
    r"\bsoften(?:s|ed|ing)?\b|\bspun\b": "compliance block, compliant",
    r"\brub(?:s|bed|bing)?\b": "friction, sliding velocity",
    r"\bloose ends?\b": "free end",
    r"slightly different runs": "replicate runs",
    r"(?:range|balance) notes?\b": "law warnings, energy warnings",
    r"engineers? reads?\b": "post-processing",
    r"cannot do yet": "limitations",
    r"\boil(?:ed|s)?\b": "lubricant",
    r"\b(?:knows|feels|asks|wants|tells|says|reckons)\b": (
        "a verb that fits a thing: contains, is subject to, requires, reports, assumes"
    ),
    r"\basked for\b|\bwhat it costs\b|\bsays otherwise\b": "requested, run time, is given",
    r"\bto and fro\b|\banew\b|\bbesides\b|\bthereof\b|\bwherein\b": "plain words",
}
OLD_NAMES = r"\brc\.(?:Anchor|Load|LooseEnd|Film)\b|\bLooseEnd\b|\brestitution_obtained\b"
FOR_DEVELOPERS = r"\bregisters\b|\bkernels?\b"  # words that pages for users do not have
PAGES_FOR_USERS = ("README.md", "docs/tutorial.md", "docs/howto/", "docs/reference/")

LIMIT = 30  # words of the longest sentence
LIMIT_FOR_USERS = 25  # of the pages that a user reads first
READ_FIRST = ("README.md", "docs/tutorial.md", "docs/howto/")
AVERAGE = 12.5  # words of a sentence
ADVISED = 25  # words; longer sentences are counted
WRITTEN_BY_A_PROGRAM = ("docs/performance/work-precision-tables.md",)
ABBREVIATION = re.compile(r"\b(?:e\.g|i\.e|cf|Fig|Figs|Eq|Eqs|No|vol|pp|et al|vs|resp)\.$")
# Beginning of a sentence: a capital, a number, code, a symbol, or a name in lower case.
CAPITAL = r"[\"'(\[*_]*[A-Z0-9`µαμψσωΔδλ]|[\"\[]|(?:rustchain|exudyn|[a-zθ] is)\b"
END = re.compile(rf"(?<=[.!?])[\"')\]*_]*\s+(?={CAPITAL})")


class Sentence(NamedTuple):
    """One sentence, or one cell or heading, of a file."""

    file: str
    line: int
    text: str
    whole: bool  # a sentence, not a cell or a heading

    @property
    def words(self) -> int:
        return len(re.findall(r"[^\s]*[A-Za-z0-9`À-ʯͰ-Ͽ][^\s]*", self.text)) if self.whole else 0

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}"


def plain(text):
    """Return prose in which a piece of code, a formula and a link's text are left, each short."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\](?:\([^)]*\)|\[[^\]]*\])", r"\1", text)
    text = re.sub(r"(?::[\w:]+:)?(`+)([^`]|(?!\1)`)+\1_*", "`x`", text)
    return re.sub(r"\s+", " ", text).strip()


def sentences(file, blocks):
    """Split blocks (line, text, whole) at full stops."""
    for line, text, whole in blocks:
        begin = 0
        for end in [*END.finditer(text), None]:
            if end is not None and ABBREVIATION.search(text[: end.start()]):
                continue
            piece = text[begin : end.start() if end else None]
            if prose := plain(piece):
                yield Sentence(file, line + text.count("\n", 0, begin), prose, whole)
            begin = end.end() if end else len(text)


def gathered(lines, separate):
    """Join lines to blocks (line, text, whole).

    `separate` returns for a line: None, the line is no prose and ends a block; a text that begins a
    block; a text that continues one; a text that stands alone.
    """
    blocks, open_block = [], False
    for number, line in lines:
        kind, text = separate(line)
        if kind == "continues" and open_block:
            first, so_far, whole = blocks[-1]
            blocks[-1] = (first, f"{so_far}\n{text}", whole)
        elif kind != "none":
            blocks.append((number, text, kind != "alone"))
        open_block = kind in ("begins", "continues")
    return blocks


def line_of_page(line):
    """Classify one line of Markdown outside blocks of code."""
    bare = line.strip()
    if not bare or re.match(r"(?:    (?![ ]*[-*] )|\t|<|:{3}|\{|:[\w-]+:|---+$|\(\w+\)=)", line):
        return "none", ""
    if bare.startswith("|"):
        cells = "" if re.fullmatch(r"[|:\- ]+", bare) else bare.strip("|")
        return "alone", cells
    if bare.startswith("#"):
        return "alone", bare.lstrip("# ")
    if item := re.match(r"(?:[-*+]|\d+\.)\s+(.*)", bare):
        return "begins", item[1]
    return "continues", bare


def blocks_of_page(text):
    """Return the blocks of prose of a page of Markdown; a fenced block is no prose."""
    lines, fence, item = [], None, False
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(```+|~~~+)", line)
        if fence:
            fence = None if mark and mark[1].startswith(fence) else fence
            lines.append((number, ""))
        elif mark:
            fence = mark[1]
            lines.append((number, ""))
        else:
            item = bool(re.match(r"\s*(?:[-*+]|\d+\.)\s", line)) or (
                item and (not line or line.startswith("  "))
            )
            lines.append((number, line.strip() if item else line))
    return gathered(lines, line_of_page)


def line_of_docstring(line):
    """Classify one line of a docstring in numpydoc's form."""
    bare = line.strip()
    if not bare or bare.startswith((">>>", "...", "..", "---", ":", "|")):
        return "none", ""
    if re.match(r"[\w*., `]+ : \S", bare):  # name and type
        return "none", ""
    if item := re.match(r"(?:[-*+]|\d+\.)\s+(.*)", bare):
        return "begins", item[1]
    return "continues", bare


def blocks_of_docstrings(text):
    """Return the blocks of prose of the docstrings of a module."""
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, documented) or ast.get_docstring(node) is None:
            continue
        docstring = node.body[0].value
        lines, literal, printed, depth = [], None, False, 0
        for number, line in enumerate(docstring.value.expandtabs().splitlines(), docstring.lineno):
            indent = len(line) - len(line.lstrip())
            if literal is not None and line.strip() and indent <= literal:
                literal = None
            printed = line.strip().startswith((">>>", "...")) or (printed and bool(line.strip()))
            hidden = literal is not None or printed
            if lines and indent != depth and line.strip():
                lines.append((number, ""))  # a change of indentation ends a block
            depth = indent if line.strip() else depth
            lines.append((number, "" if hidden else line))
            if line.rstrip().endswith("::"):
                literal = indent
        yield from gathered(lines, line_of_docstring)


def pages():
    """Yield the pages of Markdown that are checked."""
    for page in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(ROOT.glob("docs/**/*.md"))):
        file = page.relative_to(ROOT).as_posix()
        if "_build" not in page.parts and not file.startswith(WRITTEN_BY_A_PROGRAM):
            yield file, page.read_text(encoding="utf-8")


def prose():
    """Yield every sentence of README, of the pages and of the package's docstrings."""
    for file, text in pages():
        yield from sentences(file, blocks_of_page(text))
    for module in sorted(ROOT.glob("python/rustchain/**/*.py")):
        file = module.relative_to(ROOT).as_posix()
        yield from sentences(file, blocks_of_docstrings(module.read_text(encoding="utf-8")))


SENTENCES = list(prose())


def unwanted(wording):
    return [
        f"{one}\n    found: {hit[0]!r}"
        for one in SENTENCES
        for hit in [re.search(wording, one.text, re.IGNORECASE)]
        if hit
    ]


@pytest.mark.parametrize(("wording", "term"), TERMS.items(), ids=TERMS.values())
def test_the_words_of_the_glossary_are_used(wording, term):
    found = unwanted(wording)
    assert not found, "\n".join([f"use: {term}", *found])


def test_old_names_are_not_used_in_code_either():
    assert [(file, hit[0]) for file, text in pages() for hit in re.finditer(OLD_NAMES, text)] == []


def test_pages_for_users_leave_out_words_for_developers():
    hits = [hit for hit in unwanted(FOR_DEVELOPERS) if hit.startswith(PAGES_FOR_USERS)]
    assert not hits, "\n".join(hits)


def test_no_sentence_is_longer_than_the_limit():
    long = [
        f"{one} ({one.words} words of at most {limit})"
        for one in SENTENCES
        for limit in [LIMIT_FOR_USERS if one.file.startswith(READ_FIRST) else LIMIT]
        if one.words > limit
    ]
    assert not long, "\n".join(long)


def test_sentences_are_short_on_average():
    lengths = [one.words for one in SENTENCES if one.words]
    assert sum(lengths) / len(lengths) <= AVERAGE


if __name__ == "__main__":
    for wording, term in TERMS.items():
        for one in unwanted(wording):
            sys.stdout.write(f"use {term}: {one}\n")
    above = Counter(one.file for one in SENTENCES if one.words > ADVISED)
    for one in sorted(SENTENCES, key=lambda one: -one.words):
        if one.words > ADVISED:
            sys.stdout.write(f"{one.words} words: {one}\n")
    for file, number in above.most_common():
        sys.stdout.write(f"{number:4} of {sum(o.file == file for o in SENTENCES)}: {file}\n")
