"""Settings: fields of frozen dataclasses that know their unit, meaning, limits and where the value is from.

    @dataclass(frozen=True)
    class PushRecoverySettings(Settings):
        begin_error: float = setting(0.4, "sqrt(g h)", "velocity error that starts a recovery", low=0.0)

A value is checked when the dataclass is constructed. docs/settings.md is printed from all of them.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

from surefoot.base.arrays import finite_array, real_number, whole_number
from surefoot.base.errors import ProblemError, shown

JUDGEMENT = "judgement, not measured"
"""The source of a value that nobody has compared with others."""
MEASURED = re.compile(r"`[^`]+`, \d{4}-\d\d-\d\d")
"""How a source begins that names the command, and the day it ran, which chose the value."""
_KEY = "setting"


@dataclass(frozen=True)
class SettingInfo:
    """What is known of a field beside its value.

    Attributes
    ----------
    unit
        "-" for a number without one.
    meaning
        One phrase.
    low, high
        Least and largest value allowed, both included; None for no limit. An infinite limit allows
        infinity.
    source
        The command and the date that chose the value, see `MEASURED`, or `JUDGEMENT`.
    whole
        Whether it is a whole number.
    """

    unit: str
    meaning: str = ""
    low: float | None = None
    high: float | None = None
    source: str = ""
    whole: bool = False

    @property
    def measured(self) -> bool:
        """Whether a command chose the value."""
        return MEASURED.match(self.source) is not None


@dataclass(frozen=True)
class DescribedSetting:
    """A setting of a value: its name (dotted in a nested one), its value, and what is known of it."""

    name: str
    value: Any
    info: SettingInfo


def setting(
    default: float | bool | str | tuple[float, ...] | None,
    unit: str,
    meaning: str,
    *,
    low: float | None = None,
    high: float | None = None,
    tuned: str = JUDGEMENT,
) -> Any:
    """Return a field of a frozen dataclass, as `dataclasses.field` does.

    Parameters
    ----------
    default
        The value; its type is the setting's: a float, a whole number, a bool, a text, or as many floats. None
        for a number that may be left out.
    unit
        "-" for none.
    meaning
        One phrase that stands alone.
    low, high
        Least and largest value allowed.
    tuned
        What chose the value: a command in backquotes and a date, with a remark after a colon if need be
        ("`python -m benchmarks.limits laws.pull`, 2026-11-25"), or `JUDGEMENT`, with or without a remark.

    Raises
    ------
    ProblemError
        For a setting without unit or meaning, and a source that is neither of the two.
    """
    if not (unit and meaning):
        raise ProblemError(f"a setting needs a unit and a meaning, got {unit!r} and {meaning!r}")
    if not (MEASURED.match(tuned) or tuned.startswith(JUDGEMENT)):
        raise ProblemError(f"tuned must be a command with a date, or {JUDGEMENT!r}, got {tuned!r}")
    whole = isinstance(default, int) and not isinstance(default, bool)
    return field(default=default, metadata={_KEY: SettingInfo(unit, meaning, low, high, tuned, whole)})


def bounded_number(default: float | None, low: float, high: float, unit: str = "") -> Any:
    """Return a field for a number that a user chooses: checked as a setting is, tuned by nobody."""
    return field(default=default, metadata={_KEY: SettingInfo(unit, low=low, high=high)})


def info_of(owner: type[Any], name: str) -> SettingInfo | None:
    """Return what is known of a field of a dataclass beside its value; None if it is no setting."""
    found: SettingInfo | None = owner.__dataclass_fields__[name].metadata.get(_KEY)
    return found


def check_settings(value: Any) -> None:
    """Check all settings of a frozen dataclass; a number is stored as the type of its default.

    Raises
    ------
    ProblemError
        Naming the setting, its value and what is allowed.
    """
    for one in fields(value):
        info = one.metadata.get(_KEY)
        if info is not None:
            given = getattr(value, one.name)
            object.__setattr__(value, one.name, _checked(one.name, given, one.default, info))


@dataclass(frozen=True)
class Settings:
    """Base of frozen dataclasses whose fields are settings, or other `Settings`."""

    def __post_init__(self) -> None:
        check_settings(self)


def describe(value: Any) -> tuple[DescribedSetting, ...]:
    """Return all settings of a dataclass with their defaults, or of a value with its own, in order.

    Those of a nested `Settings` have dotted names.
    """
    return tuple(_described(value() if isinstance(value, type) else value, ""))


def _described(value: Any, prefix: str) -> Iterator[DescribedSetting]:
    for one in fields(value):
        name, held, info = prefix + one.name, getattr(value, one.name), one.metadata.get(_KEY)
        if info is not None:
            yield DescribedSetting(name, held, info)
        elif is_dataclass(held) and not isinstance(held, type):
            yield from _described(held, name + ".")


def _checked(name: str, value: Any, default: Any, info: SettingInfo) -> Any:
    """Return a value in its default's type, if it is allowed."""
    if value is None and default is None:
        return None
    if isinstance(default, tuple):
        parts = finite_array(name, value, (len(default),)).tolist()
        return tuple(_checked(f"{name}[{k}]", part, 0.0, info) for k, part in enumerate(parts))
    for kind, word in ((bool, "True or False"), (str, "a text")):
        if isinstance(default, kind):
            if not isinstance(value, kind):
                raise ProblemError(f"{name} must be {word}, got {shown(value)}")
            return value
    if isinstance(value, bool):
        raise ProblemError(f"{name} must be a number, got {value}")
    low = -math.inf if info.low is None else info.low
    high = math.inf if info.high is None else info.high
    number = real_number(name, value, low=low, high=high)
    if math.isinf(number) and number not in (info.low, info.high):
        raise ProblemError(f"{name} must be finite, got {number:g}")
    return whole_number(name, value, low=-(2**53)) if info.whole else number
