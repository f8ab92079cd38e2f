"""Which samples survived, over one parameter or two, with how sure that is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import binomtest

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.worlds.sweep.config import SweepConfig
from surefoot.worlds.sweep.space import TextRange
from surefoot.worlds.sweep.sweep_worker import CRASHED, DONE, ERROR

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
    """Survival over one parameter, of the samples that are done.

    Attributes
    ----------
    name
        Of the parameter.
    edges
        (bins + 1,) of its range, or for texts one number per text and one more.
    labels
        A text for each bin.
    counts, survived
        (bins,) samples, and those of them that survived.
    medians
        For each bin the median of each numeric result by name; None without samples.
    """

    name: str
    edges: FloatArray
    labels: tuple[str, ...]
    counts: IntArray
    survived: IntArray
    medians: tuple[dict[str, float | None], ...]

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

    >>> round(wilson(10, 10).low, 6)
    0.722467
    """
    if count == 0:
        return Share(math.nan, math.nan, math.nan)
    found = binomtest(hits, count).proportion_ci(method="wilson")
    return Share(hits / count, float(found.low), float(found.high))


def margins(config: SweepConfig, table: Any) -> list[Margin]:
    """Return survival over each parameter that varies, in the order of the columns."""
    rows, goal = _finished_rows(table), config.experiment.goal
    results = [name for name, kind in config.experiment.columns.items() if kind == "float"]
    survived = _values(rows, goal).astype(np.bool_)
    found = []
    for name in config.space.varying:
        edges, place, labels = _bins(config, rows, name)
        number = len(labels)
        found.append(
            Margin(
                name, edges, labels,
                np.bincount(place, minlength=number), np.bincount(place[survived], minlength=number),
                tuple(_medians(rows, results, place == k) for k in range(number)),
            )
        )  # fmt: skip
    return found


def counts(config: SweepConfig, table: Any) -> dict[str, int]:
    """Return how many samples are done, survived, ended with an error, and crashed."""
    status = table["status"].to_pylist()
    out = {name: status.count(name) for name in (DONE, ERROR, CRASHED)}
    return {**out, "survived": table[config.experiment.goal].to_pylist().count(True)}


def survival_grid(
    config: SweepConfig, table: Any, first: str, second: str, bins: int = BINS
) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Return edges along two parameters, and counts and survivors: (bins, bins), the first along axis 0."""
    rows = _finished_rows(table)
    (x, i, _), (y, j, _) = (_bins(config, rows, name, bins) for name in (first, second))
    number, survived = np.zeros((bins, bins), dtype=np.int64), np.zeros((bins, bins), dtype=np.int64)
    np.add.at(number, (i, j), 1)
    np.add.at(survived, (i, j), _values(rows, config.experiment.goal).astype(np.int64))
    return x, y, number, survived


def _finished_rows(table: Any) -> Any:
    """Return the rows that have results."""
    return table.filter(np.array([status == DONE for status in table["status"].to_pylist()], dtype=np.bool_))


def _values(rows: Any, name: str) -> Any:
    """Return a column of numbers as an array (n,); NaN for what is missing."""
    return np.array(rows[name].to_pylist(), dtype=np.float64)


def _bins(
    config: SweepConfig, rows: Any, name: str, count: int = BINS
) -> tuple[FloatArray, IntArray, tuple[str, ...]]:
    """Return a parameter's edges, even in the scale it is drawn in, the bin of each row, and labels."""
    drawn = config.space.ranges[name]
    if isinstance(drawn, TextRange):
        texts = tuple(dict.fromkeys(drawn.choices))
        place = np.array([texts.index(text) for text in rows[name].to_pylist()], dtype=np.int64)
        return np.arange(len(texts) + 1, dtype=np.float64), place, texts
    edges = np.array([drawn.at(k / count) for k in range(count + 1)], dtype=np.float64)
    place = np.clip(np.searchsorted(edges, _values(rows, name), side="right") - 1, 0, count - 1)
    return edges, place, tuple(f"{a:.3g} to {b:.3g}" for a, b in pairwise(edges))


def _medians(rows: Any, results: list[str], chosen: BoolArray) -> dict[str, float | None]:
    """Return the median of each result over the chosen rows, without those that have none."""
    known = {name: _values(rows, name)[chosen] for name in results}
    return {n: None if np.isnan(v).all() else float(np.nanmedian(v)) for n, v in known.items()}
