"""Which samples survived, over one parameter or two, with how sure that is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.config import SweepConfig
from surefoot.sweep.ranges import Interval
from surefoot.sweep.worker import CRASHED, DONE, ERROR

Z95 = 1.959963984540054
"""Of a normal distribution, 95 % lie within this many standard deviations."""
BINS = 8
"""Bins of a parameter's range."""


@dataclass(frozen=True)
class Share:
    """A share of samples and its 95 % interval (Wilson's); NaN of none."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Margin:
    """Survival over one parameter.

    Attributes
    ----------
    name
        Of the parameter.
    edges
        (bins + 1,) of its range, or for texts one number per text and one more.
    labels
        A text for each bin.
    counts, survived
        (bins,) samples that are done, and those of them that survived.
    """

    name: str
    edges: FloatArray
    labels: tuple[str, ...]
    counts: IntArray
    survived: IntArray

    def shares(self) -> list[Share]:
        """Return the share that survived, bin by bin."""
        return [wilson(int(k), int(n)) for k, n in zip(self.survived, self.counts, strict=True)]

    def effect(self) -> float:
        """Return the spread of the shares over the bins, weighted by their samples: how much it matters."""
        if not self.counts.sum():
            return 0.0
        rate = self.survived / np.maximum(self.counts, 1)
        mean = self.survived.sum() / self.counts.sum()
        return float(np.sqrt((self.counts * (rate - mean) ** 2).sum() / self.counts.sum()))


def wilson(hits: int, count: int) -> Share:
    """Return a share with Wilson's 95 % interval [1]_, which holds near 0 and 1 as well.

    .. [1] E. B. Wilson, "Probable inference, the law of succession, ...", JASA 22 (1927).

    >>> wilson(10, 10).low
    0.7224672001371107
    """
    if count == 0:
        return Share(math.nan, math.nan, math.nan)
    share, z2 = hits / count, Z95 * Z95
    middle = (share + z2 / (2.0 * count)) / (1.0 + z2 / count)
    half = Z95 * math.sqrt(share * (1.0 - share) / count + z2 / (4.0 * count * count)) / (1.0 + z2 / count)
    return Share(share, min(max(0.0, middle - half), share), max(min(1.0, middle + half), share))  # rounding


def margins(config: SweepConfig, table: Any) -> list[Margin]:
    """Return survival over each parameter that is drawn, in the order of the columns."""
    rows = _done(config, table)
    return [_margin(config, rows, name) for name in config.space.varying()]


def medians(config: SweepConfig, table: Any, name: str) -> list[dict[str, float | None]]:
    """Return, for each bin of `margins`, the median of each numeric result by name; None without samples.

    Raises
    ------
    ProblemError
        See `check_varying`.
    """
    check_varying(config, name)
    results = [column for column, kind in config.experiment.columns.items() if kind == "float"]
    rows = _done(config, table, *results)
    place, labels = _place(config, rows, name)[1:]
    return [{column: _median(rows[column][place == k]) for column in results} for k in range(len(labels))]


def check_varying(config: SweepConfig, name: str) -> None:
    """Refuse a name that is not a parameter, or has the same value in all samples.

    Raises
    ------
    ProblemError
        Listing those that vary.
    """
    if name not in config.space.varying():
        raise ProblemError(unknown_name("parameter that varies", name, config.space.varying()))


def _median(values: Any) -> float | None:
    numbers = [value for value in values if value is not None]
    return float(np.median(numbers)) if numbers else None


def counts(config: SweepConfig, table: Any) -> dict[str, int]:
    """Return how many samples are done, survived, ended with an error, and crashed."""
    status = table["status"].to_pylist()
    out = {name: status.count(name) for name in (DONE, ERROR, CRASHED)}
    return {**out, "survived": int(_done(config, table)[config.experiment.goal].sum())}


def bins_of(config: SweepConfig, name: str, count: int = BINS) -> FloatArray:
    """Return the (count + 1,) edges of a drawn number's bins, even in the scale that it is drawn in."""
    drawn = config.space.ranges[name]
    assert isinstance(drawn, Interval)
    return np.array([drawn.at(k / count) for k in range(count + 1)], dtype=np.float64)


def survival_grid(
    config: SweepConfig, table: Any, first: str, second: str, bins: int = BINS
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Return edges along two parameters, and counts and survivors: (bins, bins), the first along axis 0."""
    rows = _done(config, table)
    edges = bins_of(config, first, bins), bins_of(config, second, bins)
    places = [_bin(e, rows[n]) for e, n in zip(edges, (first, second), strict=True)]
    number, survived = np.zeros((bins, bins), dtype=np.int64), np.zeros((bins, bins), dtype=np.int64)
    np.add.at(number, tuple(places), 1)
    np.add.at(survived, tuple(places), rows[config.experiment.goal].astype(np.int64))
    return *edges, number, survived


def _done(config: SweepConfig, table: Any, *results: str) -> dict[str, Any]:
    """Return parameters, goal and more results of the samples that are done, as arrays."""
    done = np.array([status == DONE for status in table["status"].to_pylist()], dtype=np.bool_)
    names = (*config.space.names, config.experiment.goal, *results)
    return {name: np.array(table[name].to_pylist(), dtype=object)[done] for name in names}


def _bin(edges: FloatArray, values: Any) -> IntArray:
    """Return the bin of each value."""
    numbers = np.asarray(values, dtype=np.float64)
    return np.clip(np.searchsorted(edges, numbers, side="right") - 1, 0, len(edges) - 2)


def _place(
    config: SweepConfig, rows: dict[str, Any], name: str
) -> tuple[FloatArray, IntArray, tuple[str, ...]]:
    """Return a parameter's edges, the bin of each row, and a label for each bin."""
    if config.space.kind(name) == "text":
        texts = tuple(dict.fromkeys(config.space.ranges[name].as_dict()["choices"]))
        place = np.array([texts.index(text) for text in rows[name]], dtype=np.int64)
        return np.arange(len(texts) + 1, dtype=np.float64), place, texts
    edges = bins_of(config, name)
    return edges, _bin(edges, rows[name]), tuple(f"{a:.3g} to {b:.3g}" for a, b in pairwise(edges))


def _margin(config: SweepConfig, rows: dict[str, Any], name: str) -> Margin:
    edges, place, labels = _place(config, rows, name)
    number, good = len(labels), rows[config.experiment.goal].astype(np.bool_)
    every, survivors = np.bincount(place, minlength=number), np.bincount(place[good], minlength=number)
    return Margin(name, edges, labels, every.astype(np.int64), survivors.astype(np.int64))
