"""What is found of every frame of a motion, as arrays of one length."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from surefoot.base.arrays import FloatArray, IntArray

MotionVerdict: TypeAlias = Literal["possible", "cannot tell", "impossible"]
"""Forces within all limits leave less than the noise; in between; no forces leave less than the limit."""
NO_WINDOW = "no window"
"""Verdict of frames at the ends of a motion, whose window is not whole."""
CAUSES = (
    "", "hangs", "slides", "tips over the sole", "friction", "torque of a joint", "stop", "speed",
    "dynamics in flight",
)  # fmt: skip
"""Why a frame's bound is above the limit, "" for others. "stop": a joint is beyond its stop as well."""


@dataclass(frozen=True, eq=False)
class FrameTable:
    """Arrays over the T frames of a motion; NaN where a frame has no whole window.

    Attributes
    ----------
    time
        (T,) [s].
    verdict
        (T,) "possible", "cannot tell", "impossible" or "no window".
    force, moment
        (T, 3) what no forces can give of what is needed, moment about the centre of mass, world axes [N, N
        m].
    share
        (T,) size of what the best forces leave, moments over 0.3 m [m g].
    bound
        (T,) what no forces leave less than, by the frame's certificate [m g].
    detour
        (T,) how far the centre of mass would have to leave its way, while the bound is above the limit, for
        forces to exist [m]; 0 for others.
    cause
        (T,) of `CAUSES`.
    joint
        (T,) name of the joint whose torque or stop is the cause, else "".
    contacts, sliding
        (T,) points that may touch the ground in the window, and those of them that slide.
    slide_speed
        (T,) of the point that slides least [m/s]; infinite without a contact.
    penetration, gap
        (T,) depth of the lowest point in the ground, and its distance above it, at the frame [m].
    range
        (T,) largest angle or way of a joint beyond its stop [rad, m].
    noise
        (T,) deviation of the base's place that its fourth difference amounts to: shaking and jumps [m].
    """

    time: FloatArray
    verdict: NDArray[np.str_]
    force: FloatArray
    moment: FloatArray
    share: FloatArray
    bound: FloatArray
    detour: FloatArray
    cause: NDArray[np.str_]
    joint: NDArray[np.str_]
    contacts: IntArray
    sliding: IntArray
    slide_speed: FloatArray
    penetration: FloatArray
    gap: FloatArray
    range: FloatArray
    noise: FloatArray

    def __len__(self) -> int:
        return len(self.time)

    def columns(self) -> dict[str, Any]:
        """Return the arrays as columns by name, vectors by their axes."""
        out: dict[str, Any] = {}
        for one in fields(self):
            values = getattr(self, one.name)
            if values.ndim == 1:
                out[one.name] = values
                continue
            for k, axis in enumerate("xyz"):
                out[f"{one.name}_{axis}"] = values[:, k]
        return out
