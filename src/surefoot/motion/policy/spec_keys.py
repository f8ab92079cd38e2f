"""The keys of a policy's description: docs/policies.md says what they mean."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Required

from pydantic import BeforeValidator, Field, with_config
from typing_extensions import TypedDict

from surefoot.base.file_models import FILE, TUPLE, WHOLE, YAML, AnyNumber, Number

Numbers = Annotated[tuple[Number, ...], TUPLE]
Range = Annotated[tuple[AnyNumber, ...], Field(min_length=2, max_length=2), TUPLE]
PerJoint = Number | list[Number] | dict[str, Number]
"""A number for all joints, a list in their order, or patterns of their names."""
Bounds = Number | Annotated[tuple[PerJoint, ...], Field(min_length=2, max_length=2), TUPLE]
"""A size, or low and high."""
Count = Annotated[int, Field(ge=1), WHOLE]


def _term(value: object) -> object:
    """Return a term that is a name alone as one without settings; a mapping of one name as it is."""
    if isinstance(value, str):
        return {value: None}
    if not isinstance(value, dict) or len(value) != 1:
        raise ValueError("must be a name, or a name with its settings")
    return value


@with_config({**FILE, "extra": "allow"})  # which kind of term has which settings `policy.terms` says
class TermKeys(TypedDict, total=False):
    """What a term of the observation may say beside its name."""

    scale: Number | list[Number]
    clip: Range | None
    history: Count
    period: Annotated[float, Field(gt=0), YAML]
    offsets: Numbers
    waves: Annotated[tuple[Literal["sin", "cos"], ...], TUPLE]
    still: Number | None
    x: Numbers
    y: Numbers
    offset: Number
    fastest: Literal["x", "y"]
    feet: Count


@with_config(FILE)
class HistoryKeys(TypedDict, total=False):
    """How the past is given to the network."""

    length: Count
    order: Literal["newest", "oldest"]
    by: Literal["term", "time"]
    start: Literal["repeat", "zeros"]


@with_config(FILE)
class OthersKeys(TypedDict, total=False):
    """Gains of joints that the policy does not move."""

    stiffness: Annotated[float, Field(ge=0), YAML]
    damping: Annotated[float, Field(ge=0), YAML]


@with_config(FILE)
class PolicyKeys(TypedDict, total=False):
    """What a policy's numbers mean."""

    convention: str
    joints: Required[Annotated[tuple[str, ...], TUPLE]]
    default: Required[PerJoint]
    stiffness: Required[PerJoint]
    damping: Required[PerJoint]
    action_scale: Required[PerJoint]
    observations: Required[list[Annotated[dict[str, TermKeys | None], BeforeValidator(_term)]]]
    rate: Annotated[float, Field(ge=1, le=2000), YAML]
    action_clip: Bounds
    action_offset: PerJoint
    target_clip: Bounds
    observation_clip: Annotated[float, Field(ge=0, allow_inf_nan=True), YAML]
    history: HistoryKeys
    command_range: list[Any]
    others: OthersKeys
