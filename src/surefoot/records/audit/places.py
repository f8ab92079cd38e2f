"""Whether contact points are where their gaps, their velocities and their feet say.

On a plane whose normal is n, n . p - gap is the plane's height, of every contact and at any time: a gap that
is of another sign, point or scale shows, and so does a point that jumps along the normal. A point goes on as
its material does, and as it wanders over a round foot: its velocity changes by what the material's changes by
and what a rolling foot makes of that.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray
from surefoot.base.numerics.windows import sliding_sum
from surefoot.records.audit.ground import LEVEL, MEASURED, in_the_middle, on_ground
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.rows import Measured, Rows, over
from surefoot.records.audit.within_row import fall, way_to_touch, whirling
from surefoot.records.log import Log

ROLLS = 3.5
"""Change of a rolling solid ball's speed per change of its slip is 2/7 of it; its point's, at most this."""


def gap_place(rows: Rows) -> Measured:
    """Return how far contact points are from where their gaps put them: (T, p) [m]."""
    height, softness = rows.setting.ground, rows.setting.sinking
    value = np.zeros(rows.normal.shape)
    if height is not None:
        along = (rows.numbers("contact_positions") * height[..., :3]).sum(axis=2) - height[..., 3]
        # a point in the middle of what overlaps, or of a gap across which a margin pushes, is half of it off
        half = (rows.gaps < 0.0) | in_the_middle(rows.log, rows.gaps)
        middle = np.where(half, 0.5, 1.0) * rows.gaps
        value = np.minimum(np.abs(along - rows.gaps), np.abs(along - middle))
        plane = (np.abs(rows.numbers("normals") - height[..., :3]) < LEVEL).all(axis=2)
        plane &= on_ground(rows.log, rows.points)
        value = np.where(plane & ~too_far(rows), value, 0.0)
    open_way = rows.once(way_to_touch) if rows.setting.means else 0.0  # means of places, gaps of instants
    return over(value, rows.setting.limits.consistency.place + softness + open_way)


def jump(rows: Rows) -> Measured:
    """Return how far contact points jump from row to row, beyond what their velocities do: (T, p) [m]."""
    from scipy.ndimage import maximum_filter1d

    place, dt = rows.numbers("contact_positions"), rows.dt[:, None]
    bend = np.zeros(rows.normal.shape)
    bend[1:-1] = np.linalg.norm(place[2:] - 2.0 * place[1:-1] + place[:-2], axis=2)
    normals = rows.numbers("normals")
    # where a normal turns it touches another face
    turned = np.asarray((np.abs(np.diff(normals, axis=0)) > LEVEL).any(axis=2))
    bend[1:-1] = np.where(turned[1:] | turned[:-1], 0.0, bend[1:-1])
    change = np.linalg.norm(np.diff(rows.velocities, axis=0, append=rows.velocities[-1:]), axis=2)
    allowed = ROLLS * maximum_filter1d(change, 5, axis=0) * dt + fall(rows) * dt**2
    # a world may tell places in the middle of steps with contacts, and at the start of others
    touching = rows.over_robot(rows.loaded, np.logical_or)
    turns = np.zeros(touching.shape)
    turns[1:] = touching[1:] != touching[:-1]
    speed = maximum_filter1d(np.linalg.norm(rows.velocities, axis=2), 3, axis=0)
    allowed = allowed + np.where(sliding_sum(turns, 5) > 0.0, speed * dt, 0.0)
    limit = rows.setting.limits.consistency.jump + allowed
    return over(bend, np.where(whirling(rows, 2)[:, None], np.inf, limit))


def anew(rows: Rows) -> BoolArray:
    """Return the steps to the next row over which a recorded contact point becomes another: (T, p)."""
    out = np.zeros((rows.count, rows.points), dtype=bool)
    if rows.has("gaps"):
        far = too_far(rows)
        out |= far
        out[:-1] |= far[1:]
    if rows.log.facts.get("kind") != "recording" or "contact_positions" not in rows.log:
        return out
    place = rows.numbers("contact_positions")
    step = np.linalg.norm(np.diff(place, axis=0), axis=2)
    longest = np.maximum(np.vstack([step[:1], step[:-1]]), np.vstack([step[1:], step[-1:]]))
    out[:-1] |= step > rows.setting.limits.consistency.anew + longest
    wide = np.linalg.norm(np.diff(place, n=2, axis=0), axis=2) > rows.setting.limits.consistency.anew
    out[:-2] |= wide
    out[1:-1] |= wide
    return out


def too_far(rows: Rows) -> BoolArray:
    """Return in which rows (T, p) gaps of a recording are only known to be wider than it measures."""
    return np.asarray((rows.gaps > MEASURED) & (rows.log.facts.get("kind") == "recording"))


def no_ground(log: Log, setting: Setting) -> str:
    """Return why gaps cannot be held against contact points; empty where the ground is one plane."""
    return "" if setting.ground is not None else "the ground is not known to be one plane"


def no_feet(log: Log, setting: Setting) -> str:
    """Return why a jump of contact points cannot be judged; empty where contacts are feet that stay so."""
    if log.facts.get("kind") == "recording":
        return "what touches is another point of its geom whenever MuJoCo finds one: its shape is not known"
    return ""
