"""The keys of a mapping's file, as docs/logs.md describes them.

Which channels, units and frames there are `surefoot.records.log.mapping` says.
"""

from __future__ import annotations

from typing import Annotated, Any, NotRequired, Required

from pydantic import BeforeValidator, with_config
from typing_extensions import TypedDict

from surefoot.base.file_models import FILE, TUPLE, WHOLE, Name, Number


def _names(value: object) -> object:
    """Return a tuple of names for one name; anything that is neither is refused."""
    listed = [value] if isinstance(value, str) else value
    if not isinstance(listed, (list, tuple)) or not all(isinstance(v, str) and v for v in listed):
        raise ValueError("must be a name or a list of names")
    return tuple(listed)


def _take(value: object) -> object:
    """Return the table of a channel's source: a field's name, or a list of them, is its ``from``."""
    return value if isinstance(value, dict) else {"from": value}


def _clock(value: object) -> object:
    """Return the table of the stamps' source, a field or the rate of the rows; both or none are refused."""
    content = _take(value)
    if isinstance(content, dict) and ("from" in content) == ("rate" in content):
        raise ValueError("must be the field of the stamps, or the rate of the rows: {rate: 500}")
    return content


def _channels(value: object) -> object:
    """Return what may be a list of channels; anything else is refused."""
    if not isinstance(value, list) or not all(isinstance(row, dict) for row in value):
        raise ValueError("must list channels with name, shape, unit")
    return value


Names = Annotated[tuple[str, ...], BeforeValidator(_names)]

TakeKeys = TypedDict(
    "TakeKeys",
    {  # a class cannot have the key "from"
        "from": Required[Names], "unit": Name, "frame": str, "quaternion": str, "scale": Number,
    },
    total=False,
)  # fmt: skip
with_config(FILE)(TakeKeys)

ClockKeys = TypedDict(
    "ClockKeys", {"from": Names, "unit": Name, "scale": Number, "rate": Number}, total=False
)
with_config(FILE)(ClockKeys)

Clock = Annotated[ClockKeys, BeforeValidator(_clock)]
Take = Annotated[TakeKeys, BeforeValidator(_take)]


@with_config(FILE)
class ChannelKeys(TypedDict, total=False):
    """A channel of one's own, see `surefoot.records.log.Channel`."""

    name: Required[str]
    shape: Required[Annotated[tuple[str | Annotated[int, WHOLE], ...], TUPLE]]
    unit: Name
    frame: str
    optional: bool
    flag: bool
    meaning: str


@with_config(FILE)
class MappingKeys(TypedDict):
    """Where a log's channels come from."""

    time: NotRequired[Clock]
    feet: NotRequired[Names]
    joints: NotRequired[Names]
    channels: NotRequired[dict[str, Take]]
    facts: NotRequired[dict[str, Any] | None]
    define: NotRequired[Annotated[list[ChannelKeys], BeforeValidator(_channels)]]
