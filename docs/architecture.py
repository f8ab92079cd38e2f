"""Draw docs/images/architecture.svg: the rooms, from pyproject.toml's layers and the rooms' own first lines.

Run: python docs/architecture.py [--check] (exit code 1 with --check if the picture is not up to date).
"""

from __future__ import annotations

import ast
import sys
import tomllib
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "images" / "architecture.svg"
WIDTH, FLOOR, LEFT, GAP = 1180, 30, 60, 22
OUTSIDE = (
    ("tests", "mirror the rooms; axioms, conformance tables, an adversary"),
    ("benchmarks", "measurements against rivals; in the repository, not in the wheel"),
    ("examples", "short scripts on public names"),
)
INK, LINE, PAPER, SHADES = "#1c2733", "#8a97a6", "#ffffff", ("#eef3f8", "#e2eaf2")


def floors() -> list[tuple[str, str]]:
    """Return (room, what it is for) from the top: the layers that import-linter holds, where they exist."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    layers = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    out = []
    for layer in layers:
        place = ROOT / "src" / "surefoot" / layer.strip("()")
        file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
        if file.is_file():
            words = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
            out.append((layer.strip("()"), " ".join(words.split("\n\n")[0].split())))
    return out


def text(x: float, y: float, words: str, size: int = 14, style: str = "") -> str:
    """Return a line of text."""
    return f'<text x="{x:g}" y="{y:g}" font-size="{size}" {style}>{escape(words)}</text>'


def row(k: int, top: float, name: str, what: str, dash: str = "") -> list[str]:
    """Return one floor: a bar with a name and what it is for."""
    y, shade = top + k * FLOOR, SHADES[k % 2]
    return [
        f'<rect x="{LEFT}" y="{y:g}" width="{WIDTH - LEFT - 20}" height="{FLOOR - 3}" rx="4" fill="{shade}" '
        f'stroke="{LINE}" stroke-width="0.8" {dash}/>',
        text(LEFT + 12, y + 18, name, 14, 'font-weight="bold"'),
        text(LEFT + 130, y + 18, what, 13),
    ]


def picture() -> str:
    """Return the picture as SVG."""
    rooms = floors()
    top = 10 + len(OUTSIDE) * FLOOR + GAP
    bottom = top + len(rooms) * FLOOR
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {bottom + 14:g}" '
        f'font-family="sans-serif" fill="{INK}">',
        f'<rect width="{WIDTH}" height="{bottom + 14:g}" fill="{PAPER}"/>',
        '<defs><marker id="head" markerWidth="8" markerHeight="8" refX="4" refY="4" orient="auto">'
        f'<path d="M0,0 L8,4 L0,8 z" fill="{INK}"/></marker></defs>',
    ]
    for k, (name, what) in enumerate(OUTSIDE):
        parts += row(k, 10, name, what, 'stroke-dasharray="4 3"')
    for k, (name, what) in enumerate(rooms):
        parts += row(k, top, name, what)
    parts.append(
        f'<line x1="36" y1="{top:g}" x2="36" y2="{bottom - 10:g}" stroke="{INK}" stroke-width="1.5" '
        'marker-end="url(#head)"/>'
    )
    middle = 0.5 * (top + bottom)
    turned = f'transform="rotate(-90 24 {middle:g})" text-anchor="middle"'
    parts += [text(24, middle, "a room may import those below it", 13, turned), "</svg>"]
    return "\n".join(parts) + "\n"


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
