"""Ranges as data: an interval, a choice, or the interval that `surefoot identify --json` wrote."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from surefoot.arrays import real_number
from surefoot.errors import ProblemError, check_name
from surefoot.sweep.experiment import SweepExperiment
from surefoot.text_files import table_of

SCALES = ("linear", "log")


@dataclass(frozen=True)
class NumberRange:
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

    @property
    def ends(self) -> tuple[float, float]:
        """Values that have to make sense if all in the range are to."""
        return self.low, self.high


@dataclass(frozen=True)
class TextRange:
    """One of some texts, each as often as the others."""

    choices: tuple[str, ...]

    def at(self, share: float) -> str:
        """Return the text at a share from 0 to 1."""
        return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]

    @property
    def ends(self) -> tuple[str, ...]:
        """Values that have to make sense if all in the range are to."""
        return self.choices


Range: TypeAlias = NumberRange | TextRange


def read_range(experiment: SweepExperiment, name: str, entry: Any, folder: Path) -> Range:
    """Return the range of a parameter as a sweep's file gives it.

    Parameters
    ----------
    experiment, name
        Whose parameter it is, and which.
    entry
        A number; [low, high]; {low, high, scale: linear | log}; {identified: FILE, as: NAME, widen: FACTOR};
        for texts one of them or a list.
    folder
        That files are relative to.

    Raises
    ------
    ProblemError
        Naming the parameter and the value at fault.
    """
    check_name("parameter", name, experiment.parameters())
    if name not in experiment.numbers():
        texts = [entry] if isinstance(entry, str) else entry
        if not isinstance(texts, list) or not texts or not all(isinstance(t, str) for t in texts):
            raise ProblemError(f"{name} must be a text or a list of texts, got {entry!r:.60}")
        return TextRange(tuple(texts))
    if isinstance(entry, list) and len(entry) == 2:
        entry = {"low": entry[0], "high": entry[1]}
    if isinstance(entry, list):
        raise ProblemError(f"{name} must be [low, high], got {entry!r:.60}")
    if not isinstance(entry, dict):
        entry = {"low": entry, "high": entry}
    if "identified" in entry:
        entry = _identified(experiment, name, entry, folder)
    return _interval(name, entry)


def _interval(name: str, entry: dict[str, Any]) -> NumberRange:
    """Return the interval of {low, high, scale}; whether its ends make sense is the experiment's affair."""
    table_of(name, entry, ("low", "high", "scale"), required=("low", "high"))
    ends = [entry[key] for key in ("low", "high")]
    for end in ends:
        if isinstance(end, bool) or end == "":
            raise ProblemError(f"{name} must be a number, got {end!r}")
    low, high = (real_number(name, end) for end in ends)
    scale = entry.get("scale", "linear")
    if low > high:
        raise ProblemError(f"{name} must have low <= high, got [{low:g}, {high:g}]")
    check_name("scale", scale, SCALES, name)
    if scale == "log" and low <= 0.0:
        raise ProblemError(f"{name}: a log scale needs low > 0, got {low:g}")
    return NumberRange(low, high, str(scale))


def _identified(
    experiment: SweepExperiment, name: str, entry: dict[str, Any], folder: Path
) -> dict[str, Any]:
    """Return the 95 % interval of a fit, widened about its value and cut to what makes sense."""
    table_of(name, entry, ("identified", "as", "widen", "scale"))
    file, key = folder / str(entry["identified"]), str(entry.get("as", name))
    widen = real_number(f"{name}.widen", entry.get("widen", 1.0), low=0.0, high=1e3)
    try:
        fit = json.loads(file.read_text(encoding="utf-8"))["fit"]
        value, low, high = (float(fit[key][part]) for part in ("value", "low", "high"))
    except OSError as error:
        raise ProblemError(f"cannot read {file}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError) as error:
        raise ProblemError(
            f"{name}: {file} is not what surefoot identify --json writes: no value, low and high of {key}"
        ) from error
    least, most = experiment.limits(name)
    low, high = max(value - widen * (value - low), least), min(value + widen * (high - value), most)
    return {"low": low, "high": high, "scale": entry.get("scale", "linear")}
