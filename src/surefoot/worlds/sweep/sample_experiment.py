"""One way to try out a sample: settings that are its fields, results by name, and how it is run."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from surefoot.base.errors import check_name
from surefoot.base.lazy_table import LazyTable
from surefoot.base.settings import bounded_number, check_settings, info_of

KINDS = ("float", "bool", "text")
"""Types of a result's columns."""


def number(default: float | None, low: float, high: float, unit: str = "") -> Any:
    """Return a field of an experiment: a number within limits, which a sweep can draw."""
    return bounded_number(default, low, high, unit)


@dataclass(frozen=True)
class SweepExperiment(ABC):
    """A frozen dataclass whose fields are the experiment's settings; it travels to the workers.

    A sweep can draw every setting that is a `number` or a text. The order of the fields is that of the
    dimensions of the samples' sequence, whatever the file's order.

    Attributes
    ----------
    columns
        Results: name to one of `KINDS`. The first is a bool, whether the sample survived.
    chunk
        Samples that are sent to a worker at a time: a quarter of a second's worth or so.
    code
        What tells one version of somebody's own function from another; empty for the package's.
    """

    columns: ClassVar[Mapping[str, str]]
    chunk: ClassVar[int] = 1
    code: ClassVar[str] = ""

    def __post_init__(self) -> None:
        check_settings(self)

    @abstractmethod
    def run(self, seed: int) -> dict[str, Any]:
        """Return the results, a value (or None) for each of `columns`.

        Whatever is random depends on the seed alone. A `SurefootError` is recorded; a sweep goes on.
        """

    def check(self) -> None:
        """Refuse, before long work, what cannot be run and is too slow to look at for every sample.

        Raises
        ------
        ProblemError, ModelError
            Naming what is wrong.
        """
        return

    @property
    def goal(self) -> str:
        """The column that says whether a sample survived."""
        return next(iter(self.columns))

    @classmethod
    def numbers(cls) -> tuple[str, ...]:
        """Return the settings that are numbers."""
        return tuple(f.name for f in fields(cls) if info_of(cls, f.name) is not None)

    def parameters(self) -> tuple[str, ...]:
        """Return the settings that a sweep can draw, in the order of the sequence's dimensions."""
        numbers = self.numbers()
        return tuple(
            f.name for f in fields(self) if f.name in numbers or isinstance(getattr(self, f.name), str)
        )

    @classmethod
    def limits(cls, name: str) -> tuple[float, float]:
        """Return the least and the largest value of a number that make sense."""
        info = info_of(cls, name)
        low, high = (None, None) if info is None else (info.low, info.high)
        return -math.inf if low is None else low, math.inf if high is None else high

    @classmethod
    def unit(cls, name: str) -> str:
        """Return the unit of a setting, empty for none."""
        info = info_of(cls, name)
        return "" if info is None else info.unit


EXPERIMENTS: LazyTable[type[SweepExperiment]] = LazyTable(
    "experiment",
    {
        "drop": "surefoot.worlds.sweep.drop:DropExperiment",
        "walk": "surefoot.worlds.sweep.robots:WalkTrial",
    },
)
"""Name to class."""


def make_experiment(name: str, settings: Mapping[str, Any] | None = None) -> SweepExperiment:
    """Return an experiment of the table with its settings.

    Raises
    ------
    ProblemError
        For an unknown name, and a setting that the experiment does not have or cannot take.
    """
    kind = EXPERIMENTS.load(name)
    known = [f.name for f in fields(kind)]
    for key in settings or {}:
        check_name(f"setting of {name}", key, known)
    return kind(**(settings or {}))
