"""What runs inside of a page's kernel: the look of figures, their Chinese twins, values for the texts."""

from __future__ import annotations

import base64
import io
import json
import re
import warnings
from typing import Any

from docs.course import labels

_STYLE = {
    "figure.figsize": (7.0, 3.6),
    "figure.constrained_layout.use": True,
    "figure.dpi": 110,
    "axes.axisbelow": True,
}
_COLOURS = 96
"""Of a kept picture: lines and texts need no more, and files stay small."""
_LEAST, _COLUMN = 12.0, 753.0
"""Height of the smallest text, and width of a page's column on a window of 800 [px]."""
TWIN = "application/x-surefoot-zh+json"
"""Type under which a figure carries its Chinese twin to whoever runs the page."""


def set_up() -> None:
    """Draw in the house's style, show figures in both languages, take warnings for errors."""
    import matplotlib
    from IPython import get_ipython

    from surefoot.app.viz.style import FOOT_COLOURS, house_style

    matplotlib.use("Agg")
    matplotlib.rcdefaults()  # a page before this one may have changed them
    warnings.simplefilter("error")
    warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")
    warnings.filterwarnings("ignore", message="Creating legend with loc")  # says that the machine is busy
    warnings.filterwarnings("ignore", module=r"ipykernel|jupyter_|tornado|zmq|traitlets|IPython")
    house_style().__enter__()
    matplotlib.rcParams.update(_STYLE | {"axes.prop_cycle": matplotlib.cycler(color=FOOT_COLOURS)})
    events = get_ipython().events
    if show_figures not in events.callbacks["post_run_cell"]:
        events.register("post_run_cell", show_figures)


def values(wanted: list[str]) -> None:
    """Print, as JSON, what a text's `expressions` give among the names of the page."""
    from IPython import get_ipython

    names = get_ipython().user_ns
    given = [
        [[str(cell) for cell in row] for row in names[one[5:]]]
        if one.startswith("rows ")
        else eval(f"f'''{{{one}}}'''", names)
        for one in wanted
    ]
    print(json.dumps(given))


def show_figures(_: object = None) -> None:
    """Display pyplot's open figures and close them."""
    from IPython.display import display
    from matplotlib import pyplot

    for number in pyplot.get_fignums():
        figure = pyplot.figure(number)
        make_legible(figure)
        shown, alt = picture(figure), description(figure, "en")
        font = labels.chinese_font()
        left = [word for text in labels.translate(figure, font) for word in labels.left_in_english(text)]
        twin = {"image": picture(figure) if font else shown, "alt": description(figure, "zh"), "left": left}
        data = {"image/png": shown, TWIN: twin, "text/plain": alt}
        display(data, raw=True, metadata={"image/png": {"alt": alt}})
    pyplot.close("all")


def picture(figure: Any) -> str:
    """Return a figure as a PNG of few colours, in base 64."""
    from PIL import Image

    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format="png")
    Image.open(drawn).convert("RGB").quantize(_COLOURS).save(small, "png", optimize=True)
    return base64.b64encode(small.getvalue()).decode("ascii")


def description(figure: Any, language: str) -> str:
    """Return what a figure says in its titles, axes and legends: for whoever does not see it."""
    head, between, over, stop = (
        ("Figure: ", ", ", " over ", ". ") if language == "en" else ("图：", "，", " 对 ", "。")
    )
    parts = []
    for axes in figure.axes:
        _, named = (
            axes.get_legend_handles_labels()
        )  # the artists' own words: a legend's texts are translated, not these
        ticks = [tick.get_text() for tick in (*axes.get_xticklabels(), *axes.get_yticklabels())]
        named += [text for text in ticks if re.search(r"[^\W\d_]{2}", text.replace("mathdefault", ""))]
        written = [] if axes.get_title() or named else [text.get_text() for text in axes.texts]
        names = [
            labels.label(name) if language == "zh" else name for name in dict.fromkeys([*named, *written])
        ]
        said = [axes.get_title(), over.join(filter(None, (axes.get_ylabel(), axes.get_xlabel()))), *names]
        parts.append(between.join(filter(None, said)))
    return head + stop.join(filter(None, parts)).replace("$", "").replace("\n", " ")


def make_legible(figure: Any) -> None:
    """Raise texts to what is 12 px on a window of 800, where the page shrinks a figure to its column."""
    from matplotlib.text import Text

    width = figure.get_figwidth()
    least = _LEAST * 72.0 * width / min(_COLUMN, width * figure.dpi)
    for axes in figure.axes:
        axes.tick_params(labelsize=max([least, *(tick.get_fontsize() for tick in axes.get_xticklabels())]))
    for text in figure.findobj(Text):
        text.set_fontsize(max(text.get_fontsize(), least))
