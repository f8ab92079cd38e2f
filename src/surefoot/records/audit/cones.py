"""The cone that a world's friction has: round, an ellipsoid shared with moments, or MuJoCo's pyramid.

With torsional and rolling friction one ellipsoid bounds all (f_t / mu)² + sum (m_i / mu_i)² <= f_n²: what the
moments use is not left to brake a slide. A pyramid, |f_1| + |f_2| <= mu f_n along two edges, lies inside the
round cone; maximum dissipation puts the force on a corner, so that a slide at angle a to an edge is braked by
mu f_n cos a, at 45 degrees by 71 % of the cone's friction, and bent. A world is judged by its own cone.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records.audit.rows import Rows


def friction_needed(rows: Rows) -> FloatArray:
    """Return the friction that forces and moments need in a round cone, or its ellipsoid: (T, p)."""
    normal = np.maximum(rows.normal, rows.setting.threshold)
    moments = _moment_share(rows, None)
    if _turn(rows) is not None or not moments.any():  # pyramids lie inside the round cone
        return np.asarray(rows.tangential / normal)
    return np.hypot(rows.tangential / normal, rows.mu * moments)


def used(rows: Rows) -> FloatArray:
    """Return the friction that forces and moments use in the world's own cone: (T, p)."""
    normal, turn = np.maximum(rows.normal, rows.setting.threshold), _turn(rows)
    if turn is None:
        return friction_needed(rows)
    along = np.abs(_edge_components(rows.forces[..., 0], rows.forces[..., 1], turn)).sum(axis=0)
    return np.asarray(along / normal + rows.mu * _moment_share(rows, turn))


def grip(rows: Rows) -> FloatArray:
    """Return what friction gives against the present slip, over the normal force: (T, p)."""
    turn, left = _turn(rows), np.minimum(_moment_share(rows, _turn(rows)), 1.0)
    if turn is None:
        return np.asarray(rows.mu * np.sqrt(1.0 - left**2))
    v = rows.velocities[..., :2]
    speed = np.hypot(v[..., 0], v[..., 1])
    # At a corner, on the edge nearest to the slip: mu f_n times the slip's cosine to that edge.
    along = np.abs(_edge_components(v[..., 0], v[..., 1], turn)).max(axis=0) / np.maximum(speed, 1e-300)
    return np.asarray(rows.mu * (1.0 - left) * np.where(speed > 0.0, along, 1.0))


def _turn(rows: Rows) -> FloatArray | None:
    """Return the turn of the pyramids (T, p) [rad]; None for round cones."""
    return rows.numbers("pyramid_turn") if "pyramid_turn" in rows.log else None


def _edge_components(x: FloatArray, y: FloatArray, turn: FloatArray) -> FloatArray:
    """Return the (2, T, p) components of a vector along the edges of the pyramids."""
    c, s = np.cos(turn), np.sin(turn)
    return np.stack([c * x + s * y, c * y - s * x])


def _moment_share(rows: Rows, turn: FloatArray | None) -> FloatArray:
    """Return the share of the normal force that moments use of the cone: (T, p)."""
    if not {"contact_moments"} <= set(rows.log) or "moment_friction" not in rows.log.facts:
        return np.zeros(rows.normal.shape)
    friction = np.asarray(rows.log.facts["moment_friction"], dtype=np.float64)
    moments = rows.numbers("contact_moments")
    if turn is not None:
        moments = np.stack(
            [*_edge_components(moments[..., 0], moments[..., 1], turn), moments[..., 2]], axis=-1
        )
    used = np.where(friction > 0.0, np.abs(moments) / np.where(friction > 0.0, friction, 1.0), 0.0)
    size = np.linalg.norm(used, axis=-1) if turn is None else used.sum(axis=-1)
    return np.asarray(size / np.maximum(rows.normal, rows.setting.threshold))
