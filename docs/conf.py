"""Configuration of the documentation site: `make docs`."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import rustchain as rc

DOCS = Path(__file__).parent
ROOT = DOCS.parent

project = "rustchain"
author = "the rustchain developers"
copyright = author
version = release = rc.__version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = [
    "_build",
    "_examples",
    "gallery/**.ipynb",
    "gallery/**.py",
    "reference/_cli.md",
]
templates_path = ["_templates"]
default_role = "py:obj"
suppress_warnings = [
    "config.cache",  # of the function in sphinx_gallery_conf, which cannot be pickled
]

# --- pages in Markdown

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4
myst_links_external_new_tab = False
nb_execution_mode = "force"  # of pages with code cells: the tutorial, validation
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True
# The pages on validation call the checks and references of the tests.
os.environ["PYTHONPATH"] = os.pathsep.join(
    [str(ROOT / "tests" / "python"), os.environ.get("PYTHONPATH", "")]
)
nb_ipywidgets_js: dict[str, Any] = {}  # nothing is loaded from the network

# --- reference of the Python package

autosummary_generate = True
autodoc_typehints = "none"  # docstrings have the types
autodoc_member_order = "bysource"
toc_object_entries_show_parents = "hide"  # the sidebar is narrow
numpydoc_show_class_members = False  # the template of classes lists them

HELP = subprocess.run(  # from the help texts of the commands
    [sys.executable, "-m", "typer", "rustchain.cli.app", "utils", "docs", "--name", "rustchain"],
    check=True,
    capture_output=True,
    encoding="utf-8",
).stdout
# The list of commands has their first sentences, which typer cuts short.
for name, sentence in re.findall(r"^## `rustchain (\w+)`\n\n(.+?\.)\s", HELP, re.MULTILINE):
    HELP = re.sub(rf"^\* `{name}`: .*", f"* `{name}`: {sentence}", HELP, flags=re.MULTILINE)
(DOCS / "reference" / "_cli.md").write_text(HELP.partition("\n")[2], encoding="utf-8")  # no title

# --- other projects; the inventories hold the names that docstrings use

intersphinx_mapping = {
    name: (address, str(DOCS / "_inventories" / f"{name}.inv"))
    for name, address in {
        "matplotlib": "https://matplotlib.org/stable",
        "numpy": "https://numpy.org/doc/stable",
        "pandas": "https://pandas.pydata.org/docs",
        "python": "https://docs.python.org/3",
        "scipy": "https://docs.scipy.org/doc/scipy",
        "xarray": "https://docs.xarray.dev/en/stable",
    }.items()
}

# --- gallery: scripts save their pictures beside themselves, so that copies run

EXAMPLES = DOCS / "_examples"
for script in (ROOT / "examples").rglob("*.*"):
    copy = EXAMPLES / script.relative_to(ROOT / "examples")
    copy.parent.mkdir(parents=True, exist_ok=True)
    text = script.read_text(encoding="utf-8")
    if script.suffix == ".py":  # the first sentence of the docstring is the title of the page
        title, _, rest = text.removeprefix('"""').partition("\n")
        title = title.removesuffix('"""').removesuffix(".")
        closed = '\n"""' if text.partition("\n")[0].endswith('"""') else ""
        text = f'"""{title}\n{"=" * len(title)}{closed}\n{rest}'
    copy.write_text(text, encoding="utf-8")


def saved_pictures(
    block: tuple[str, str, int], variables: dict[str, Any], gallery: dict[str, Any]
) -> str:
    """Take the pictures that a script has saved into its page."""
    from sphinx_gallery.scrapers import figure_rst

    taken = []
    paths = variables["image_path_iterator"]
    for picture in sorted(Path(variables["src_file"]).parent.glob("*.png")):
        place = next(paths)
        shutil.move(picture, place)
        taken.append(place)
    return figure_rst(taken, gallery["src_dir"])


sphinx_gallery_conf = {
    "examples_dirs": str(EXAMPLES),
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "image_scrapers": (saved_pictures,),
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,  # a page that loads scripts from the network
    "show_signature": False,
    "remove_config_comments": True,
    "abort_on_example_error": True,
}

# --- look

html_theme = "pydata_sphinx_theme"
html_title = "rustchain"
html_context = {"default_mode": "auto"}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_theme_options = {
    "header_links_before_dropdown": 9,
    "navbar_align": "left",
    "navbar_persistent": [],
    "navbar_end": ["search-button", "theme-switcher"],
    "navigation_with_keys": False,
    "show_prev_next": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_sidebars = {page: [] for page in ("index", "tutorial", "reliability", "changelog")}
