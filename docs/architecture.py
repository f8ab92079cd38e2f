"""Draw docs/images/architecture.svg: wings and packages, from pyproject.toml's layers and their first lines.

Run: python docs/architecture.py [--check] (exit code 1 with --check if the picture is not up to date).
"""

from __future__ import annotations

import ast
import sys
import tomllib
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).resolve().parents[1]
SOURCE, PICTURE = ROOT / "src" / "surefoot", ROOT / "docs" / "images" / "architecture.svg"
WIDTH, LINE, HEAD, LEFT, GAP, NAMES = 1180, 21, 30, 60, 9, 150
OUTSIDE = (
    ("tests", "mirror wings and packages; axioms, conformance tables, attempts to make certificates lie"),
    ("benchmarks", "measurements against rivals; in the repository, not in the wheel"),
    ("examples", "short scripts on public names"),
)
INK, EDGE, PAPER, SHADES = "#1c2733", "#8a97a6", "#ffffff", ("#eef3f8", "#e2eaf2")


def purpose(place: Path) -> str:
    """Return the first line of a package's or a module's docstring."""
    file = place / "__init__.py" if place.is_dir() else place
    words = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
    return " ".join(words.split("\n\n")[0].split())


def wings() -> list[str]:
    """Return the wings from the top: the layers that import-linter holds."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    return list(next(contract["layers"] for contract in contracts if contract["type"] == "layers"))


def packages(wing: str) -> list[tuple[str, str]]:
    """Return (name, purpose) of the packages of a wing: its packages, and modules of its own."""
    places = sorted(SOURCE.joinpath(wing).iterdir(), key=lambda place: (place.is_file(), place.name))
    found = [
        p for p in places if (p / "__init__.py").is_file() or (p.suffix == ".py" and p.stem != "__init__")
    ]
    return [(place.stem, purpose(place)) for place in found]


def text(x: float, y: float, words: str, size: int = 13, style: str = "") -> str:
    """Return a line of text."""
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}" {style}>{escape(words)}</text>'


def box(top: float, height: float, shade: str, dash: str = "") -> str:
    """Return the frame of a wing."""
    return (
        f'<rect x="{LEFT}" y="{top:g}" width="{WIDTH - LEFT - 20}" height="{height:g}" rx="5" fill="{shade}" '
        f'stroke="{EDGE}" stroke-width="0.8" {dash}/>'
    )


def picture() -> str:
    """Return the picture as SVG."""
    parts, y = [], 10.0
    for name, what in OUTSIDE:
        parts += [
            box(y, HEAD - 4, PAPER, 'stroke-dasharray="4 3"'),
            text(LEFT + 12, y + 18, name, 14, 'font-weight="bold"'),
        ]
        parts.append(text(LEFT + NAMES, y + 18, what))
        y += HEAD
    y = top = y + GAP
    for k, wing in enumerate(wings()):
        inside = packages(wing)
        height = HEAD + LINE * len(inside) + 4
        parts += [box(y, height, SHADES[k % 2]), text(LEFT + 12, y + 20, wing, 16, 'font-weight="bold"')]
        parts.append(text(LEFT + NAMES, y + 20, purpose(SOURCE / wing), 14, 'font-weight="bold"'))
        for j, (name, what) in enumerate(inside):
            parts.append(text(LEFT + 28, y + HEAD + LINE * j + 13, name))
            parts.append(text(LEFT + NAMES, y + HEAD + LINE * j + 13, what))
        y += height + GAP
    middle = 0.5 * (top + y)
    turned = f'transform="rotate(-90 24 {middle:g})" text-anchor="middle"'
    begin = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + 5:g}" '
        f'font-family="sans-serif" fill="{INK}">',
        f'<rect width="{WIDTH}" height="{y + 5:g}" fill="{PAPER}"/>',
        '<defs><marker id="head" markerWidth="8" markerHeight="8" refX="4" refY="4" orient="auto">'
        f'<path d="M0,0 L8,4 L0,8 z" fill="{INK}"/></marker></defs>',
        f'<line x1="36" y1="{top:g}" x2="36" y2="{y - 14:g}" stroke="{INK}" stroke-width="1.5" '
        'marker-end="url(#head)"/>',
    ]
    end = [text(24, middle, "a wing may import those below it, through their faces", 13, turned), "</svg>"]
    return "\n".join([*begin, *parts, *end]) + "\n"


def main(arguments: list[str]) -> int:
    """Write the picture, or tell whether it is up to date."""
    drawn = picture()
    if "--check" in arguments:
        same = PICTURE.is_file() and PICTURE.read_text(encoding="utf-8") == drawn
        print("up to date" if same else f"{PICTURE.name} is not what python docs/architecture.py draws")
        return 0 if same else 1
    PICTURE.write_text(drawn, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
