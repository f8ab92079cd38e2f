"""Ranges as data: an interval, a choice, or the interval that `surefoot identify --json` wrote."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from surefoot.arrays import real_number
from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.parameters import PARAMETERS, TERRAIN
from surefoot.terrain import read_terrain

SCALES = ("linear", "log")
_INTERVAL = ("low", "high", "scale")
_IDENTIFIED = ("identified", "as", "widen", "scale")


class Range(Protocol):
    """Where a parameter's values come from."""

    def at(self, share: float) -> float | str:
        """Return the value at a share from 0 to 1."""

    def as_dict(self) -> dict[str, Any]:
        """Return what tells it from others, for JSON."""


@dataclass(frozen=True)
class Interval:
    """Values from `low` to `high`, evenly or, with `scale` "log", evenly in their logarithm."""

    low: float
    high: float
    scale: str = "linear"

    def at(self, share: float) -> float:
        """Return the value at a share from 0 to 1."""
        if self.low == self.high:
            return self.low
        if self.scale == "log":
            value = math.exp(math.log(self.low) + share * math.log(self.high / self.low))
        else:
            value = self.low + share * (self.high - self.low)
        return min(max(value, self.low), self.high)

    def as_dict(self) -> dict[str, Any]:
        """Return the bounds and the scale."""
        return {"low": self.low, "high": self.high, "scale": self.scale}


@dataclass(frozen=True)
class Choice:
    """One of some texts, each as often as the others."""

    choices: tuple[str, ...]

    def at(self, share: float) -> str:
        """Return the text at a share from 0 to 1."""
        return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]

    def as_dict(self) -> dict[str, Any]:
        """Return the texts."""
        return {"choices": list(self.choices)}


def read_range(name: str, entry: Any, folder: Path) -> Range:
    """Return the range of a parameter as a sweep's file gives it.

    Parameters
    ----------
    name
        A name of `PARAMETERS`, or "terrain".
    entry
        A number; [low, high]; {low, high, scale: linear | log}; {identified: FILE, as: NAME, widen: FACTOR};
        for terrain a text or {choices: [...]}.
    folder
        That files are relative to.

    Raises
    ------
    ProblemError
        Naming the parameter and the value at fault.
    """
    if name == TERRAIN:
        return _terrains(entry)
    if name not in PARAMETERS:
        raise ProblemError(unknown_name("parameter", name, [*PARAMETERS, TERRAIN]))
    if isinstance(entry, list):
        if len(entry) != 2:
            raise ProblemError(f"{name} must be [low, high], got {entry!r:.60}")
        entry = dict(zip(("low", "high"), entry, strict=True))
    if not isinstance(entry, dict):
        value = PARAMETERS[name].checked(name, entry)
        return Interval(value, value)
    return _identified(name, entry, folder) if "identified" in entry else _interval(name, entry)


def _interval(name: str, entry: dict[str, Any]) -> Interval:
    _known_keys(name, entry, _INTERVAL)
    for key in ("low", "high"):
        if key not in entry:
            raise ProblemError(f"{name} lacks {key!r}: it takes low, high and scale")
    low, high = (PARAMETERS[name].checked(f"{name}.{key}", entry[key]) for key in ("low", "high"))
    if low > high:
        raise ProblemError(f"{name} must have low <= high, got [{low:g}, {high:g}]")
    return Interval(low, high, _scale(name, entry, low))


def _identified(name: str, entry: dict[str, Any], folder: Path) -> Interval:
    """Return the 95 % interval of a fit, widened about its value and cut to what makes sense."""
    _known_keys(name, entry, _IDENTIFIED)
    key, parameter = str(entry.get("as", name)), PARAMETERS[name]
    widen = real_number(f"{name}.widen", entry.get("widen", 1.0), low=0.0, high=1e3)
    fit = _fit(folder / str(entry["identified"]))
    if key not in fit:
        raise ProblemError(f"{name}: " + unknown_name(f"number of {entry['identified']}", key, fit))
    try:
        value, low, high = (float(fit[key][part]) for part in ("value", "low", "high"))
    except (KeyError, TypeError, ValueError) as error:
        raise ProblemError(f"{name}: {entry['identified']} has no value, low and high of {key}") from error
    low, high = value - widen * (value - low), value + widen * (high - value)
    low, high = max(low, parameter.low), min(high, parameter.high)
    if not low <= high:  # NaN as well
        raise ProblemError(
            f"{name}: {entry['identified']} gives {key} = [{low:g}, {high:g}], which is no range"
        )
    return _interval(name, {"low": low, "high": high, "scale": entry.get("scale", "linear")})


def _fit(file: Path) -> dict[str, Any]:
    """Return the fitted numbers that `surefoot identify --json` wrote."""
    try:
        fit = json.loads(file.read_text(encoding="utf-8"))["fit"]
    except OSError as error:
        raise ProblemError(f"cannot read {file}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise ProblemError(f"{file} is not what surefoot identify --json writes: it has no 'fit'") from error
    if not isinstance(fit, dict):
        raise ProblemError(f"{file} is not what surefoot identify --json writes: its 'fit' is no object")
    return fit


def _terrains(entry: Any) -> Choice:
    """Return a choice of terrains, each of which can be built."""
    if isinstance(entry, dict):
        _known_keys(TERRAIN, entry, ("choices",))
        entry = entry.get("choices")
    texts = [entry] if isinstance(entry, str) else entry
    if not isinstance(texts, list) or not texts or not all(isinstance(t, str) for t in texts):
        raise ProblemError(f"terrain must be a text or a list of texts, got {entry!r:.60}")
    for text in texts:
        read_terrain(text)
    return Choice(tuple(texts))


def _scale(name: str, entry: dict[str, Any], low: float) -> str:
    scale = entry.get("scale", "linear")
    if scale not in SCALES:
        raise ProblemError(f"{name}: " + unknown_name("scale", scale, SCALES))
    if scale == "log" and low <= 0.0:
        raise ProblemError(f"{name}: a log scale needs low > 0, got {low:g}")
    return str(scale)


def _known_keys(name: str, entry: dict[str, Any], known: tuple[str, ...]) -> None:
    for key in entry:
        if key not in known:
            raise ProblemError(f"{name}: " + unknown_name("key", key, known))
