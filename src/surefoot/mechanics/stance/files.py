"""Stances as YAML: contacts, robot mass and centre of mass in one readable file."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError, located
from surefoot.base.text_files import list_of, path_of, read_yaml, table_of
from surefoot.mechanics.stance.contact import Contact, PatchContact, PointContact
from surefoot.mechanics.stance.stance import Stance

_TOP = ("name", "mass", "com", "external_wrench", "mu", "contacts")
_CONTACT = ("name", "position", "normal", "mu", "heading", "normal_min", "normal_max", "length", "width")


@dataclass(frozen=True)
class StanceQuestion:
    """A stance and what it has to carry, as a stance file says it.

    Attributes
    ----------
    name
        Title for tables and pictures.
    stance, mass, com
        Contacts, mass [kg], (3,) centre of mass in world axes [m].
    external_wrench
        (6,) [force; moment about the centre of mass] on the robot besides gravity [N, N m].
    """

    name: str
    stance: Stance
    mass: float
    com: FloatArray
    external_wrench: FloatArray = field(default_factory=lambda: np.zeros(6))


def read_stance(path: str | Path) -> StanceQuestion:
    """Read a stance file; docs/files.md describes it.

    Raises
    ------
    ProblemError
        Naming the file and the entry at fault: a key that is unknown or missing, a normal that is not of
        length one, a value that is not a number.
    """
    source = path_of(path)
    content = read_yaml(source)
    with located(source):
        return stance_from_dict(content, source.stem)


def stance_from_dict(content: Any, name: str = "stance") -> StanceQuestion:
    """Return the question that the parsed YAML stands for; see `read_stance`."""
    top = table_of("the file", content, _TOP, required=("mass", "com"))
    mu = real_number("mu", top.get("mu", 0.6), low=0.0)
    entries = list_of("contacts", top.get("contacts", []))
    contacts = [_contact(f"contacts[{k}]", entry, mu) for k, entry in enumerate(entries)]
    mass = real_number("mass", top["mass"])
    if not 0.0 < mass < math.inf:
        raise ProblemError(f"mass must be positive and finite [kg], got {mass:g}")
    return StanceQuestion(
        str(top.get("name", name)),
        Stance(contacts),
        mass,
        finite_array("com", top["com"], (3,)),
        finite_array("external_wrench", top.get("external_wrench", [0.0] * 6), (6,)),
    )


def _contact(where: str, entry: Any, mu: float) -> Contact:
    """Return one contact; errors name the entry."""
    given = table_of(where, entry, _CONTACT, required=("position",))
    name = str(given.get("name", where.removeprefix("contacts")))
    options: dict[str, Any] = {"mu": mu, **given, "name": name}
    sizes = [key for key in ("length", "width") if key in given]
    with located(where):
        if not sizes:
            return PointContact(**options)
        if len(sizes) == 1:
            raise ProblemError(f"a patch needs length and width, got only {sizes[0]}")
        return PatchContact(**options)
