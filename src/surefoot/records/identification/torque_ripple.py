"""Torque that a motor adds by where it stands: cogging of its slots, ripple of its currents.

Both repeat with the motor's turn, so many times per radian of the joint. Which is found from the torque that
a model leaves over: its Fourier transform over the angle, part by part of a recording. A line is there where
the parts agree about amplitude and phase; noise does not.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray

LINES = np.arange(20.0, 500.0, 0.25)
"""Periods per turn that are tried [1/rad]; slower ones cannot be separated from a motion's own torque."""
MOST = 2
"""Lines of one joint."""
AGREEING = 3.5
"""Standard errors from part to part that a line's amplitude must have."""
MOVING = 0.1
"""Speed from which a joint tells them [rad/s]."""


def ripple_lines(q: FloatArray, speed: FloatArray, torque: FloatArray, parts: int) -> list[float]:
    """Return the lines [1/rad] in (T,) torques [N m] at angles [rad] and speeds [rad/s], strongest first."""
    moves = np.abs(speed) > MOVING
    q, weight, left = q[moves], np.abs(speed[moves]), torque[moves]
    found: list[float] = []
    if len(q) < 10 * parts:
        return found
    starts = np.linspace(0, len(q), parts + 1).astype(int)[:-1]
    for _ in range(MOST):
        # Over the angle, not over time: dq = |q̇| dt is the weight.
        waves = [np.add.reduceat(np.exp(-1j * n * q) * weight * left, starts) for n in LINES]
        each = np.array(waves) / np.add.reduceat(weight, starts)
        mean = each.mean(axis=1)
        spread = np.linalg.norm(each - mean[:, None], axis=1) / np.sqrt(parts * (parts - 1))
        heard = np.where(np.abs(mean) > AGREEING * spread, np.abs(mean), 0.0)
        if not heard.any():
            break
        found.append(float(LINES[np.argmax(heard)]))
        wave = np.stack([np.sin(found[-1] * q), np.cos(found[-1] * q)], axis=1)
        left = left - wave @ np.linalg.lstsq(wave, left, rcond=None)[0]
    return found
