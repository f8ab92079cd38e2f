"""Sphinx's configuration of the site; `python -m docs.site` builds both languages with it."""

from __future__ import annotations

import re
from typing import Any

from docutils.nodes import SkipNode
from docutils.utils.math.latex2mathml import tex2mathml
from pygments.lexers.special import TextLexer

import surefoot
from docs.site import figures
from docs.site.search import SearchPairs
from surefoot.app.viz import palette

project = "Surefoot"
author = "the Surefoot authors"
copyright = "the Surefoot authors, Apache-2.0"
version = release = surefoot.__version__
language = "en"  # the Chinese tree is built with -D language=zh_CN
html_search_language = "pairs"  # SearchPairs, in both trees

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb", ".rst": "restructuredtext"}
exclude_patterns = ["**/notebooks/*", "notebooks/*"]  # as they are in the repository, to download
nb_execution_mode = (
    "off"  # the course keeps its outputs: python -m docs.course --check says whether they are current
)
nb_mime_priority_overrides = [("html", "image/png", 0)]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence", "dollarmath"]
html_math_renderer = "mathml"  # which browsers draw themselves: no script, nothing from outside
suppress_warnings = [
    "toc.not_included",  # pages that are only linked to
    "ref.python",  # an attribute of several classes, in a signature
]
default_role = "literal"

napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
_ALIASES = ("ArrayLike", "FloatArray", "IntArray", "BoolArray", "Fit", "Cone", "Contact", "Terrain")
autodoc_type_aliases = {name: name for name in _ALIASES}
python_maximum_signature_line_length = 90
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = "Surefoot"
html_show_sphinx = False
html_copy_source = False
html_static_path = ["style"]
html_css_files = ["surefoot.css"]
html_js_files = ["offline.js"]
BRAND = ("color-brand-primary", "color-brand-content")
html_theme_options = {
    "sidebar_hide_name": False,
    "light_css_variables": figures.COLOURS | dict.fromkeys(BRAND, palette.CONE),
    "dark_css_variables": figures.COLOURS
    | dict.fromkeys(BRAND, palette.blend(palette.CONE, palette.PAPER, 0.6)),
}
pygments_style = "friendly"
pygments_dark_style = "monokai"


_CODE = re.compile(r"(`[^`]*`)")
_SOURCE = re.compile(r"^\.\. (\[\d+\]) ")
_CITED = re.compile(r"(\[\d+\])_")


def _plain(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Make reStructuredText of a docstring where the two differ.

    |x| stays an absolute value, numbered sources become a list (many docstrings share a page), and attributes
    that are told of together stay together.
    """
    section = ""
    for k, line in enumerate(lines):
        if k and re.fullmatch("-{3,}", line):
            section = lines[k - 1]
        if section == "Attributes" and line[:1].isidentifier():
            lines[k] = line = line.replace(", ", ",")
        lines[k] = line = _CITED.sub(r"\1", _SOURCE.sub(r"*  \1 ", line))
        if "|" in line and not line.lstrip().startswith((">>>", "...")):
            parts = _CODE.split(line)
            lines[k] = "".join(p if p.startswith("`") else p.replace("|", "\\|") for p in parts)


def _no_tuple_fields(app: Any, what: str, name: str, thing: Any, skip: bool, options: Any) -> bool | None:
    """Leave out the fields of named tuples: their class says what they are."""
    return True if str(getattr(thing, "__doc__", "")).startswith("Alias for field number") else None


def _math(translator: Any, node: Any) -> None:
    """Write a formula as MathML."""
    block = node.tagname == "math_block"
    written = tex2mathml(node.astext(), as_block=block)
    translator.body.append(f'<div class="math">{written}</div>' if block else written)
    raise SkipNode


def setup(app: Any) -> None:
    """Register with Sphinx."""
    app.add_search_language(SearchPairs)
    app.add_lexer("mermaid", TextLexer)  # diagrams that the repository's page draws
    app.add_html_math_renderer("mathml", (_math, None), (_math, None))
    app.connect("html-page-context", figures.load)
    app.connect("autodoc-skip-member", _no_tuple_fields)
    app.connect("autodoc-process-docstring", _plain, priority=400)  # before napoleon
