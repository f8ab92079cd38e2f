"""Samples of a space of ranges: Sobol points, each a function of the seed and its own index alone.

The scrambled Sobol sequence [1]_ of a seed is one infinite sequence; sample i is its point i, whoever draws
it and however many there are. Its points fill the space more evenly than random ones, at every number.

.. [1] A. Owen, "Scrambling Sobol' and Niederreiter-Xing points", J. Complexity 14 (1998).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from surefoot.sweep.ranges import NumberRange, Range

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
        rising = enumerate(sorted(set(wanted)))
        found: dict[int, SweepSample] = {}
        for _, group in itertools.groupby(rising, key=lambda pair: pair[1] - pair[0]):
            run = [index for _, index in group]  # indices without a gap are one call
            for index, point in zip(run, self._points(run[0], run[-1] + 1), strict=True):
                shares = zip(self.ranges.items(), point.tolist(), strict=True)
                values = {name: drawn.at(share) for (name, drawn), share in shares}
                seed = int(np.random.SeedSequence([self.seed, index]).generate_state(1)[0])
                found[index] = SweepSample(index, seed, values)
        return [found[index] for index in wanted]

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
