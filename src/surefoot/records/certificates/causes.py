"""Why frames are impossible: what would have to be otherwise for forces to exist."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.frame_data import FrameData
from surefoot.records.certificates.frame_kernels import Answer

STICKS = 1e9
"""Speed below which everything sticks, to ask what sliding is at fault for [m/s]."""
ROUGH = 10.0
"""Factor on friction, to ask what it is at fault for [-]."""
HELPS = 0.5
"""Share of a residual that is left at most without sliding where sliding is at fault [-]."""
CLEAR = 0.5
"""Share of the limit below which friction that is not there explains a frame: more of it hides a moment."""
FALLS = 0.9
"""Share of its weight that a stretch in the air mostly needs at most while it falls: else it hangs [m g]."""


def find_causes(
    data: FrameData, answer: Answer, frames: IntArray, limit: float, gaps: FloatArray, names: tuple[str, ...]
) -> tuple[NDArray[np.str_], NDArray[np.str_]]:
    """Return the causes (T,) of impossible frames and the joints (T,) that are to blame.

    In the air a motion hangs where it needs its weight, and else disobeys gravity. On the ground the cause is
    the first of limits on torques, sliding and friction without which forces exist; where none helps, the
    needed forces lie beyond the edges of what touches.

    Parameters
    ----------
    data, answer
        Of the motion, and what was found.
    frames
        The impossible ones.
    limit
        Residual from which they are [m g].
    gaps
        (T,) distance of the lowest point at each frame [m].
    names
        (j,) names of the joints.
    """
    count = len(gaps)
    cause, joint = np.full(count, "", dtype="<U24"), np.full(count, "", dtype="<U64")
    if not len(frames):
        return cause, joint
    air = gaps[frames] > data.model.rules.clearance
    weight = data.model.rules.mass * GRAVITY
    for stretch in _stretches(frames[air]):
        # not the mean: a jump up or down at either end is in it
        falls = float(np.median(answer.needed[stretch, 2])) / weight < FALLS
        cause[stretch] = "dynamics in flight" if falls else "hangs"
    rest = frames[~air]
    if names:
        worst = np.argmax(np.abs(answer.torques), axis=1)
        weak = rest[np.abs(answer.torques[rest]).max(axis=1) > 0.0]
        weak = weak[data.solve(weak, torques=False).share[weak] <= limit]
        for k in weak:
            j = worst[k]
            fast = (data.model.motors.high[k, j] == 0.0) | (data.model.motors.low[k, j] == 0.0)
            cause[k] = "speed" if fast else "torque of a joint"
            joint[k] = names[j]
        rest = np.setdiff1d(rest, weak)
    held = rest[answer.sliding[rest] > 0]
    stuck = data.solve(held, stick=STICKS).share[held]
    held = held[stuck <= np.maximum(limit, HELPS * answer.share[held])]
    cause[held] = "slides"
    rest = np.setdiff1d(rest, held)
    rough = data.solve(rest, stick=STICKS, mu_scale=ROUGH).share
    cause[rest] = np.where(rough[rest] <= CLEAR * limit, "friction", "tips over the sole")
    return cause, joint


def _stretches(frames: IntArray) -> list[IntArray]:
    """Return frames in groups of neighbours."""
    return np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1) if len(frames) else []
