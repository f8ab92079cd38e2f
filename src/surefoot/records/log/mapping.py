"""The mapping from somebody's fields and units to a log's channels, and its YAML file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name, located, shown, unknown_name
from surefoot.base.text_files import parse_yaml, read_yaml
from surefoot.records.log.channels import CHANNELS, Channel

if TYPE_CHECKING:
    from surefoot.records.log.mapping_keys import TakeKeys

_DEGREE = 0.017453292519943295
UNITS: dict[str, tuple[str, float]] = {
    "s": ("s", 1.0),
    "ms": ("s", 1e-3),
    "us": ("s", 1e-6),
    "ns": ("s", 1e-9),
    "m": ("m", 1.0),
    "cm": ("m", 1e-2),
    "mm": ("m", 1e-3),
    "rad": ("rad", 1.0),
    "deg": ("rad", _DEGREE),
    "m/s": ("m/s", 1.0),
    "mm/s": ("m/s", 1e-3),
    "rad/s": ("rad/s", 1.0),
    "deg/s": ("rad/s", _DEGREE),
    "m/s^2": ("m/s^2", 1.0),
    "g": ("m/s^2", 9.80665),
    "N": ("N", 1.0),
    "kN": ("N", 1e3),
    "kgf": ("N", 9.80665),
    "N m": ("N m", 1.0),
    "1": ("1", 1.0),
    "raw": ("raw", 1.0),
}
"""Unit to the one that Surefoot keeps it in, and the factor to that."""


def unit_factor(unit: str, channel: Channel) -> float:
    """Return the factor from a unit to a channel's own; no unit is the channel's own.

    Raises
    ------
    ProblemError
        For a unit that is not known, or is one of something else.
    """
    if not unit:
        return 1.0
    check_name("unit", unit, UNITS)
    own, by = UNITS[unit]
    wanted = channel.unit.split(", ")
    if own not in wanted:
        raise ProblemError(
            f"channel {channel.name} is in {channel.unit or 'no unit'}, {unit!r} is none of that"
        )
    if len(wanted) > 1 and by != 1.0 and channel.shape != ("joints",):
        raise ProblemError(
            f"channel {channel.name} mixes {channel.unit}: give its parts with units of their own"
        )
    return by


QUATERNIONS = ("xyzw", "wxyz")
"""Orders of a quaternion's numbers."""
FRAMES = ("contact", "world", "base")
"""Axes that vectors may be given in."""
_PLACES = {"axis": "xyz", "AXIS": "XYZ"}


@dataclass(frozen=True)
class Take:
    """Where a channel's numbers come from.

    Attributes
    ----------
    fields
        Names of the fields, their numbers one after the other. ``{foot}``, ``{joint}``, ``{axis}`` (x, y, z)
        and ``{AXIS}`` (X, Y, Z) in a name stand for all of them.
    unit
        Theirs; empty for the channel's own.
    frame
        Axes that vectors are in; empty for the channel's own.
    quaternion
        "xyzw" or "wxyz": order of a quaternion in them; empty where there is none.
    scale
        Factor: -1 for the force on the ground, or what a sensor's unit is worth.
    """

    fields: tuple[str, ...]
    unit: str = ""
    frame: str = ""
    quaternion: str = ""
    scale: float = 1.0

    def expanded(self, feet: tuple[str, ...], joints: tuple[str, ...]) -> tuple[str, ...]:
        """Return the names with their places filled: feet and joints first, axes inside."""
        names = self.fields
        for place, values in {"foot": feet, "joint": joints, **_PLACES}.items():
            mark = "{" + place + "}"
            if any(mark in name for name in names) and not values:
                raise ProblemError(f"{names[0]!r} stands for every {place}, and the mapping names no {place}")
            names = tuple(n.replace(mark, v) for n in names for v in (values if mark in n else ("",)))
        return names


