"""Run the code of a course page, and fill its texts with what came out."""

from __future__ import annotations

import io
import re
import warnings
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from docs.site import labels, words
from docs.site.page import HEADINGS, LANGUAGES, Page

_VALUE = re.compile(r"\{\{(.+?)\}\}")
_STYLE = {
    "figure.figsize": (7.0, 3.6),
    "figure.constrained_layout.use": True,
    "figure.dpi": 110,
    "axes.axisbelow": True,
}

_LEAST, _COLUMN = 12.0, 753.0
"""Height of the smallest text, and width of a page's column on a window of 800 [px]."""


@dataclass
class Ran:
    """A page that was run: finished pieces by language, its names, and what its Chinese figures say.

    Each piece is (kind, text): "markdown", "code", "output" or "figure" (its file's name).
    """

    page: Page
    pieces: dict[str, list[tuple[str, str]]] = field(default_factory=lambda: {k: [] for k in LANGUAGES})
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})
    labels: list[str] = field(default_factory=list)


def run_page(page: Page, figures: Path | None = None) -> Ran:
    """Run a page block after block.

    Parameters
    ----------
    page
        From `read_page`.
    figures
        Folder for its pictures; None draws them and saves none.
    """
    import matplotlib

    from surefoot.app.viz.style import FOOT_COLOURS, house_style

    matplotlib.use("Agg")
    ran, count = Ran(page), 0
    style = _STYLE | {"axes.prop_cycle": matplotlib.cycler(color=FOOT_COLOURS)}
    with house_style(), matplotlib.rc_context(style):
        for part in page.parts:
            if part.kind == "heading":
                for language in LANGUAGES:
                    ran.pieces[language].append(("markdown", f"## {HEADINGS[part.text][language]}"))
            elif part.kind == "code":
                printed = _execute(page, part.text, part.line, ran.names)
                pieces = [("code", part.text.rstrip())] + ([("output", printed)] if printed else [])
                for language in LANGUAGES:
                    ran.pieces[language] += pieces
                for figure in _open_figures():
                    count += 1
                    _keep_figure(ran, figure, f"{page.name}-{count}", figures)
            else:
                ran.pieces[part.kind].append(("markdown", filled(part.text.strip(), ran.names, part.kind)))
    return ran


def _keep_figure(ran: Ran, figure: Any, name: str, folder: Path | None) -> None:
    """Save a figure as it is, and again in Chinese where a font for it is installed."""
    font, files = labels.chinese_font(), {"en": f"{name}.png", "zh": f"{name}.png"}
    if ran.page.name.startswith("theory-"):
        make_legible(figure)
    if folder is not None:
        figure.savefig(folder / files["en"])
    ran.labels += labels.translate(figure, font)
    if font is not None:
        files["zh"] = f"{name}-zh.png"
        if folder is not None:
            figure.savefig(folder / files["zh"])
    for language in LANGUAGES:
        ran.pieces[language].append(("figure", files[language]))


def make_legible(figure: Any) -> None:
    """Raise texts to what is 12 px on a window of 800, where the page shrinks a figure to its column."""
    from matplotlib.text import Text

    width = figure.get_figwidth()
    least = _LEAST * 72.0 * width / min(_COLUMN, width * figure.dpi)
    for axes in figure.axes:
        axes.tick_params(labelsize=max([least, *(tick.get_fontsize() for tick in axes.get_xticklabels())]))
    for text in figure.findobj(Text):
        text.set_fontsize(max(text.get_fontsize(), least))


def _execute(page: Page, code: str, line: int, names: dict[str, Any]) -> str:
    """Run a block whose first line is behind `line` of the page's file; return what it printed."""
    printed = io.StringIO()
    with redirect_stdout(printed), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")
        exec(compile("\n" * line + code, f"course/{page.name}.md", "exec"), names)
    return printed.getvalue().rstrip()


def _open_figures() -> list[Any]:
    """Return pyplot's open figures and close them."""
    from matplotlib import pyplot

    found = [pyplot.figure(number) for number in pyplot.get_fignums()]
    pyplot.close("all")
    return found


def filled(text: str, names: dict[str, Any], language: str = "en") -> str:
    """Return a text with every `{{expression:format}}` replaced by its value, its words translated."""
    return "\n".join(_line(line, names, language) for line in text.splitlines())


def _line(line: str, names: dict[str, Any], language: str) -> str:
    whole = re.fullmatch(r"\{\{(\w+)\}\}", line)
    if whole and isinstance(names[whole[1]], list):
        rows = [[words.cell(str(cell), language) for cell in row] for row in names[whole[1]]]
        return "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return _VALUE.sub(lambda found: words.value(eval(f"f'''{{{found[1]}}}'''", names), language), line)
