"""Samples of a space of ranges: Sobol points, each a function of the seed and its own index alone.

The scrambled Sobol sequence [1]_ of a seed is one infinite sequence; sample i is its point i, whoever draws
it and however many there are. Its points fill the space more evenly than random ones, at every number.

.. [1] A. Owen, "Scrambling Sobol' and Niederreiter-Xing points", J. Complexity 14 (1998).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from surefoot.sweep.parameters import PARAMETERS, TERRAIN
from surefoot.sweep.ranges import Choice, Interval, Range

MOST = 2**30
"""Points of a Sobol sequence of 30 bits."""
_ORDER = (*PARAMETERS, TERRAIN)


@dataclass(frozen=True)
class Sample:
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

    def number(self, name: str, otherwise: float) -> float:
        """Return the value of a parameter, or another where the sweep does not draw it."""
        return float(self.values.get(name, otherwise))


@dataclass(frozen=True)
class Space:
    """Ranges by parameter, and a seed.

    Examples
    --------
    >>> space = Space({"mu": Interval(0.2, 1.0)}, seed=1)
    >>> space.sample([5])[0] == space.sample(range(8))[5]
    True
    """

    ranges: Mapping[str, Range]
    seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order of the sequence's dimensions."""
        return tuple(sorted(self.ranges, key=_ORDER.index))

    def kind(self, name: str) -> str:
        """Return the type of a parameter's column: "text" or "float"."""
        return "text" if isinstance(self.ranges[name], Choice) else "float"

    def drawn(self) -> tuple[str, ...]:
        """Return the numeric parameters that are not constant."""
        intervals = ((n, r) for n in self.names if isinstance(r := self.ranges[n], Interval))
        return tuple(name for name, r in intervals if r.low < r.high)

    def varying(self) -> tuple[str, ...]:
        """Return all parameters that are not constant: the drawn numbers, then the texts."""
        return (*self.drawn(), *(name for name in self.names if self.kind(name) == "text"))

    def sample(self, indices: Iterable[int]) -> list[Sample]:
        """Return the samples of some indices, in their order."""
        wanted = list(indices)
        found: dict[int, Sample] = {}
        for start, stop in _runs(sorted(set(wanted))):
            for index, point in zip(range(start, stop), self._points(start, stop), strict=True):
                values = {n: self.ranges[n].at(float(u)) for n, u in zip(self.names, point, strict=True)}
                found[index] = Sample(index, _own_seed(self.seed, index), values)
        return [found[index] for index in wanted]

    def _points(self, start: int, stop: int) -> np.ndarray:
        """Return points `start` to `stop` - 1 of the sequence: (stop - start, d)."""
        from scipy.stats import qmc

        if not self.names:
            return np.zeros((stop - start, 0))
        sequence = qmc.Sobol(len(self.names), seed=np.random.default_rng(self.seed))
        if start:
            sequence.fast_forward(start)
        first = sequence.random(1)  # the first call would warn of a number that is no power of two
        return np.vstack([first, sequence.random(stop - start - 1)]) if stop - start > 1 else first


def _own_seed(seed: int, index: int) -> int:
    return int(np.random.SeedSequence([seed, index]).generate_state(1)[0])


def _runs(indices: Sequence[int]) -> list[tuple[int, int]]:
    """Return rising indices as (start, stop) of their unbroken runs.

    >>> _runs([1, 2, 3, 7])
    [(1, 4), (7, 8)]
    """
    groups = itertools.groupby(enumerate(indices), key=lambda pair: pair[1] - pair[0])
    parts = [[index for _, index in group] for _, group in groups]
    return [(part[0], part[-1] + 1) for part in parts]