@dataclass(frozen=True)
class LogMapping:
    """From fields to channels.

    Attributes
    ----------
    channels
        Name of a channel to where it comes from; the channel ``time`` for the stamps, which messages have
        without a field of their own.
    feet, joints
        Names in the order of the numbers; joints may pick from the names that a message brings.
    facts
        Facts of the log, such as ``mass``.
    define
        Channels of one's own.
    guessed
        Whether nobody said so.
    rate
        Of the rows of a table without stamps [Hz]; zero where stamps tell the time.

    Raises
    ------
    ProblemError
        For names that are none, a rate that is none, and one beside stamps.
    """

    channels: Mapping[str, Take]
    feet: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    define: Mapping[str, Channel] = field(default_factory=dict)
    guessed: bool = False
    rate: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.rate < math.inf:
            raise ProblemError(f"the rate of the rows must be positive, in Hz, got {self.rate!r}")
        if self.rate and "time" in self.channels:
            field_of_time = self.channels["time"].fields[0]
            raise ProblemError(
                f"the time is told twice, by {field_of_time!r} and by a rate of {self.rate:g} Hz"
            )
        facts = {str(name): _plain(f"the fact {name}", value) for name, value in self.facts.items()}
        object.__setattr__(self, "facts", facts)
        known = {**CHANNELS, **self.define}
        for name, take in self.channels.items():
            check_name("channel", name, known)
            for what, said in (("order of a quaternion", take.quaternion), ("frame", take.frame)):
                if not isinstance(said, str):
                    raise ProblemError(f"the {what} of {name} must be a text, got {shown(said)}")
            if take.quaternion and take.quaternion not in QUATERNIONS:
                raise ProblemError(unknown_name("order of a quaternion", take.quaternion, QUATERNIONS))
            if take.frame and take.frame not in FRAMES:
                raise ProblemError(unknown_name("frame", take.frame, FRAMES))

    def as_yaml(self) -> str:
        """Return the mapping as a YAML file holds it."""
        import yaml

        define = [{**asdict(c), "shape": list(c.shape)} for c in self.define.values()]
        names = {"feet": list(self.feet), "joints": list(self.joints)}
        parts = {**names, "facts": dict(self.facts), "define": define}
        out: dict[str, Any] = {key: value for key, value in parts.items() if value}
        if self.rate:
            out["time"] = {"rate": self.rate}
        out["channels"] = {name: _take_to(take) for name, take in self.channels.items()}
        return yaml.safe_dump(out, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True)


def _plain(name: str, value: Any) -> Any:
    """Return a value as what a file can hold: NumPy's numbers and arrays become Python's own."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): _plain(name, part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(name, part) for part in value]
    if value is None or isinstance(value, (bool, int, float, str, date)):
        return value
    raise ProblemError(f"{name} must be numbers or texts, got {shown(value)}")


def _take_to(take: Take) -> Any:
    fields = take.fields[0] if len(take.fields) == 1 else list(take.fields)
    rest = {"unit": take.unit, "frame": take.frame, "quaternion": take.quaternion}
    content = {key: value for key, value in rest.items() if value}
    return {"from": fields, **content, **({} if take.scale == 1.0 else {"scale": take.scale})}


def read_mapping(path: Path | str) -> LogMapping:
    """Read a mapping from a YAML file.

    Raises
    ------
    ProblemError
        If the file cannot be read, or says what no mapping says.
    """
    return _mapping_from(read_yaml(Path(path), "the mapping"), str(path))


def mapping_from_yaml(text: str, name: str = "the mapping") -> LogMapping:
    """Return the mapping that a YAML text holds; `name` is what errors call it."""
    return _mapping_from(parse_yaml(text, name), name)


def _mapping_from(content: Any, name: str) -> LogMapping:
    """Return the mapping that parsed YAML stands for."""
    from surefoot.base.file_models import read_as
    from surefoot.records.log.mapping_keys import MappingKeys

    with located(name):
        said = read_as(MappingKeys, content)
        takes = said.get("channels", {})
        clock = said.get("time", {})
        rate = _positive_rate(clock["rate"]) if "rate" in clock else 0.0
        if "from" in clock:
            takes = {"time": cast("TakeKeys", clock), **takes}
        return LogMapping(
            {channel: _take_from(take) for channel, take in takes.items()},
            said.get("feet", ()),
            said.get("joints", ()),
            said.get("facts") or {},
            {row["name"]: Channel(**row) for row in said.get("define", ())},
            rate=rate,
        )


def _positive_rate(value: float) -> float:
    """Return the rate of a table's rows [Hz]."""
    if not 0.0 < value < math.inf:
        raise ProblemError(f"the rate of the rows must be positive, in Hz, got {value!r}")
    return float(value)


def with_rate(mapping: LogMapping, rate: float | None) -> LogMapping:
    """Return a mapping with the rate [Hz] of a table's rows without stamps; None for the mapping's own.

    Raises
    ------
    ProblemError
        For a rate that is none, or beside stamps or another rate.
    """
    if rate is None:
        return mapping
    rate = _positive_rate(real_number("rate", rate))
    if mapping.rate and mapping.rate != rate:
        raise ProblemError(f"the mapping says {mapping.rate:g} Hz, not {rate:g}")
    return replace(mapping, rate=rate)


def _take_from(said: TakeKeys) -> Take:
    texts = said.get("unit", ""), said.get("frame", ""), said.get("quaternion", "")
    return Take(said["from"], *texts, said.get("scale", 1.0))


def name_list(name: str, key: str, value: Any) -> tuple[str, ...]:
    """Return the names in a value, of which a text is one; errors call it the `key` of `name`."""
    value = value.tolist() if isinstance(value, np.generic | np.ndarray) else value
    listed = [value] if isinstance(value, str) else value
    if not isinstance(listed, (list, tuple)) or not all(isinstance(v, str) and v for v in listed):
        raise ProblemError(f"{name}: {key} must be a name or a list of names, got {shown(value)}")
    return tuple(listed)
