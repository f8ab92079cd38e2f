"""Figures of the course that are dragged: on which pages they stand, and what a page loads for them.

Each is a small program of its own in `style/figures`, without a library: it runs from a disk, too. Notebooks
do without them; only the site has them.
"""

from __future__ import annotations

import re
from typing import Any

from surefoot.app.viz import palette

FIGURES = {
    "theory-1-laws": "block",
    "theory-2-cones": "cone",
    "theory-3-lcp": "lcp",
    "theory-7-sharing": "region",
    "theory-6-flight": "cat",
}
"""Page of the course, and the figure on it."""
TITLE = {"en": "Drag it", "zh": "拖动试试"}
ASKED = {
    "block": {
        "en": "Raise the slope by its end, pull at the push: when does the block stick, slide, lift off?",
        "zh": "拖动斜面的端点与推力的箭头：何时粘住、滑动、离地？",
    },
    "cone": {
        "en": "Drag the force between the pyramids and the circle: who errs, and on which side?",
        "zh": "把力拖到棱锥与圆之间：谁判断错了，错在哪一边？",
    },
    "lcp": {
        "en": "Drag q through the four cones, then bend the columns until two of the cones overlap.",
        "zh": "让 q 穿过四个锥，再拖动两列，直到其中两个锥重叠。",
    },
    "region": {
        "en": "Drag feet and centre of mass, tilt the ground: the region is not the span of the feet.",
        "zh": "拖动两足与质心，倾斜每只足下的地面：支撑区域并不等于两足之间。",
    },
    "cat": {
        "en": "Drag the shape around a loop: the body turns, though nothing pushes it.",
        "zh": "让形状走一个闭合回路：没有外力，身体却转了。",
    },
}
COLOURS = {
    f"figure-{name.lower().replace('_', '-')}": getattr(palette, name)
    for name in ("INK", "MUTED", "GRID", "GOOD", "WARN", "BAD", "FORCE", "CONE", "PUSH", "BODY")
} | {"figure-ground": palette.GROUND_LINE}
"""CSS variables of `figures.css`."""
PLACE = "data-figure="


def with_figure(name: str, text: str, language: str) -> str:
    """Return a page's first cell with its figure above its last heading, where it has one."""
    figure = FIGURES.get(name)
    if figure is None:
        return text
    start = [found.start() for found in re.finditer(r"^## ", text, re.MULTILINE)][-1]
    section = f'## {TITLE[language]}\n\n{ASKED[figure][language]}\n\n<div {PLACE}"{figure}"></div>\n\n'
    return text[:start] + section + text[start:]


def load(app: Any, page: str, template: str, context: dict[str, Any], tree: Any) -> None:
    """Have a page load the programs of the figure on it: Sphinx's `html-page-context`."""
    found = re.search(f'{PLACE}"(\\w+)"', context.get("body", ""))
    if found:
        app.add_css_file("figures/figures.css")
        app.add_js_file("figures/stage.js")
        app.add_js_file(f"figures/{found[1]}.js")
