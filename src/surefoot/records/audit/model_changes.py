"""What a log says that its loop changed in the model while it ran."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import finite_array
from surefoot.base.errors import ProblemError, shown
from surefoot.records.log import Log


class ModelChange(NamedTuple):
    """One number of the model that the loop changed.

    Attributes
    ----------
    time
        When [s].
    kind, name
        What of the model ("mass", "gain", ...), and whose.
    factor
        The new number over the old [-].
    """

    time: float
    kind: str
    name: str
    factor: float


def logged_changes(log: Log) -> list[ModelChange]:
    """Return what a log's facts say of changes, in their order; empty where they say nothing.

    Raises
    ------
    ProblemError
        For facts that are no lists of the same length.
    """
    facts = {name: log.facts.get(f"change_{name}", []) for name in ("time", "kind", "name", "factor")}
    for name, value in facts.items():
        if not isinstance(value, (list, tuple, np.ndarray)):
            raise ProblemError(f"the fact change_{name} must be a list, got {shown(value)}")
    sizes = {f"change_{name}": len(value) for name, value in facts.items()}
    if len(set(sizes.values())) > 1:
        raise ProblemError(f"facts of the model's changes must be as long as each other, got {sizes}")
    time, factor = (finite_array(f"the fact change_{name}", facts[name]) for name in ("time", "factor"))
    rows = zip(time.tolist(), facts["kind"], facts["name"], factor.tolist(), strict=True)
    return [ModelChange(when, str(kind), str(name), by) for when, kind, name, by in rows]


def masses_changed(log: Log) -> bool:
    """Return whether the loop changed masses of its model."""
    return any(change.kind == "mass" for change in logged_changes(log))
