"""Forces of a robot's feet as shapes: cones, arrows, and which of them are outside; for runs and for logs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.drawing import Shape
from surefoot.app.lab.geometry import SIDES, cone_surface, fan
from surefoot.app.lab.html_text import table
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.contact import FrictionCone

WEIGHT_LENGTH = 0.5
"""Length of the arrow of a force of m g [m]."""
CONE_HEIGHT = 0.1
"""Height of the cones that are drawn [m]."""
BROKEN = 1e-3
"""A force is drawn as outside where it exceeds its cone by this share."""


def contact_shapes(
    names: Sequence[str],
    places: FloatArray,
    frames: FloatArray,
    forces: FloatArray,
    mu: FloatArray,
    weight: float,
) -> dict[str, Shape]:
    """Return cones and arrows of the loaded contacts, those outside their cones in another colour.

    Each contact has its own arrow, `/forces/` and its name, which travels with its cone.

    Parameters
    ----------
    names
        Of the n contacts.
    places, frames
        (n, 3) [m] and (n, 3, 3) rotations, their third columns the normals.
    forces
        (n, 3) in those frames [N].
    mu
        (n,) friction; infinite where it is not known: no cone then.
    weight
        m g [N].
    """
    out: dict[str, Shape] = {}
    finite = np.isfinite(places).all(axis=1) & np.isfinite(forces).all(axis=1)
    good: BoolArray = np.asarray(finite & (np.abs(forces) > 0.0).any(axis=1))
    vectors = np.einsum("nij,nj->ni", frames, forces) * (WEIGHT_LENGTH / weight)
    along = np.hypot(forces[:, 0], forces[:, 1])
    known = np.isfinite(mu)
    outside = known & (along > np.where(known, mu, 0.0) * forces[:, 2] * (1.0 + BROKEN))
    for k, name in enumerate(names):
        if not good[k]:
            continue
        out[f"/forces/{name}"] = draw.arrow_at(places[k], vectors[k], draw.BAD if outside[k] else draw.FORCE)
        if known[k]:
            x, y, z = places[k].tolist()
            surface = _surface(float(mu[k]), frames[k].tobytes())
            colour = draw.BAD if outside[k] else draw.CONE
            out[f"/cones/{name}"] = draw.Mesh(surface, fan(SIDES), colour, 0.35, (x, y, z))
    return out


@lru_cache(maxsize=256)
def _surface(mu: float, frame: bytes) -> FloatArray:
    """Return a cone's surface, the very same array for the same cone: it is not sent again."""
    return cone_surface(mu, CONE_HEIGHT, np.frombuffer(frame).reshape(3, 3))


def force_rows(names: Sequence[str], forces: FloatArray, mu: FloatArray) -> str:
    """Return a table of (n, 3) forces in contact frames [N] as HTML."""
    rows: list[tuple[str, ...]] = []
    for name, force, friction in zip(names, forces, mu, strict=True):
        along, used = math.hypot(force[0], force[1]), "-"
        if force[2] > 0.0 and math.isfinite(friction):
            used = f"{100.0 * float(FrictionCone(float(friction)).use(force)):.0f}"
        rows.append((name, f"{force[2]:.1f}", f"{along:.1f}", used))
    return table(("foot", "normal [N]", "along [N]", "friction used [%]"), rows)
