"""Small linear programs at an event: the least friction with which contacts give what they gave.

Forces of point contacts are sums of the edges of pyramids around their normals, so that whether they add up
to a wrench is a linear program (SciPy's HiGHS); the least friction is found by halving.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray

EDGES = 16
"""Edges of a pyramid: its friction is short of the cone's by 2 % at most."""
MOST_FRICTION, HALVINGS = 4.0, 9
"""Largest friction that is looked for, and how often that is halved: to 0.01."""
OPEN = 1e-6
"""Share of a wrench that a program may leave open."""


def least_friction(places: FloatArray, normals: FloatArray, about: FloatArray, wrench: FloatArray) -> float:
    """Return the least friction with which point contacts give a wrench; infinite if none does.

    Parameters
    ----------
    places, normals
        (k, 3) of the contacts [m, -].
    about
        (3,) point that moments are about [m].
    wrench
        (6,) force and moment to be given [N, N m].
    """
    if not len(places) or not _gives(places, normals, about, wrench, MOST_FRICTION):
        return np.inf
    low, high = 0.0, MOST_FRICTION
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _gives(places, normals, about, wrench, middle) else (middle, high)
    return high


def _gives(places: FloatArray, normals: FloatArray, about: FloatArray, wrench: FloatArray, mu: float) -> bool:
    """Return whether contacts of a friction can give a wrench, but for a small rest of it."""
    from scipy.optimize import linprog  # takes 0.2 s to import: only where something has failed

    from surefoot.mechanics import frames_on

    turn = np.linspace(0.0, 2.0 * np.pi, EDGES, endpoint=False)
    edges = np.stack([mu * np.cos(turn), mu * np.sin(turn), np.ones(EDGES)], axis=1)
    forces = np.einsum("pij,ej->pei", frames_on(normals), edges)
    arms = np.broadcast_to((places - about)[:, None], forces.shape)
    length = max(float(np.linalg.norm(places - about, axis=1).max()), 1e-3)
    rows = np.concatenate([forces, np.cross(arms, forces) / length], axis=-1).reshape(-1, 6).T
    size = max(float(np.linalg.norm(wrench[:3])), 1e-9)
    goal = np.concatenate([wrench[:3], wrench[3:] / length]) / size
    if not np.isfinite(goal).all() or not np.isfinite(rows).all():
        return False
    slack = np.hstack([np.eye(6), -np.eye(6)])
    cost = np.concatenate([np.zeros(rows.shape[1]), np.ones(12)])
    found = linprog(cost, A_eq=np.hstack([rows, slack]), b_eq=goal, method="highs")
    return bool(found.status == 0 and found.fun is not None and found.fun <= OPEN)
