"""Flat feet whose whole wrench is in the log: what their moments take of the pressure and the friction.

A contact with a force and a moment about its own point, on a sole whose corners the log tells, can carry
what the friction cones of those corners add up to (`surefoot.Sole`). A wrench outside of it presses beyond an
edge, needs more friction than there is, or yaws more than the pressure allows, though its force alone may
look lawful.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.contact import Sole, outward
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.log import Log


def has_soles(log: Log) -> bool:
    """Return whether a log tells the soles of its contacts."""
    return "sole_corners" in log.facts


def sole_outlines(log: Log) -> dict[int, FloatArray]:
    """Return the corners (k, 2) of each contact that is a sole, in its contact frame [m].

    Raises
    ------
    ProblemError
        Where the facts ``sole_corners`` and ``sole_contact`` do not fit each other or the contacts.
    """
    corners = np.asarray(log.fact("sole_corners"), dtype=np.float64)
    if "sole_contact" not in log.facts:
        raise ProblemError("the fact sole_corners needs sole_contact: the contact point of each corner")
    of = np.asarray(log.fact("sole_contact"))
    points = log["forces"].shape[1] if "forces" in log else 0
    if len(of) != len(corners) or not np.isin(of, np.arange(points)).all():
        raise ProblemError(
            f"the fact sole_contact must give one of {points} contact points for each of {len(corners)} "
            f"corners, got {shown(of)}"
        )
    return {int(k): corners[of == k] for k in np.unique(of)}


def soles(rows: Rows) -> Measured:
    """Return the normal force that each sole lacks for its wrench, pressing at its centre: (T, p) [N]."""
    limits = rows.setting.limits.laws
    value = np.zeros(rows.normal.shape)
    for k, sole in _soles(rows).items():
        friction = _friction(rows)[:, k]
        for mu in np.unique(friction):
            on = friction == mu
            value[on, k] = -sole.with_friction(float(mu)).margin(_wrenches(rows)[on, k])
    return over(value, limits.pull * rows.setting.weight)


def worst_sole(rows: Rows, contact: int) -> tuple[float, str]:
    """Return the most normal force that a contact's sole lacks in the core of rows [N], and what binds."""
    sole = _soles(rows).get(contact)
    if sole is None:
        return 0.0, ""
    lacks = soles(rows)[0][rows.core, contact]
    k = int(np.argmax(lacks))
    wrench = _wrenches(rows)[rows.core][k, contact]
    mu = float(_friction(rows)[rows.core][k, contact])
    return float(lacks[k]), what_binds(sole.with_friction(mu), wrench)


def _soles(rows: Rows) -> dict[int, Sole]:
    return {k: Sole.of_corners(corners) for k, corners in sole_outlines(rows.log).items()}


def _wrenches(rows: Rows) -> FloatArray:
    """Return the contacts' forces and moments: (T, p, 6) contact frames [N, N m]."""
    return np.concatenate([rows.forces, rows.numbers("contact_moments")], axis=2)


def _friction(rows: Rows) -> FloatArray:
    """Return the friction that a sole may use, with the noise that `friction` allows: (T, p)."""
    limits = rows.setting.limits.laws
    own = np.broadcast_to(rows.mu, rows.normal.shape)
    return np.asarray(limits.cone * np.maximum(own, limits.least_friction))


def what_binds(sole: Sole, wrench: FloatArray) -> str:
    """Say which limit of a sole a wrench (6,) [N, N m] outside of it meets, and where it presses."""
    force, moment = wrench[2], wrench[3:]
    if force <= 0.0:
        return "has no normal force"
    pressed = np.array([-moment[1], moment[0]]) / force
    beyond = np.sum(outward(sole.corners) * (pressed - sole.corners), axis=1)
    edge = int(np.argmax(beyond))
    if beyond[edge] > 0.0:
        return f"presses {1e3 * beyond[edge]:.3g} mm beyond its {sole.edge_names[edge]}"
    binds = str(sole.use(wrench).binds)
    doing = {"friction": "slides", "edge": f"tips over its {sole.edge_names[edge]}", "yaw": "turns"}[binds]
    return f"{doing}: it needs {float(sole.use(wrench).total):.3g} times its normal force"
