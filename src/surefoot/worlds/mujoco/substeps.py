"""What the ground did in one step of a world that makes it in several: the mean of what it did in each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics import Terrain, frames_on
from surefoot.worlds.interface.world import ContactReading
from surefoot.worlds.mujoco.readings import LEAST_FORCE, SAME_FACE

STRIKE_SUBSTEPS = 16
"""Parts of a step of 1 ms in which feet may strike what they do not see."""
MOST_SUBSTEPS = 64


class WholeStep(NamedTuple):
    """What happened in a step that is over and cannot be read from MuJoCo again.

    Attributes
    ----------
    contacts
        What the ground did at the feet's spheres.
    touching
        Names of links, feet or ground that touched, without feet on ground.
    """

    contacts: ContactReading
    touching: tuple[tuple[str, str], ...]


_WORDS = ("forces", "positions", "velocities")


def substeps_of(terrain: Terrain, knowledge: str) -> int:
    """Return into how many parts a step of 1 ms is to be divided for a walk.

    Parameters
    ----------
    terrain
        The true ground.
    knowledge
        What the robot knows of it, of `surefoot.motion.ground.terrain_knowledge.KNOWLEDGE`.

    Examples
    --------
    >>> from surefoot.mechanics.terrain import FlatTerrain, StairsTerrain
    >>> substeps_of(FlatTerrain(), "blind"), substeps_of(StairsTerrain(0.1, 0.3), "blind")
    (1, 16)
    """
    return STRIKE_SUBSTEPS if knowledge == "blind" and not terrain.planar else 1


def mean_reading(readings: Sequence[ContactReading]) -> tuple[ContactReading, FloatArray]:
    """Return what the ground did in a whole step, from what it did in its equal parts.

    Forces are means, so that force times step is the impulse; the gap of a contact that was loaded is the
    deepest that it had while it was. Places and velocities are means by normal force, and the frame is that
    of the part with the greatest one; what was not loaded is that of the first part. A foot that met
    another surface in some of the parts has left force there that is none of the row's.

    Components are means of those in the parts' own frames, which turn with a foot that rolls over an edge:
    the mean of forces inside their cones is inside the cone. What turning takes of their sum is left over.

    Parameters
    ----------
    readings
        Of the parts, in their order, with normals.

    Returns
    -------
    (reading, rest)
        The mean, and (p, 3) what the mean of all forces is beside the row's, world axes [N].

    Examples
    --------
    >>> one, up = np.ones((1, 3)), np.array([[0.0, 0.0, 1.0]])
    >>> pushes = (0.0, 1e-3), (4.0, -1e-4)
    >>> parts = [ContactReading(f * up, np.array([gap]), 0 * one, one, None, up) for f, gap in pushes]
    >>> found, rest = mean_reading(parts)
    >>> found.forces.tolist(), found.gaps.tolist(), rest.any()
    ([[0.0, 0.0, 2.0]], [-0.0001], np.False_)
    """
    count = len(readings)
    forces, places, velocities = (np.array([getattr(r, n) for r in readings]) for n in _WORDS)
    gaps, normals = np.array([r.gaps for r in readings]), np.array([r.normals for r in readings])
    frames = frames_on(normals)
    beside = [r.others for r in readings if r.others is not None]
    others = np.mean(beside, axis=0) if beside else None
    best, which = forces[..., 2].argmax(axis=0), np.arange(len(gaps[0]))
    same = np.einsum("tki,ki->tk", normals, normals[best, which]) >= SAME_FACE
    force = np.where(same[..., None], forces, 0.0).sum(axis=0) / count
    mean = np.einsum("tkij,tkj->ki", frames, forces) / count
    rest = mean - np.einsum("kij,kj->ki", frames_on(normals[best, which]), force)
    rest[np.abs(rest).max(axis=1) <= LEAST_FORCE] = 0.0
    gap, place, speed = gaps[0].copy(), places[0].copy(), velocities[0].copy()
    for k in np.flatnonzero(forces[best, which, 2] > 0.0).tolist():
        on = same[:, k] & (forces[:, k, 2] > 0.0)
        share = forces[on, k, 2] / forces[on, k, 2].sum()
        gap[k] = gaps[on, k].min()
        place[k], speed[k] = share @ places[on, k], share @ velocities[on, k]
    return ContactReading(force, gap, speed, place, others, normals[best, which]), rest
