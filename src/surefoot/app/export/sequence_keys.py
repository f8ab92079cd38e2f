"""The keys of a contact sequence's file, version 1.

`contact_sequence.schema.json` beside this file is made of them by `python -m tests.test_file_schemas`; what
stands under a key is its description there.
"""

from __future__ import annotations

from typing import Annotated, Literal, NotRequired

from pydantic import Field, with_config
from typing_extensions import TypedDict

from surefoot.base.file_models import FILE

Size = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


@with_config(FILE)
class Patch(TypedDict):
    """A foot that touches with a rectangle (length and width), or with a convex polygon (corners)."""

    length: NotRequired[Size]
    """Full, along x [m]."""
    width: NotRequired[Size]
    """Full, along y [m]."""
    corners: NotRequired[list[Annotated[list[float], Field(min_length=2, max_length=2)]]]
    """In the contact's frame [m]."""


@with_config(FILE)
class HalfSpaces(TypedDict):
    """A f <= b for a contact's force f in its frame; derived, checked on reading."""

    A: list[list[float]]
    b: list[float]


@with_config(FILE)
class Contact(TypedDict):
    """One contact of a phase."""

    frame: str
    position: Vector
    """In the world [m]."""
    rotation: Annotated[list[Vector], Field(min_length=3, max_length=3)]
    """(3, 3) rotation_world_contact, row by row."""
    mu: NotNegative
    normal_min: NotRequired[NotNegative]
    """[N]."""
    normal_max: NotRequired[float | None]
    """[N], null for no bound."""
    patch: NotRequired[Patch | None]
    halfspaces: NotRequired[HalfSpaces | None]
    force: NotRequired[list[float] | None]
    """Meant, in the contact's frame [N, N m]."""


@with_config(FILE)
class Phase(TypedDict):
    """Who touches the ground for how long."""

    duration: Size
    """[s]."""
    contacts: list[Contact]


@with_config(FILE)
class Friction(TypedDict):
    """How many facets the half-spaces of a cone have, and whether they lie inside or outside it."""

    facets: Annotated[int, Field(ge=3)]
    fit: Literal["inner", "outer"]


@with_config({**FILE, "title": "Contact sequence"})
class Sequence(TypedDict):
    """Who touches the ground where, for how long, with which cone, and which forces are meant.

    SI units, world axes z up; forces act on the robot, in contact frames: x, y tangential, z out of the
    ground.
    """

    format: Literal["surefoot.contact-sequence"]
    version: Literal[1]
    robot: NotRequired[str]
    mass: NotRequired[NotNegative]
    """[kg], 0 where it is not known."""
    frames: Annotated[list[str], Field(json_schema_extra={"uniqueItems": True})]
    """Names of the feet."""
    friction: Friction
    phases: Annotated[list[Phase], Field(json_schema_extra={"minItems": 1})]
