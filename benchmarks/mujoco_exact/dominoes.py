"""A row of dominoes, of which each pushes the next, and its closed motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.mujoco_exact.scenes import PLANE, bodies
from surefoot.base.arrays import FloatArray

COUNT = 8
THICK, HIGH, GAP = 0.04, 0.2, 0.08
"""Of a domino, and between two [m]."""
PUSH = 3.0
"""Rate at which the first one starts about its lower edge [rad/s]."""
HIT = 0.05
"""Rate of a domino that has been hit [rad/s]."""


def dominoes() -> Any:
    """Return a row of dominoes in a plane that do not slip on the ground and slide on each other."""
    joints = "".join(f'<joint type="{kind}" axis="{axis}"/>' for kind, axis in PLANE)
    size = f'size="{0.5 * THICK} 0.05 {0.5 * HIGH}"'
    parts = [
        f'<body pos="{k * (GAP + THICK)} 0 {0.5 * HIGH}">{joints}'
        f'<geom name="d{k}" type="box" {size} mass="0.1" contype="0" conaffinity="0"/></body>'
        for k in range(COUNT)
    ]
    ground = "".join(f'<pair geom1="ground" geom2="d{k}" friction="5 5 0 0 0"/>' for k in range(COUNT))
    beside = "".join(f'<pair geom1="d{k}" geom2="d{k + 1}" condim="1"/>' for k in range(COUNT - 1))
    return bodies(*parts, extra=f"<contact>{ground}{beside}</contact>")


def push(data: Any) -> None:
    """Turn the first domino about its lower edge."""
    data.qvel[:3] = 0.5 * HIGH * PUSH, 0.5 * THICK * PUSH, PUSH


def toppling_time(points: int = 400) -> float:
    """Return when the last domino is hit [s]: each turns about its lower edge and leans on the next.

    J. M. J. van Leeuwen, "The domino effect", American Journal of Physics 78, 2010, without friction
    between dominoes: all angles follow from that of the foremost, which keeps its energy, and an impact
    keeps the momentum that belongs to it. The time is a quadrature of that energy.
    """
    inertia, weight = (HIGH**2 + THICK**2) / 3.0, 9.81
    x, w = np.polynomial.legendre.leggauss(points)
    ends = np.arcsin(GAP / HIGH)
    angle = np.r_[0.0, 0.5 * ends * (1.0 + x), ends]
    rate, time = PUSH, 0.0
    for count in range(1, COUNT):
        angles, slopes = _row(angle, count)
        mass = inertia * (slopes**2).sum(axis=0)
        height = weight * 0.5 * (THICK * np.sin(angles) + HIGH * np.cos(angles)).sum(axis=0)
        rates = np.sqrt(2.0 * (0.5 * mass[0] * rate**2 + height[0] - height) / mass)
        time += 0.5 * ends * float(w @ (1.0 / rates[1:-1]))
        moving = float((slopes[:, -1] ** 2).sum())
        rate = float(rates[-1]) * moving / (1.0 + moving)
    return time


def _row(angle: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """Return (count, points) angles of dominoes in a row, and their slopes by the foremost's."""
    angles, slopes = [angle], [np.ones_like(angle)]
    for _ in range(count - 1):
        before = angles[-1]
        sine = ((GAP + THICK) * np.cos(before) - THICK) / HIGH
        slope = 1.0 - (GAP + THICK) * np.sin(before) / HIGH / np.sqrt(1.0 - sine**2)
        angles.append(before + np.arcsin(sine))
        slopes.append(slopes[-1] * slope)
    return np.array(angles), np.array(slopes)
