"""Bounds on states: what a task asks of some knots, and what a robot's joints allow in all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_array
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot

UNBOUNDED = 1e15
"""Limits of a model beyond this are none."""


@dataclass(frozen=True, eq=False)
class StateWindow:
    """Bounds on the state at a knot; None for none, infinite entries for those that are free.

    Attributes
    ----------
    q_low, q_high
        (nq,) Pinocchio's order; of a quaternion its four numbers.
    v_low, v_high
        (nv,).
    """

    q_low: FloatArray | None = None
    q_high: FloatArray | None = None
    v_low: FloatArray | None = None
    v_high: FloatArray | None = None

    @classmethod
    def at(
        cls, q: ArrayLike | None = None, v: ArrayLike | None = None, within: ArrayLike = 0.0,
        speed: ArrayLike = 0.0,
    ) -> StateWindow:  # fmt: skip
        """Return the window about (nq,) q, (nv,) v, NaN left free: ± `within` [m, rad], `speed` [m/s]."""
        sides = list[FloatArray | None]()
        for value, reach in ((q, within), (v, speed)):
            if value is None:
                sides += [None, None]
                continue
            middle = np.asarray(value, dtype=np.float64)
            sides += [
                np.where(np.isnan(middle), s * np.inf, middle + s * np.asarray(reach)) for s in (-1.0, 1.0)
            ]
        return cls(*sides)

    def narrow(self, low: FloatArray, high: FloatArray, nq: int, knot: int) -> None:
        """Write the window into bounds (nq + nv,) of a knot's state.

        Raises
        ------
        ProblemError
            Where it leaves nothing within the bounds, or does not fit.
        """
        places, speeds = slice(0, nq), slice(nq, None)
        sides = (("q", places, self.q_low, self.q_high), ("v", speeds, self.v_low, self.v_high))
        for name, part, least, most in sides:
            shape = low[part].shape
            if least is not None:
                low[part] = np.maximum(low[part], real_array(f"{name}_low", least, shape))
            if most is not None:
                high[part] = np.minimum(high[part], real_array(f"{name}_high", most, shape))
            empty = low[part] > high[part]
            if empty.any():
                said = f"{name} of the window at knot {knot}[{int(np.argmax(empty))}]"
                raise ProblemError(f"{said} leaves nothing within the limits")


def limit_joints(robot: Robot, low: FloatArray, high: FloatArray, speed_share: float = 1.0) -> None:
    """Write the model's joint limits into bounds (knots + 1, nq + nv) on states, but for the first."""
    model, base = robot.model, (7 if robot.floating else 0)
    nq = int(model.nq)
    below, above = np.array(model.lowerPositionLimit)[base:], np.array(model.upperPositionLimit)[base:]
    low[1:, base:nq] = np.where((below < above) & (below > -UNBOUNDED), below, -np.inf)
    high[1:, base:nq] = np.where((below < above) & (above < UNBOUNDED), above, np.inf)
    speed = speed_share * robot.speed_limits
    low[1:, nq + robot.base_dof :], high[1:, nq + robot.base_dof :] = -speed, speed
