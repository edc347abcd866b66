"""How the documentation is built: ``python -m sphinx -W -n -b html docs docs/_build/html``."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl

import roughcontact
from roughcontact.formats import export, read

if TYPE_CHECKING:
    from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path += [str(HERE / "_ext"), str(HERE.parent / "benchmarks"), str(HERE.parent / "calibration")]
mpl.use("Agg")

project = "roughcontact"
author = "the roughcontact developers"
copyright = "the roughcontact developers, BSD 3-Clause License"  # noqa: A001 - Sphinx's name
version = release = roughcontact.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "matplotlib.sphinxext.plot_directive",
    "sphinx_gallery.gen_gallery",
    "mathml",
    "crossrefs",
]
root_doc = "index"
exclude_patterns = ["_build", "gallery", "generated"]
nitpicky = True
# Types in docstrings are words, and inventories of other projects would need the network: what
# is left to resolve are the names of this package.
nitpick_ignore_regex = [
    (
        "py:.*",
        r"(numpy|np|matplotlib|xarray|click|pathlib|enum|collections|concurrent|typing|io|functools)"
        r"\..*",
    ),
    ("py:.*", r"(panel|bokeh|tornado)\..*"),
    ("py:.*", r".*\.T_co"),
    # Private base classes have no page.
    ("py:class", r"roughcontact\..*\._[A-Z]\w*"),
    ("py:.*", r"(ValueError|MemoryError|RuntimeError|Exception|NamedTuple|Protocol|Enum|Path)"),
]

default_role = "py:obj"
add_module_names = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist", "attrs_inline"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

html_theme = "furo"
html_title = f"roughcontact {release}"
html_static_path = ["_static"]
html_css_files = ["style.css"]
html_show_sourcelink = False

plot_include_source = False
plot_html_show_source_link = False
plot_html_show_formats = False
plot_formats = [("png", 130)]
plot_rcparams = {"figure.autolayout": False, "savefig.bbox": "tight", "font.size": 10}
plot_apply_rcparams = True

sphinx_gallery_conf = {
    "examples_dirs": "gallery",
    "gallery_dirs": "examples",
    "filename_pattern": r"plot_\d\d_",
    "image_scrapers": ("figure_objects.scraper",),
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "remove_config_comments": True,
    "capture_repr": (),
    "show_memory": False,
    "min_reported_time": 1e9,
    "download_all_examples": False,
    "copyfile_regex": r".*\.toml",
    "doc_module": (),
    "write_computation_times": False,
    "matplotlib_animations": False,
}


def _prepare(app: Sphinx) -> None:
    """Write the generated tables, and the pictures of the page in the browser."""
    generated = HERE / "generated"
    generated.mkdir(exist_ok=True)
    subprocess.run(
        [sys.executable, str(HERE / "pages.py"), str(generated)], check=True, timeout=600
    )
    about = tomllib.loads((HERE / "formats.toml").read_text(encoding="utf-8"))
    rows = sorted(
        (
            about[known.name]["maker"],
            ", ".join(f"`{suffix}`" for suffix in known.suffixes),
            f"`{known.name}`",
            *(about[known.name][key] or "–" for key in ("read", "not", "checked")),
        )
        for known in read.FORMATS
    )
    heads = "maker or program", "suffixes", "`format`", "read", "not read", "checked on"
    _table(generated / "suffixes.md", heads, rows)
    explanations = Path(roughcontact.__file__).with_name("explanations.toml")
    paragraphs = tomllib.loads(explanations.read_text(encoding="utf-8"))
    (generated / "messages.md").write_text(
        "".join(f"## {tag}\n\n{_index_symbols(paragraphs[tag])}\n\n" for tag in sorted(paragraphs)),
        encoding="utf-8",
    )
    for name, tables in (
        ("maps", {"holds": export.SURFACE}),
        ("results", {"with the volume": export.VOLUME, "of a contact": export.CONTACT}),
    ):
        rows = [
            (f"`{suffix}`", *(_words(table, suffix) for table in tables.values()))
            for suffix in next(iter(tables.values())).suffixes
        ]
        _table(generated / f"{name}.md", ("suffix", *tables), rows)


def _words(table: export.FormatTable, suffix: str) -> str:
    return table.contents[suffix].words if suffix in table.contents else "–"


def _table(path: Path, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    """Write a table in Markdown."""
    lines = [head, ("---",) * len(head), *rows]
    text = "".join(f"| {' | '.join(cells)} |\n" for cells in lines)
    path.write_text(text, encoding="utf-8")


def _set_indices(app: Sphinx, name: str, source: list[str]) -> None:
    """Set the indices of symbols on pages in Markdown."""
    if app.env.doc2path(name).suffix == ".md":
        source[0] = _index_symbols(source[0])


def _index_symbols(text: str) -> str:
    """Set the indices of symbols, which pages hold as they are typed, but not in code."""
    parts = re.split(r"(^```.*?^```$|`[^`\n]+`)", text, flags=re.DOTALL | re.MULTILINE)
    for letter, index in ("σ", "Y"), ("P", "c"), ("p", "y"):
        set_as = f"{letter}{{sub}}`{index}`"
        parts[::2] = (part.replace(f"{letter}_{index}", set_as) for part in parts[::2])
    return "".join(parts)


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the pages of the modules, which Sphinx has to find, and connect the preparation."""
    import api_pages

    generated = HERE / "api" / "generated"
    generated.mkdir(exist_ok=True)
    (HERE / "api" / "modules.rst").write_text(api_pages.modules_page(), encoding="utf-8")
    pages = {"public.txt": api_pages.public_table(), **api_pages.module_pages()}
    for path in generated.iterdir():
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        (generated / name).write_text(text, encoding="utf-8")
    app.connect("source-read", _set_indices)
    app.connect("builder-inited", _prepare, priority=100)
    return {"parallel_read_safe": True}
