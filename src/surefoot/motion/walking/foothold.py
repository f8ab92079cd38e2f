"""Where to put a foot down: Raibert's rule on the terrain, moved off edges and steep ground.

The nominal place lies below the hip at the middle of the coming stance, plus a share of the speed error
that a pendulum of the body's height would need to catch itself [1]_. On terrain that is not a plane,
candidates around it are weighed by their distance, by the height differences within the foot's reach
(edges) and by the part of the friction cone that the ground's tilt uses.

Between the edges of steps a foot keeps a margin from the edges on both sides, and more from one behind it
that it came down over: a shin leans back over it.

References
----------
.. [1] M. Raibert, "Legged robots that balance", MIT Press, 1986.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Terrain
from surefoot.motion.walking.feet_settings import FOOTHOLDS

LOOK, FINE = 0.3, 0.005
"""How far along the way edges are looked for, and in what steps [m]."""
CATCH_REACH, CATCH_ASIDE = FOOTHOLDS.catch_reach, FOOTHOLDS.catch_aside
"""Settings, as compiled code folds them."""
NEAR = np.arange(-LOOK, LOOK + 0.5 * FINE, FINE)


@kernel
def step_place(
    com: FloatArray, com_velocity: FloatArray, arm: FloatArray, yaw: float, velocity: FloatArray, left: float,
    height: float, stance_time: float,
) -> FloatArray:  # fmt: skip
    """Return the nominal (2,) place of a foot of a turning body at touchdown, world axes [m].

    Raibert's rule about where the hip will be, plus half of what the body turns over the foot in the stance.
    A speed error moves the place by its capture point's offset: a pendulum would come to rest over it.

    Parameters
    ----------
    com, com_velocity
        (3,) centre of mass and its velocity now [m], [m/s].
    arm
        (>= 2,) from the centre of mass to where the foot belongs, heading axes [m].
    yaw
        Wanted heading now [rad].
    velocity
        (3,) wanted: forward, left [m/s], yaw rate [rad/s].
    left
        Time to touchdown [s].
    height, stance_time
        Of the centre of mass above the ground [m], and length of the coming stance [s].

    Examples
    --------
    >>> speed = np.array([0.5, 0.0, 0.0])
    >>> step_place(np.zeros(3), speed, np.zeros(2), 0.0, speed, 0.0, 0.3, 0.2)
    array([0.05, 0.  ])
    """
    # Where the hip will be at touchdown, and the wanted velocity then: both turn with the body.
    turn, pendulum = velocity[2], math.sqrt(height / GRAVITY)
    c, s = math.cos(yaw + turn * left), math.sin(yaw + turn * left)
    wanted, hip, out = np.empty(2), np.empty(2), np.empty(2)
    wanted[0], wanted[1] = c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]
    x, y = c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]
    # Raibert: T/2 v puts the foot below the hip at the middle of stance; sqrt(h/g) (v - v_wanted) is the
    # offset of the capture point, at which a pendulum of this height takes up the difference.
    lead = 0.5 * stance_time * turn
    hip[0], hip[1] = com[0] + left * wanted[0] + x, com[1] + left * wanted[1] + y
    # A point mass would need all of h/g; the half is measured, on Go2 at 0.8 m/s and 1.2 rad/s: it drifts to
    # its left by -6, -0.5 and 6 mm/s with none, half and all of it (means of three seeds of 8 s).
    swerve = 0.5 * pendulum * pendulum * turn  # for the centripetal acceleration
    for i in range(2):
        across = -wanted[1] if i == 0 else wanted[0]
        out[i] = hip[i] + 0.5 * stance_time * wanted[i] + pendulum * (com_velocity[i] - wanted[i])
        out[i] -= swerve * across
    out[0] -= lead * y
    out[1] += lead * x
    return out


@kernel
def catching_place(
    com: FloatArray, com_velocity: FloatArray, arm: FloatArray, yaw: float, velocity: FloatArray, left: float,
    height: float, stance_time: float,
) -> FloatArray:  # fmt: skip
    """Return the (2,) place of a foot that catches a pushed body at touchdown, world axes [m].

    Raibert's rule about where the hip will be if the body goes on as it does, as far as the leg reaches, and
    on the foot's own side of the body: there is no way past the other leg.

    Parameters
    ----------
    com, com_velocity, arm, yaw, velocity, left, height, stance_time
        As for `step_place`; the velocity is the one that the body should come back to. Where that goes the
        other way, the foot brakes the body to rest.

    Examples
    --------
    >>> fast = np.array([0.0, 9.0, 0.0])
    >>> catching_place(np.zeros(3), fast, np.array([0.2, 0.1]), 0.0, np.zeros(3), 0.0, 0.3, 0.1)
    array([0.2 , 0.34])
    """
    # In heading axes: reach and the side of the other leg are the body's.
    c, s = math.cos(yaw), math.sin(yaw)
    out, pendulum = np.empty(2), math.sqrt(height / GRAVITY)
    x, y = c * com_velocity[0] + s * com_velocity[1], c * com_velocity[1] - s * com_velocity[0]
    # turned round by this step it would stand far ahead of a foot that lands when others have slowed it
    ahead = 0.5 * stance_time * x + pendulum * (x - min(max(velocity[0], min(x, 0.0)), max(x, 0.0)))
    aside = 0.5 * stance_time * y + pendulum * (y - min(max(velocity[1], min(y, 0.0)), max(y, 0.0)))
    # The leg bounds the way as a whole, so that the foot stays in the direction in which the body falls.
    reach, side = CATCH_REACH * height / max(math.hypot(ahead, aside), 1e-9), math.copysign(1.0, arm[1])
    ahead, aside = arm[0] + min(reach, 1.0) * ahead, arm[1] + min(reach, 1.0) * aside
    ahead, aside = ahead + left * x, side * max(side * aside, CATCH_ASIDE * abs(arm[1])) + left * y
    out[0], out[1] = com[0] + c * ahead - s * aside, com[1] + s * ahead + c * aside
    return out


def step_windows(
    terrain: Terrain, place: FloatArray, along: FloatArray, margin: float, ways: FloatArray = NEAR
) -> tuple[FloatArray, FloatArray] | None:
    """Return from where to where a foot may be moved along its way, for each tread near it.

    Parameters
    ----------
    terrain
        As believed.
    place
        (2,) where the foot would stand [m].
    along
        (2,) direction of its way, a unit vector.
    margin
        Distance to keep from edges [m].
    ways
        (m,) how far along its way to look, even steps [m].

    Returns
    -------
    (n,), (n,) least and largest move of each tread in turn [m]; None where there is no edge. Both are
    the same where a tread is too short: as far from the edge behind as the margin to the next allows,
    or the middle.
    """
    heights = terrain.height(place + ways[:, None] * along)
    jumps = heights[2:] - heights[:-2]
    at = np.flatnonzero(np.abs(jumps) > max(2.0 * terrain.noise, FOOTHOLDS.low_step))
    if not len(at):
        return None
    first = np.concatenate([[True], np.diff(at) > 1])  # an edge is seen by two or more differences
    begin = np.flatnonzero(first)
    last = np.append(begin[1:], len(at)) - 1
    edges = 0.5 * (ways[at[begin] + 1] + ways[at[last] + 1])
    shin = max(FOOTHOLDS.shin + (FOOTHOLDS.unsure if terrain.learns else 0.0), margin)
    behind = np.where(jumps[at[begin]] < 0.0, shin, margin)
    low = np.concatenate([[-math.inf], edges + behind])
    high = np.concatenate([edges - margin, [math.inf]])
    middles = np.concatenate([[-math.inf], 0.5 * (edges[:-1] + edges[1:]), [math.inf]])
    short = low > high
    low[short] = high[short] = np.maximum(high, middles)[short]
    return low, high


def nearest_shift(windows: tuple[FloatArray, FloatArray], ahead: FloatArray) -> FloatArray:
    """Return the least moves into any window, of feet that are `ahead` of their place: (k,) for (k,) [m].

    Examples
    --------
    >>> nearest_shift((np.array([-np.inf, 0.1]), np.array([-0.04, 0.3])), np.array([-0.1, 0.0, 0.05, 0.2]))
    array([ 0.  , -0.04,  0.05,  0.  ])
    """
    moves = np.clip(ahead, windows[0][:, None], windows[1][:, None]) - ahead
    best = np.abs(moves).argmin(axis=0)
    return np.asarray(moves[best, np.arange(len(ahead))])


def choose_foothold(
    terrain: Terrain,
    place: FloatArray,
    reach: float,
    margin: float,
    way: FloatArray | None = None,
    before: FloatArray | None = None,
    more: float = math.inf,
) -> FloatArray:
    """Return the (2,) place [m] to step on near the nominal one, world axes; the nominal one on a plane.

    Parameters
    ----------
    terrain
        As believed.
    place
        (2,) the nominal one [m].
    reach
        Largest distance from it, along each axis, where the ground is rough [m].
    margin
        Distance to edges that is wanted [m].
    way
        (2,) of the foot [m]: on steps across it the foot is moved along it, between the edges.
    before
        (2,) where the foot was to stand before [m]: the tread there is kept where it is near enough, and
        moves the foot by no `more` than the nearest [m].
    """
    if terrain.planar:
        return place
    length = 0.0 if way is None else math.hypot(float(way[0]), float(way[1]))
    if way is not None and length > 1e-6:
        windows = step_windows(terrain, place, way / length, margin)
        shift = math.inf if windows is None else float(nearest_shift(windows, np.zeros(1))[0])
        if windows is not None and before is not None:
            # Hysteresis: the tread chosen before is kept while it costs little more, or a foot between two
            # treads would be aimed at one and the other in turn.
            last = float((before - place) @ way) / length
            tread = int(np.abs(np.clip(last, *windows) - last).argmin())
            kept = float(np.clip(0.0, windows[0][tread], windows[1][tread]))
            shift = kept if abs(kept) <= min(FOOTHOLDS.farthest, abs(shift) + more) else shift
        if abs(shift) <= FOOTHOLDS.farthest:
            return np.asarray(place + shift * (way / length))
    return _most_level(terrain, place, reach, margin)


def _most_level(terrain: Terrain, place: FloatArray, reach: float, margin: float) -> FloatArray:
    """Return the best (2,) place about one, by the ground around each [m]."""
    steps = np.linspace(-reach, reach, 9)
    grid = np.stack(np.meshgrid(steps, steps[::2], indexing="ij"), axis=-1).reshape(-1, 2)
    candidates = place + grid
    angles = np.arange(8) * (0.25 * math.pi)
    ring = margin * np.column_stack([np.cos(angles), np.sin(angles)])
    middle = terrain.height(candidates)
    around = terrain.height(candidates[:, None, :] + ring)
    # Edges within the margin by the spread of heights about a candidate, tilt by the largest slope to it.
    rise = np.ptp(np.concatenate([around, middle[:, None]], axis=1), axis=1)
    lean = np.abs(around - middle[:, None]).max(axis=1)
    if terrain.noise > 0.0:  # what may be noise is no edge
        rise, lean = np.maximum(rise - terrain.noise, 0.0), np.maximum(lean - terrain.noise, 0.0)
    cost = np.linalg.norm(grid, axis=1) + FOOTHOLDS.edge_weight * rise + FOOTHOLDS.tilt_weight * lean / margin
    return np.asarray(candidates[int(np.argmin(cost))])
