"""Stances as YAML: contacts, robot mass and centre of mass in one readable file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.errors import ProblemError, located
from surefoot.base.text_files import path_of, read_yaml
from surefoot.contact import Sole
from surefoot.mechanics.stance.contact import Contact, PointContact, SoleContact
from surefoot.mechanics.stance.stance import Stance

if TYPE_CHECKING:
    from surefoot.mechanics.stance.file_keys import ContactKeys


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
    from surefoot.base.file_models import read_as
    from surefoot.mechanics.stance.file_keys import StanceKeys

    said = read_as(StanceKeys, content)
    mu, mass = real_number("mu", said.get("mu", 0.6), low=0.0), said["mass"]
    contacts = [_contact(k, given, mu) for k, given in enumerate(said.get("contacts", []))]
    if mass <= 0.0:
        raise ProblemError(f"mass must be positive and finite [kg], got {mass:g}")
    return StanceQuestion(
        said.get("name", name),
        Stance(contacts),
        mass,
        finite_array("com", said["com"], (3,)),
        finite_array("external_wrench", said.get("external_wrench", [0.0] * 6), (6,)),
    )


def _contact(number: int, given: ContactKeys, mu: float) -> Contact:
    """Return one contact; errors name the entry."""
    options: dict[str, Any] = {"mu": mu, "name": f"[{number}]", **given}
    sizes = [key for key in ("length", "width") if key in given]
    with located(f"contacts[{number}]"):
        if "corners" in given:
            if sizes:
                raise ProblemError(
                    f"a sole has corners or a length and a width, got both corners and {sizes[0]}"
                )
            corners = finite_array("corners", options.pop("corners"), (None, 2))
            return SoleContact(sole=Sole.of_corners(corners, options.pop("mu")), **options)
        if not sizes:
            return PointContact(**options)
        if len(sizes) == 1:
            raise ProblemError(f"a sole needs length and width, got only {sizes[0]}")
        length, width, friction = options.pop("length"), options.pop("width"), options.pop("mu")
        return SoleContact(sole=Sole(length, width, friction), **options)
