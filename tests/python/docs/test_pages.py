"""Every Python block of README and docs runs, those of one page one after the other.

The API page has every public name.
"""

import re
from pathlib import Path

import pytest

import rustchain as rc

ROOT = Path(__file__).parents[3]
BLOCK = re.compile(
    r"^```(?:python|\{code-cell\} ipython3)\n(?::tags:[^\n]*\n)?(.*?)^```", re.DOTALL | re.MULTILINE
)
PAGES = [
    page
    for page in (ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md")))
    if BLOCK.search(page.read_text(encoding="utf-8"))
]
SLOW = (
    *("README.md", "outputs.md", "statistics.md", "tutorial.md"),
    *("analytic.md", "codes.md", "published_case.md", "numerical_behaviour.md"),
)


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(
            page,
            marks=[pytest.mark.slow] * (page.name in SLOW),
            id=str(page.relative_to(ROOT)),
        )
        for page in PAGES
    ],
)
def test_the_blocks_of_a_page_run_in_their_order(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = page.read_text(encoding="utf-8")
    names = {"__name__": "__main__"}
    blocks = list(BLOCK.finditer(text))
    assert len(blocks) == len(re.findall(r"^```(?:python|\{code-cell\})", text, re.MULTILINE))
    for block in blocks:
        above = text.count("\n", 0, block.start(1))  # so that a traceback has the page's lines
        try:
            exec(compile("\n" * above + block.group(1), page, "exec"), names)
        except rc.MissingExtra as error:
            if "no library for FMUs" not in str(error):
                raise
            pytest.skip(str(error))  # `make test-python` builds it


def test_the_example_of_the_page_on_files_is_the_file():
    page = (ROOT / "docs" / "reference" / "files.md").read_text(encoding="utf-8")
    block, _ = re.findall(r"^```toml\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    file = (ROOT / "examples" / "three_shafts.toml").read_text(encoding="utf-8")
    assert re.sub(r"^#.*\n+", "", file, flags=re.MULTILINE) == block


LINK = re.compile(r"\]\((?!https?:)([^)#\s]+)[^)\s]*\)")


@pytest.mark.parametrize("folder", [".", "docs"])
def test_every_link_of_a_page_leads_to_a_file(folder):
    pages = (ROOT / folder).glob("**/*.md" if folder == "docs" else "*.md")
    made = ("gallery/index.rst",)  # by the build of the site
    broken = [
        f"{page.relative_to(ROOT)}: {link}"
        for page in pages
        if "_build" not in page.parts
        for link in LINK.findall(page.read_text(encoding="utf-8"))
        if link not in made and not (page.parent / link).exists()
    ]
    assert broken == []


def test_the_api_page_has_every_public_name():
    page = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    listed = re.findall(r"^   ([\w.]+)$", page, re.MULTILINE)
    assert len(set(listed)) == len(listed)
    assert set(rc.__all__) == {name for name in listed if "." not in name}
