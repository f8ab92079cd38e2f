"""Ranges as data: an interval or a choice."""

from __future__ import annotations

import math
from dataclasses import dataclass
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


def read_range(experiment: SweepExperiment, name: str, entry: Any) -> Range:
    """Return the range of a parameter as a sweep's file gives it.

    Parameters
    ----------
    experiment, name
        Whose parameter it is, and which.
    entry
        A number; [low, high]; {low, high, scale: linear | log}; for texts one of them or a list.

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
    # whether the ends make sense is the experiment's affair
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
