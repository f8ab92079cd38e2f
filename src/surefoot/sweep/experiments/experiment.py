"""One way to try out a sample: what it takes, what it gives, and how it is run."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from surefoot.arrays import real_number
from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.space import Sample, Space

KINDS = ("float", "bool", "text")
"""Types of a result's columns."""


@dataclass(frozen=True)
class Experiment(ABC):
    """A frozen dataclass whose fields are the experiment's settings; it travels to the workers.

    Attributes
    ----------
    parameters
        Names of what a sweep of it can draw, see `surefoot.sweep.parameters.PARAMETERS`.
    columns
        Results: name to one of `KINDS`. The first is a bool, whether the sample survived.
    chunk
        Samples that are sent to a worker at a time: a quarter of a second's worth or so.
    packages
        That it needs.
    limits
        Settings that are numbers, to their least and largest values.
    """

    parameters: ClassVar[tuple[str, ...]]
    columns: ClassVar[Mapping[str, str]]
    chunk: ClassVar[int] = 1
    packages: ClassVar[tuple[str, ...]] = ()
    limits: ClassVar[Mapping[str, tuple[float, float]]] = {}

    def __post_init__(self) -> None:
        for name, (low, high) in self.limits.items():
            object.__setattr__(self, name, real_number(name, getattr(self, name), low=low, high=high))

    @abstractmethod
    def run(self, sample: Sample) -> dict[str, Any]:
        """Return the results of a sample, a value (or None) for each of `columns`.

        A `SurefootError` is recorded with the sample; a sweep goes on.
        """

    def check(self, space: Space) -> None:
        """Refuse, before long work, what cannot be run; extend it for what an experiment knows.

        Raises
        ------
        ProblemError, ModelError
            Naming what is wrong.
        """
        for name in space.names:
            if name not in self.parameters:
                raise ProblemError(unknown_name("parameter of this experiment", name, self.parameters))
        ground = [n for n in ("terrain", "slope", "roughness") if n in space.names]
        if len(ground) > 1:
            raise ProblemError(f"{' and '.join(ground)} are each a ground of their own: give one")
        if "damping" in space.names and "stiffness" not in space.names:
            raise ProblemError("damping goes with stiffness: rigid ground has none")
        if "restitution" in space.names and "stiffness" in space.names:
            raise ProblemError("restitution is of rigid ground, stiffness of soft: give one of the two")

    @property
    def goal(self) -> str:
        """The column that says whether a sample survived."""
        return next(iter(self.columns))

    def as_dict(self) -> dict[str, Any]:
        """Return the settings by name."""
        return {f.name: getattr(self, f.name) for f in fields(self)}


def with_settings(kind: type[Experiment], name: str, settings: Mapping[str, Any]) -> Experiment:
    """Return an experiment of a class with settings from a file.

    Raises
    ------
    ProblemError
        For a setting that it does not have, or cannot take.
    """
    known = [f.name for f in fields(kind)]
    for key in settings:
        if key not in known:
            raise ProblemError(unknown_name(f"setting of {name}", key, known))
    return kind(**settings)
