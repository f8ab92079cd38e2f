"""Samples of a space of ranges: Sobol points, each a function of the seed and its own index alone.

The scrambled Sobol sequence [1]_ of a seed is one infinite sequence; sample i is its point i, whoever draws
it and however many there are. Its points fill the space more evenly than random ones, at every number.

.. [1] A. Owen, "Scrambling Sobol' and Niederreiter-Xing points", J. Complexity 14 (1998).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError, check_name, shown
from surefoot.base.text_files import table_of
from surefoot.worlds.sweep.sample_experiment import SweepExperiment

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
            raise ProblemError(f"{name} must be a text or a list of texts, got {shown(entry)}")
        return TextRange(tuple(texts))
    if isinstance(entry, list) and len(entry) == 2:
        entry = {"low": entry[0], "high": entry[1]}
    if isinstance(entry, list):
        raise ProblemError(f"{name} must be [low, high], got {shown(entry)}")
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


MOST = 2**30
"""Points of a Sobol sequence of 30 bits."""


@dataclass(frozen=True)
class SweepSample:
    """One point of a space.

    Attributes
    ----------
    index
        Its number.
    seed
        For whatever else is random in it: noise, tumbling, rough ground.
    values
        Parameter to value.
    """

    index: int
    seed: int
    values: Mapping[str, float | str]


@dataclass(frozen=True)
class Space:
    """Ranges by parameter, in the order of the sequence's dimensions, and a seed.

    Examples
    --------
    >>> space = Space({"mu": NumberRange(0.2, 1.0)}, seed=1)
    >>> space.sample([5])[0] == space.sample(range(8))[5]
    True
    """

    ranges: Mapping[str, Range]
    seed: int = 0

    @property
    def drawn(self) -> tuple[str, ...]:
        """Parameters that are numbers and not constant."""
        return tuple(n for n, r in self.ranges.items() if isinstance(r, NumberRange) and r.low < r.high)

    @property
    def varying(self) -> tuple[str, ...]:
        """All parameters that are not constant: the drawn numbers, then the texts."""
        return (*self.drawn, *(n for n, r in self.ranges.items() if not isinstance(r, NumberRange)))

    def sample(self, indices: Iterable[int]) -> list[SweepSample]:
        """Return the samples of some indices, in their order."""
        wanted = list(indices)
        first = min(wanted, default=0)
        points = self._points(first, max(wanted, default=0) + 1).tolist()
        return [self._at(index, points[index - first]) for index in wanted]

    def _at(self, index: int, point: list[float]) -> SweepSample:
        shares = zip(self.ranges.items(), point, strict=True)
        seed = int(np.random.SeedSequence([self.seed, index]).generate_state(1)[0])
        return SweepSample(index, seed, {name: drawn.at(share) for (name, drawn), share in shares})

    def _points(self, start: int, stop: int) -> np.ndarray:
        """Return points `start` to `stop` - 1 of the sequence: (stop - start, d)."""
        from scipy.stats import qmc

        if not self.ranges:
            return np.zeros((stop - start, 0))
        sequence = qmc.Sobol(len(self.ranges), seed=np.random.default_rng(self.seed))
        if start:
            sequence.fast_forward(start)
        first = sequence.random(1)  # the first call would warn of a number that is no power of two
        return np.vstack([first, sequence.random(stop - start - 1)]) if stop - start > 1 else first
