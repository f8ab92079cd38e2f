"""The API reference: a page for each room, from `src/surefoot/__init__.pyi`, the one list of public names.

Its first page has them by what one does with them, as the package's own docstring.
"""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path
from typing import Any

import surefoot

ROOMS = {
    "contact.cones": "Cones",
    "contact.problem": "Contact problems",
    "contact.sets": "Kinds of contact",
    "contact.solvers": "Solvers",
    "contact.batch": "Batches",
    "contact.files": "Problems in files",
    "contact.translation": "Parameters of simulators",
    "mechanics.terrain": "Terrains",
    "mechanics.stance": "Contacts and stances",
    "mechanics.robot": "Robots",
    "mechanics.statics": "Questions to a stance",
    "records.log": "Logs",
    "records.audit": "Audit",
    "records.identification": "Identification",
    "motion.control": "Controllers of forces",
    "motion.standing": "Standing",
    "motion.walking": "Walking",
    "motion.gaits": "Gaits",
    "motion.estimation": "State estimation",
    "motion.planning": "Planning",
    "motion.policy": "Learned policies",
    "motion.drive": "The loop of a real robot",
    "worlds.rigid": "Rigid worlds",
    "worlds.mujoco": "MuJoCo",
    "worlds.running": "Runs",
    "worlds.replay": "Replays",
    "worlds.sweep": "Sweeps",
    "app.export": "Contact sequences as data",
    "base.errors": "Errors",
}
"""Room of the package and the title of its page; a room that is missing gets its own name."""
MODULES = {
    "laws": "Soft contact laws",
    "base.spatial": "Conventions as code",
    "mechanics.robot.centroidal": "Momentum",
    "mechanics.robot.jacobians": "Contact Jacobians",
    "mechanics.robot.dynamics": "Constrained dynamics",
    "mechanics.statics.actuation": "Statics with motors' limits",
    "mechanics.dynamics.airborne_motion": "Flights",
}
"""Modules whose names are used through the module, as the pages show."""


def public_names() -> dict[str, list[str]]:
    """Return the public names by the room (wing.room) where they live, as the stub says."""
    tree = ast.parse(Path(surefoot.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    rooms: dict[str, list[str]] = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            rooms.setdefault(".".join(node.module.split(".")[:2]), []).extend(
                a.asname or a.name for a in node.names
            )
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
    index = "Every public name, ``import surefoot as sf``, by what one does with it.\n\n"
    for verb, found in verbs().items():
        index += (
            f".. rubric:: {verb}\n\n" + ", ".join(f":py:obj:`~surefoot.{name}`" for name in found) + "\n\n"
        )
    index += f".. rubric:: By where it lives\n\n.. toctree::\n   :maxdepth: 2\n\n{listed}"
    (folder / "index.rst").write_text(f"Reference\n=========\n\n{index}", encoding="utf-8")


def verbs() -> dict[str, list[str]]:
    """Return the public names under the five verbs of the package's docstring."""
    sections = re.findall(r"^(\w+)\n((?:    .*\n?)+)", surefoot.__doc__ or "", re.MULTILINE)
    return {verb: re.findall(r"\w+", names) for verb, names in sections}


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
