"""A robot's feet as arrays to write to: they stand, until something is changed."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log

DT, MASS, MU = 1e-3, 15.0, 0.6
"""Step [s], mass of a quadruped of Go2's size [kg] and friction of rubber on a dry floor [-]."""
WEIGHT = MASS * GRAVITY


class Made:
    """Rows of a stand.

    Parameters
    ----------
    rows
        How many.
    dt, said
        Step of the time stamps, and what the log says of it, None for the same [s].
    mass
        [kg].
    mu
        Friction of the ground.
    feet
        How many.
    facts
        More facts of the log.
    """

    def __init__(
        self, rows: int, *, dt: float = DT, said: float | None = None, mass: float = MASS, mu: float = MU,
        feet: int = 4, **facts: Any,
    ) -> None:  # fmt: skip
        self.time: FloatArray = dt * np.arange(rows, dtype=np.float64)
        self.weight = mass * GRAVITY
        self.forces: FloatArray = np.zeros((rows, feet, 3))
        sway = 1e-3 * np.sin(2.0 * np.pi * 1.3 * self.time[:, None] + np.arange(feet))
        self.forces[..., 2] = self.weight / feet * (1.0 + sway)
        self.velocities: FloatArray = np.zeros((rows, feet, 3))
        self.gaps: FloatArray = np.zeros((rows, feet))
        self.mu: FloatArray = np.full(rows, mu, dtype=np.float64)
        self.more: dict[str, Any] = {}
        names = [f"foot {k}" for k in range(feet)]
        step = dt if said is None else said
        self.facts = {"mass": mass, "dt": step, "feet": names, "contact_foot": list(range(feet)), **facts}

    def log(self) -> Log:
        """Return the log of it."""
        arrays = {
            "time": self.time, "forces": self.forces, "contact_velocities": self.velocities,
            "gaps": self.gaps, "mu": self.mu, **self.more,
        }  # fmt: skip
        return Log(arrays, self.facts)


def arrays_of(log: Log) -> dict[str, Any]:
    """Return copies of a log's arrays, to be written to."""
    return {name: np.array(array) for name, array in log.arrays.items()}


def changed_log(clean: Log, arrays: dict[str, Any], **facts: Any) -> Log:
    """Return a log with other arrays, and some other facts."""
    return Log(arrays, {**clean.facts, **facts}, channels=clean.channels)
