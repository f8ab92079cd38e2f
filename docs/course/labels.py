"""Figures of the course in Chinese: their labels, titles and legends by the words of labels.yaml."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import yaml

from docs.course.words import CHINESE

_LISTS = yaml.safe_load(Path(__file__).with_name("labels.yaml").read_text(encoding="utf-8"))
PHRASES: dict[str, str] = CHINESE | _LISTS["phrases"]
NAMES = frozenset(" ".join(_LISTS["names"]).split())
"""What is the same in both languages: units, names of robots, solvers, people."""
FONTS = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans SC", "Source Han Sans SC", "WenQuanYi Micro Hei",
    "WenQuanYi Zen Hei", "PingFang SC", "Hiragino Sans GB", "Microsoft YaHei", "SimHei",
)  # fmt: skip
"""Fonts that draw Chinese, as their files name them; the first that is installed is taken."""
_LONGEST_FIRST = sorted(map(re.escape, PHRASES), key=len, reverse=True)
_WORDS = re.compile(rf"(?<!\w)({'|'.join(_LONGEST_FIRST)})(?!\w)".replace(r"\ ", r"\s"))
_COMMA = re.compile(r", (?=[\u4e00-\u9fff])|(?<=[\u4e00-\u9fff]), ")
_FORMULA = re.compile(r"\$.*?\$")
_WORD = re.compile(r"[A-Za-z]\w+", re.ASCII)


@cache
def chinese_font() -> str | None:
    """Return the name of an installed font with Chinese, or None."""
    from matplotlib.font_manager import findSystemFonts, fontManager

    for path in set(findSystemFonts()) - {font.fname for font in fontManager.ttflist}:
        with suppress(
            OSError, RuntimeError
        ):  # installed since matplotlib wrote its list, or none that it reads
            fontManager.addfont(path)
    there = {font.name for font in fontManager.ttflist}
    return next((name for name in FONTS if name in there), None)


def label(text: str) -> str:
    """Return a figure's text in Chinese: the longest phrases of the list first, the rest as it is."""
    return _COMMA.sub("，", _WORDS.sub(lambda found: PHRASES[" ".join(found[1].split())], text))


def left_in_english(text: str) -> list[str]:
    """Return the words of a Chinese label that are neither translated nor names, units, formulas."""
    return [word for word in _WORD.findall(_FORMULA.sub("", text)) if word not in NAMES]


def translate(figure: Any, font: str | None) -> list[str]:
    """Put a figure's words into Chinese, in place, drawn with a font; return all that it says."""
    from matplotlib.text import Text

    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            _translate_ticks(axis)
    texts = [text for text in figure.findobj(Text) if text.get_text()]
    for text in texts:
        text.set_text(label(text.get_text()))
        if font and not text.get_text().isascii():  # a line with a formula takes the first font for all of it
            text.set_family([font] if "$" in text.get_text() else [*text.get_family(), font])
    return [text.get_text() for text in texts]


def _translate_ticks(axis: Any) -> None:
    """Translate ticks that are words; numbers stay with the axis's own formatter."""
    from matplotlib.ticker import FixedFormatter, FixedLocator

    said = [tick.get_text() for tick in axis.get_ticklabels()]
    if said != [label(text) for text in said]:
        axis.set_major_locator(FixedLocator(axis.get_majorticklocs()))
        axis.set_major_formatter(FixedFormatter([label(text) for text in said]))
