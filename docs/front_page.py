"""What of the front page is made: the bars of speed, and how to install.

Run: python -m docs.front_page writes both; with --check nothing is written, and the exit code is 1 if one of
them says something else. The bars are the numbers of docs/tables/readme.json, which `python -m docs.tables
readme` measures.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from pathlib import Path
from typing import NamedTuple

from surefoot.app.viz import palette

DOCS = Path(__file__).resolve().parent
README, BARS, TABLE = (
    DOCS.parent / "README.md",
    DOCS / "images" / "speed.svg",
    DOCS / "tables" / "readme.json",
)
RELEASED = False
"""Whether the index has a release: it decides how to install. Set it with the first one."""
INSTALL = {
    True: "pip install 'surefoot[all]'",
    False: "pip install -e '.[all]'   # in a checkout, or the built wheel, until there is a release",
}
PLACE = re.compile(r"<!-- install -->\n.*?<!-- end of install -->", re.DOTALL)
QUESTIONS = {
    "share a wrench": "share a wrench among four feet",
    "can it stand": "can it stand on four feet?",
    "solve a contact problem": "solve a contact problem to 1e-9",
    "plan ten steps": "plan ten steps of a trot (MPC)",
}
"""Beginnings of the table's questions, and what the bars call them."""
SHOWN = {"its ADMM": "Pinocchio's ADMM", "with Anderson acceleration": "... and Anderson acceleration"}
"""Rivals whose name in the table needs the one before."""
TIMED = re.compile(r"(?:^|; |: )(?P<who>[^;:]*?),? (?P<time>[\d.]+)(?:, [\d.]+)* µs")
OURS, RIVAL = palette.CONE, palette.blend(palette.MUTED, palette.PAPER, 0.4)
LEFT, WIDTH, ROW, GAP = 250, 430, 19, 15


class Bar(NamedTuple):
    """One bar: whose, how long [µs], and whether it is ours."""

    who: str
    time: float
    ours: bool


def groups(rows: list[list[str]]) -> dict[str, list[Bar]]:
    """Return the bars of each question of the table, ours first: the first of several times of a cell."""
    found: dict[str, list[Bar]] = {}
    for question, ours, rivals, *_ in rows:
        name = next((said for start, said in QUESTIONS.items() if question.startswith(start)), None)
        if name is None:
            continue
        bars = [Bar("Surefoot, exact", float(ours.split(";")[0]), ours=True)]
        text = re.sub(r" \(\d+ of \d+\)", "", rivals)
        bars += [
            Bar(SHOWN.get(m["who"].strip(), m["who"].strip()), float(m["time"]), ours=False)
            for m in TIMED.finditer(text)
        ]
        found[name] = bars
    return found


def drawing(rows: list[list[str]]) -> str:
    """Return the bars as SVG, lengths by the logarithm of the time."""
    found = groups(rows)
    times = [bar.time for bars in found.values() for bar in bars]
    low, high = 10.0 ** math.floor(math.log10(min(times))), max(times)
    scale = WIDTH / math.log10(high / low)
    out, y = [], 28
    for name, bars in found.items():
        out.append(f'<text x="0" y="{y}" font-size="13" font-weight="bold">{name}</text>')
        y += 6
        for bar in bars:
            length = max(2.0, scale * math.log10(bar.time / low))
            colour = OURS if bar.ours else RIVAL
            out.append(f'<text x="{LEFT - 8}" y="{y + 13}" text-anchor="end">{bar.who}</text>')
            out.append(
                f'<rect x="{LEFT}" y="{y + 2}" width="{length:.1f}" height="14" rx="2" fill="{colour}"/>'
            )
            out.append(f'<text x="{LEFT + length + 6:.1f}" y="{y + 13}">{bar.time:g} µs</text>')
            y += ROW
        y += GAP + 12
    size = f'width="{LEFT + WIDTH + 90}" height="{y}" viewBox="0 0 {LEFT + WIDTH + 90} {y}"'
    words = "median on one core, logarithmic: shorter is faster"
    note = f'<text x="{LEFT}" y="{y - 8}" fill="{palette.MUTED}">{words}</text>'
    style = f'font-family="Helvetica, Arial, sans-serif" font-size="12" fill="{palette.INK}"'
    parts = "\n".join([*out, note])
    paper = '<rect width="100%" height="100%" fill="white"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} {style}>\n{paper}\n{parts}\n</svg>\n'


def with_install(page: str) -> str:
    """Return the front page with the line that installs what there is."""
    text = f"<!-- install -->\n```bash\n{INSTALL[RELEASED]}\n```\n<!-- end of install -->"
    return PLACE.sub(lambda _: text, page)


def main(arguments: list[str] | None = None) -> int:
    """Write what is made, or check it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit code 1 if something is old")
    check = parser.parse_args(arguments).check
    rows = json.loads(TABLE.read_text(encoding="utf-8"))["rows"]
    made = {BARS: drawing(rows), README: with_install(README.read_text(encoding="utf-8"))}
    old = [path for path, text in made.items() if not path.exists() or path.read_text("utf-8") != text]
    for path in old:
        print(f"{path.name} is old: run python -m docs.front_page" if check else f"{path.name} written")
        if not check:
            path.write_text(made[path], encoding="utf-8")
    return 1 if check and old else 0


if __name__ == "__main__":
    sys.exit(main())
