"""Around the contacts of a stance in space: ground and walls, the robot, and labels beside the cones."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.app.viz.palette import BODY, GROUND, GROUND_LINE, SMALL_SIZE
from surefoot.app.viz.shapes import bones
from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Robot
from surefoot.mechanics.stance import Contact, Stance

AROUND = 0.22
"""How far a surface goes beyond its contacts, in sizes of the scene."""
BESIDE = 0.16
"""How far a label is behind its contact's surface, in sizes of the scene."""
ON_TOP = 1000
"""Of a text: Matplotlib numbers surfaces from below, so that a label of the usual place is behind them."""
SAME_PLANE = 0.02
"""Contacts whose planes differ by less than this [rad, sizes of the scene] stand on one surface."""


def surfaces(stance: Stance, size: float) -> list[FloatArray]:
    """Return the (4, 3) corners of each plane that contacts stand on, somewhat beyond them [m]."""
    return [_rectangle(group, AROUND * size) for group in _by_surface(stance, size)]


def _by_surface(stance: Stance, size: float) -> list[list[Contact]]:
    """Return the contacts of each plane."""
    groups: list[list[Contact]] = []
    for contact in stance:
        for group in groups:
            normal = group[0].rotation_world_contact[:, 2]
            apart = abs(float((contact.position - group[0].position) @ normal))
            turned = float(np.linalg.norm(contact.rotation_world_contact[:, 2] - normal))
            if turned < SAME_PLANE and apart < SAME_PLANE * size:
                group.append(contact)
                break
        else:
            groups.append([contact])
    return groups


def _rectangle(group: list[Contact], beyond: float) -> FloatArray:
    """Return the corners of the rectangle around contacts in the plane of the first."""
    frame, origin = group[0].rotation_world_contact, group[0].position
    corners = [c.position for one in group for c in one.corners()] if group[0].dim == 6 else []  # type: ignore[attr-defined]
    points = np.array([*(one.position for one in group), *corners])
    flat = (points - origin) @ frame[:, :2]
    (x0, y0), (x1, y1) = flat.min(axis=0) - beyond, flat.max(axis=0) + beyond
    return np.asarray(origin + np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) @ frame[:, :2].T)


def draw_surfaces(axis: Any, stance: Stance, size: float) -> None:
    """Draw ground and walls as far as contacts tell of them."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    corners = surfaces(stance, size)
    if corners:
        look = {"facecolor": GROUND, "edgecolor": GROUND_LINE, "linewidth": 0.8, "alpha": 0.45, "zorder": -1}
        axis.add_collection3d(Poly3DCollection(corners, **look))


def draw_bones(axis: Any, robot: Robot, q: FloatArray) -> None:
    """Draw the links of a robot at (nq,) q [m, -, rad] as lines."""
    for line in bones(robot, q):
        axis.plot(*line.T, color=BODY, lw=2.2, alpha=0.75, solid_capstyle="round")


def draw_labels(axis: Any, stance: Stance, size: float, labels: list[tuple[str, str]]) -> None:
    """Write words in a colour beside each contact, in their order: behind its surface, off its neighbours.

    Cones are before the surface, so that no label covers one.
    """
    of_contact = {id(contact): label for contact, label in zip(stance, labels, strict=True)}
    for group in _by_surface(stance, size):
        middle = np.mean([contact.position for contact in group], axis=0)
        for contact in group:
            _label(axis, contact, middle, size, *of_contact[id(contact)])


def _label(axis: Any, contact: Contact, middle: FloatArray, size: float, words: str, colour: str) -> None:
    away = contact.position - middle
    normal = contact.rotation_world_contact[:, 2]
    away = away - (away @ normal) * normal
    length = float(np.linalg.norm(away))
    aside = away / length if length > 1e-9 else np.zeros(3)
    place = contact.position + BESIDE * size * (1.3 * aside - (0.6 if length > 1e-9 else 1.3) * normal)
    look = {"fontsize": SMALL_SIZE, "color": colour, "ha": "center", "va": "center", "zorder": ON_TOP}
    axis.text(*place, words, **look)
