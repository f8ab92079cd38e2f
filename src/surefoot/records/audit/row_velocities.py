"""Whether the velocities of a row are those before or after its force has acted."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import frames_on
from surefoot.records.log import Log

ROWS = 1 << 16
"""Rows of a log that are looked at."""
MEANS = (
    "contact velocities are declared to be means while a row's force acts: what a touch gives back is known "
    "to half of a row's change of velocity, and judged by whole flights, too"
)


def velocities_after(log: Log, dt: float, clear: float) -> bool | None:
    """Return whether a row's contact velocities carry its gap to the next row's: those after its force.

    MuJoCo reports the velocities before the forces act, a time-stepping scheme those after. A gap that jumps
    where a foot passes an edge moves all sums alike: each of its terms is the jump, give or take one step.
    Where the mean of both carries gaps as well, as in an exact motion, the rows in which loads begin tell:
    the force of a touch is in the row over which the velocity changes. None for what is declared to be means.

    `clear` is how many times another misfit tells which is right [-].
    """
    if log.facts.get("velocities") == "mean":
        return None
    if not {"gaps", "contact_velocities"} <= set(log.arrays) or dt <= 0.0:
        return False
    gaps, up = (np.asarray(log[name][:ROWS]) for name in ("gaps", "contact_velocities"))
    normal = np.asarray(log["forces"][:ROWS])[..., 2] if "forces" in log else None
    return bool(velocities_after_each(gaps, up[..., 2], normal, dt, clear, 1)[0])


def velocities_after_each(
    gaps: FloatArray, up: FloatArray, normal: FloatArray | None, dt: float, clear: float, robots: int
) -> BoolArray:
    """Return for each of some robots side by side what `velocities_after` tells: (robots,).

    Parameters
    ----------
    gaps, up, normal
        (T, p) gaps [m], velocities along the normal [m/s] and normal forces [N], None where not known.
    dt, clear
        See there.
    robots
        Whose contacts lie next to one another, as many of each.
    """

    def total(values: FloatArray) -> FloatArray:
        clean = np.where(np.isfinite(values), values, 0.0)
        return np.asarray(clean.sum(axis=0).reshape(robots, -1).sum(axis=1))

    with np.errstate(invalid="ignore", over="ignore"):
        change, way = np.diff(gaps, axis=0), dt * up
        before, after, mean = (
            total(np.abs(change - w)) for w in (way[1:], way[:-1], 0.5 * (way[1:] + way[:-1]))
        )
        if normal is None:
            return after < before
        begins = np.zeros(normal.shape, dtype=bool)
        begins[1:-1] = (normal[1:-1] > 0.0) & (normal[:-2] <= 0.0)
        # how much velocities change after, and before, the rows in which loads begin [m/s]
        turns = np.abs(np.diff(up, axis=0))
        later, earlier = (total(np.where(at, turns, 0.0)) for at in (begins[:-1], begins[1:]))
    tells = clear * np.minimum(before, after) > mean
    tells &= np.maximum(later, earlier) > clear * np.minimum(later, earlier)
    return np.asarray(np.where(tells, earlier > later, after < before))


def forces_late(log: Log, dt: float, weight: float) -> bool:
    """Return whether a row's forces are those of the step that ended at its time, by momentum, else by com.

    Loggers that write after a step have state and forces so. The momentum's rate is not asked: it is judged.
    """
    if dt <= 0.0 or not {"forces", "normals"} <= set(log):
        return False
    forces, normals = (np.asarray(log[name][:ROWS]) for name in ("forces", "normals"))
    with np.errstate(invalid="ignore", over="ignore"):
        if "momentum" in log:
            change = np.diff(np.asarray(log["momentum"][:ROWS])[:, :3], axis=0)[1:] / dt
        elif "com" in log:
            change = np.diff(np.asarray(log["com"][:ROWS]), n=2, axis=0) * (weight / GRAVITY) / dt**2
        else:
            return False
        force = np.einsum("tpij,tpj->ti", frames_on(normals), forces)
        force += weight / GRAVITY * np.asarray(log.facts.get("gravity", (0.0, 0.0, -GRAVITY)))
        off = [np.abs(change - one) for one in (force[1:-1], force[2:])]
        now, late = (float(one[np.isfinite(one)].sum()) for one in off)
    return late < now
