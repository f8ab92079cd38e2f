"""Drawings of feet: the shape from below, what of it was read as the contact, and a side view."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.robots.trial import Candidate
from surefoot.base.arrays import FloatArray
from surefoot.mechanics import load_robot

DEPTH = 0.1
"""How far above the contact a foot's shape is drawn [m]."""


def draw_foot(one: Candidate, folder: Path) -> Path:
    """Draw the first foot of a robot; return the picture's path.

    Points are corners of the collision shapes of its joint, or of what is drawn there, coloured by their
    height over the contact; the line is the contact.

    Raises
    ------
    ModelError
        If the robot or its feet cannot be read.
    """
    from matplotlib.figure import Figure

    robot = load_robot(one.robot, one.feet or None)
    foot = robot.feet[0]
    points, sole = _points(robot, foot), _outline(foot)
    low = float(foot.centres[:, 2].mean() - foot.radius)
    near = points[points[:, 2] <= low + DEPTH]
    figure = Figure(figsize=(9.0, 3.2), layout="constrained")
    below, side = figure.subplots(1, 2)
    for axes, k in ((below, 1), (side, 2)):
        axes.scatter(1e3 * near[:, 0], 1e3 * near[:, k], c=1e3 * (near[:, 2] - low), s=3, vmin=0.0, vmax=30.0)
        axes.plot(1e3 * sole[:, 0], 1e3 * (sole[:, k] - (foot.radius if k == 2 else 0.0)), "r-o", lw=1, ms=3)
        axes.set_aspect("equal")
        axes.set_xlabel("x [mm]")
    below.set_ylabel("y [mm]")
    side.set_ylabel("z [mm]")
    figure.suptitle(f"{one.name}: {foot.why}"[:150], fontsize=7)
    path = folder / f"{one.name.split(',')[0].replace(' ', '_').replace('/', '_')}.png"
    figure.savefig(path, dpi=80)
    return path


def _outline(foot: Any) -> FloatArray:
    """Return the places of a contact's balls around its outline, the first once more: (k + 1, 3) [m]."""
    if not foot.flat:
        return np.vstack([foot.centres, foot.centres])
    level = np.full((len(foot.corners), 1), foot.centre[2])
    around = np.hstack([foot.corners + foot.centre[:2], level])
    return np.vstack([around, around[:1]])


def _points(robot: Any, foot: Any) -> FloatArray:
    """Return corners and rims of all shapes that move with a foot, in its frame: (k, 3) [m]."""
    from surefoot.mechanics.robot.foot_parts import foot_part

    frame = robot.model.frames[foot.frame]
    out = []
    for geometry in (robot.collision, robot.visual):
        for item in geometry.geometryObjects:
            if int(item.parentJoint) == int(frame.parentJoint):
                part = foot_part(item, frame.placement.actInv(item.placement), np.array([0.0, 0.0, 1.0]))
                if part is not None:
                    out.append(_with_rims(part.points, part.radius))
        if out:
            break
    return np.vstack(out) if out else foot.centres


def _with_rims(points: FloatArray, radius: float) -> FloatArray:
    """Return points with circles of a radius about them, level and upright."""
    if radius <= 0.0:
        return points
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    c, s, none = np.cos(turn), np.sin(turn), np.zeros(24)
    rims = radius * np.vstack([np.column_stack([c, s, none]), np.column_stack([c, none, s])])
    return (points[:, None] + rims[None]).reshape(-1, 3)
