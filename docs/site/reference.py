"""The API reference: a page for each room, from `src/surefoot/__init__.pyi`, the one list of public names."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path
from typing import Any

import surefoot

ROOMS = {
    "cones": "Cones",
    "stance": "Contacts and stances",
    "terrain": "Terrains",
    "equilibrium": "Questions to a stance",
    "contact": "Contact problems",
    "solvers": "Solvers",
    "batch": "Batches",
    "robot": "Robots",
    "control": "Controllers",
    "planning": "Planning",
    "interop": "Contact sequences as data",
    "simulation": "Worlds and runs",
    "sweep": "Sweeps",
    "log": "Logs",
    "audit": "Audit",
    "estimation": "Estimation and identification",
    "viz": "Pictures",
    "errors": "Errors",
}
"""Room of the package and the title of its page; a room that is missing gets its own name."""
MODULES = {
    "laws": "Soft contact laws",
    "spatial": "Conventions as code",
    "robot.centroidal": "Momentum",
    "robot.jacobians": "Contact Jacobians",
    "robot.dynamics": "Constrained dynamics",
    "equilibrium.actuation": "Statics with motors' limits",
    "stepping.flight": "Flights",
}
"""Modules whose names are used through the module, as the pages show."""


def public_names() -> dict[str, list[str]]:
    """Return the public names by the room where they live, as the stub says."""
    tree = ast.parse(Path(surefoot.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    rooms: dict[str, list[str]] = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            rooms.setdefault(node.module.split(".")[0], []).extend(a.asname or a.name for a in node.names)
    return rooms


def write(folder: Path) -> None:
    """Write the pages of the reference, and `index.rst`, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    rooms = public_names()
    order = [room for room in ROOMS if room in rooms] + [room for room in rooms if room not in ROOMS]
    for room in order:
        entries = [_directive(f"surefoot.{name}", getattr(surefoot, name)) for name in rooms[room]]
        _page(folder / f"{room}.rst", ROOMS.get(room, room.capitalize()), _first_lines(room), entries)
    for module, title in MODULES.items():
        entry = f".. automodule:: surefoot.{module}\n   :members:\n   :imported-members:\n"
        if module != "laws":
            entry = entry.replace("   :imported-members:\n", "")
        _page(folder / f"{module}.rst", title, f"``surefoot.{module}``", [entry])
    names = [*order, *MODULES]
    listed = "".join(f"   {name}\n" for name in names)
    index = "Every public name, ``import surefoot as sf``.\n\n.. toctree::\n   :maxdepth: 2\n\n" + listed
    (folder / "index.rst").write_text(f"Reference\n=========\n\n{index}", encoding="utf-8")


def _first_lines(room: str) -> str:
    module = __import__(f"surefoot.{room}", fromlist=["__doc__"])
    return (module.__doc__ or "").strip().splitlines()[0]


def _directive(path: str, what: Any) -> str:
    if inspect.isclass(what):
        return f".. autoclass:: {path}\n   :members:\n"
    return f".. autofunction:: {path}\n" if callable(what) else f".. autodata:: {path}\n"


def _page(path: Path, title: str, text: str, entries: list[str]) -> None:
    body = "\n".join(entries)
    path.write_text(f"{title}\n{'=' * len(title)}\n\n{text}\n\n{body}", encoding="utf-8")
