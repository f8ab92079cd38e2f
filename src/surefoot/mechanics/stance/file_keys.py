"""The keys of a stance file: docs/files.md describes them, shapes and bounds are the contacts' own affair."""

from __future__ import annotations

from typing import Annotated, NotRequired, Required

from pydantic import Field, with_config
from typing_extensions import TypedDict

from surefoot.base.arrays import LARGEST
from surefoot.base.file_models import FILE, YAML, AnyNumber, Name, Number

Direction = list[Annotated[float, Field(ge=-LARGEST, le=LARGEST), YAML]]


@with_config(FILE)
class ContactKeys(TypedDict, total=False):
    """A point, or a sole if it has a length and a width, or corners."""

    name: Name
    position: Required[list[Number]]
    normal: Direction
    mu: Number
    heading: Direction
    normal_min: Number
    normal_max: AnyNumber
    length: Number
    width: Number
    corners: list[list[Number]]


@with_config(FILE)
class StanceKeys(TypedDict):
    """A robot's contacts and what they have to carry."""

    name: NotRequired[Name]
    mass: Number
    com: list[Number]
    external_wrench: NotRequired[list[Number]]
    mu: NotRequired[Number]
    contacts: NotRequired[list[ContactKeys]]
