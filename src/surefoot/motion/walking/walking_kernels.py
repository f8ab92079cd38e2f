"""Compiled pieces of the walking controller: the motion it follows, the reference ahead, feet in the air.

All vectors are in world axes, in m, m/s, rad, rad/s; heights along z.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.kernels import kernel
from surefoot.base.numerics.rotations import log_between
from surefoot.base.spatial import GRAVITY

# rows of the motion that is followed: the body when the plan was made, and the plan's accelerations
COM, VELOCITY, SPIN, ACCELERATION, TURNING = 0, 1, 2, 3, 4


@kernel
def follow(
    motion: FloatArray, rotation: FloatArray, t: float, com: FloatArray, velocity: FloatArray,
    now_rotation: FloatArray, spin: FloatArray, stiffness: float, damping: float,
) -> FloatArray:  # fmt: skip
    """Return the (2, 3) accelerations of centre of mass and of turning that keep a body on its motion.

    Parameters
    ----------
    motion
        (5, 3) rows centre of mass, its velocity and the angular velocity at the start; acceleration of the
        centre of mass and angular acceleration from there on [m/s², rad/s²].
    rotation, now_rotation
        (3, 3) of the body at the start, and now.
    t
        Time since the start [s].
    com, velocity, spin
        (3,) centre of mass, its velocity and the angular velocity now.
    stiffness, damping
        Of the feedback [1/s²], [1/s].
    """
    # Feed-forward and PD about a motion of constant acceleration, linear and angular. Turns are compared as
    # rotation vectors from the plan's start, which add as vectors for the small turn of a plan's age.
    out, turned = np.empty((2, 3)), np.zeros(3)
    if t > 0.0:
        log_between(now_rotation, rotation, turned)
    half = 0.5 * t * t
    for i in range(3):
        a, b = motion[ACCELERATION, i], motion[TURNING, i]
        miss = motion[COM, i] + t * motion[VELOCITY, i] + half * a - com[i]
        lag = motion[VELOCITY, i] + t * a - velocity[i]
        out[0, i] = a + stiffness * miss + damping * lag
        miss = t * motion[SPIN, i] + half * b - turned[i]
        out[1, i] = b + stiffness * miss + damping * (motion[SPIN, i] + t * b - spin[i])
    return out


@kernel
def body_rise(slope: FloatArray, yaw: float, height: float, dip: float, lowered: float) -> float:
    """Return the wanted height of a body over the ground along the vertical.

    Downhill and at the start it is `height` along the ground's normal. Feet stand below the body along
    the vertical and not along the normal: uphill they trail, which would stretch the knees, so there the
    body comes down to `height` times the slope's squared cosine along the normal; across the slope, times
    the cosine. Down steps a foot may stand half a step below their plane: see `dip`.

    Parameters
    ----------
    slope, yaw
        (2,) rise of the ground along world x and y; the body's heading.
    height, dip, lowered
        See `BodyPlan`.
    """
    # With s the steepness, 1 + s² is one over the slope's squared cosine: the height along the vertical is h
    # times its power ½ (h along the normal; downhill), 0 (across), or -½ (uphill).
    steepness = math.hypot(slope[0], slope[1])
    if steepness < 1e-9:
        return height
    climb: float = slope[0] * math.cos(yaw) + slope[1] * math.sin(yaw)
    sink = dip * min(max(-climb, 0.0), 0.4) * lowered
    power = 0.5 - 0.5 * lowered * (1.0 + climb / steepness)
    return height * (1.0 - sink) * math.exp(power * math.log1p(steepness * steepness))


@kernel
def advance_body(
    position: FloatArray, velocity: FloatArray, slope: FloatArray, command: FloatArray, com: FloatArray,
    dt: float, height: float, yaw: float, ground: float, lowered: float, acceleration: float, dip: float,
    lead: float, lowering: float,
) -> tuple[float, float, float]:  # fmt: skip
    """Move the wanted pose of a body by one step; return its heading, ground and `lowered`.

    Parameters
    ----------
    position, velocity
        (3,) wanted centre of mass; (3,) wanted forward, left and turn rate: both moved.
    slope
        (2,) rise of the ground along world x and y.
    command, com
        (3,) wanted velocity in the end; (3,) centre of mass.
    dt, height
        Step [s]; of the body.
    yaw, ground, lowered, acceleration, dip
        See `BodyPlan`.
    lead, lowering
        How far the wanted place may be ahead, over the larger of sqrt(g h) and the wanted speed [s]; time
        constant of `lowered` [s].
    """
    limit = acceleration * dt
    for k in range(3):
        most = limit if k < 2 else limit / height
        velocity[k] += min(max(command[k] - velocity[k], -most), most)
    yaw += velocity[2] * dt
    c, s = math.cos(yaw), math.sin(yaw)
    vx, vy = c * velocity[0] - s * velocity[1], s * velocity[0] + c * velocity[1]
    position[0] += vx * dt
    position[1] += vy * dt
    # The place is integrated from the velocity: bounded about the body, or one that is held up would be
    # pulled ever harder and leap when it comes free.
    reach = lead * max(math.sqrt(GRAVITY * height), math.hypot(vx, vy))
    x, y = position[0] - com[0], position[1] - com[1]
    far = math.hypot(x, y)
    if far > reach:
        position[0], position[1] = com[0] + x * reach / far, com[1] + y * reach / far
    ground += (slope[0] * vx + slope[1] * vy) * dt
    lowered += (1.0 - lowered) * dt / lowering
    position[2] = ground + body_rise(slope, yaw, height, dip, lowered)
    return yaw, ground, lowered


@kernel
def cruise(
    position: FloatArray, yaw: float, velocity: FloatArray, slope: FloatArray, times: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return headings (k,), places (k, 3) and velocities (k, 3) of a body that moves and turns steadily.

    Parameters
    ----------
    position, yaw
        (3,) of the centre of mass now, and its heading.
    velocity
        (3,) forward, left and turn rate.
    slope
        (2,) rise of the ground along world x and y.
    times
        (k,) from now [s].
    """
    count = times.size
    headings, places, flow = np.empty(count), np.empty((count, 3)), np.empty((count, 3))
    vx, vy, turn = velocity[0], velocity[1], velocity[2]
    for k in range(count):
        t = times[k]
        heading, middle = yaw + turn * t, yaw + 0.5 * turn * t
        headings[k] = heading
        c, s = math.cos(heading), math.sin(heading)
        flow[k, 0], flow[k, 1] = c * vx - s * vy, s * vx + c * vy
        flow[k, 2] = flow[k, 0] * slope[0] + flow[k, 1] * slope[1]
        # The chord's heading is exact; its length is taken for that of the arc, v t for 2 v / ω sin(ω t / 2).
        c, s = math.cos(middle), math.sin(middle)  # the chord of the arc
        x, y = (c * vx - s * vy) * t, (s * vx + c * vy) * t
        places[k, 0], places[k, 1] = position[0] + x, position[1] + y
        places[k, 2] = position[2] + x * slope[0] + y * slope[1]
    return headings, places, flow


@kernel
def slope_frames(yaw: FloatArray, slope: FloatArray) -> FloatArray:
    """Return (k, 3, 3) rotations with z along a plane's normal and x along (k,) headings in the plane.

    `slope` (2,) is the plane's rise along world x and y.
    """
    out = np.empty((yaw.size, 3, 3))
    scale = 1.0 / math.sqrt(1.0 + slope[0] * slope[0] + slope[1] * slope[1])
    nx, ny, nz = -slope[0] * scale, -slope[1] * scale, scale
    for k in range(yaw.size):
        x, y = math.cos(yaw[k]), math.sin(yaw[k])
        along = x * nx + y * ny
        fx, fy, fz = x - along * nx, y - along * ny, -along * nz
        length = 1.0 / math.sqrt(fx * fx + fy * fy + fz * fz)
        fx, fy, fz = fx * length, fy * length, fz * length
        R = out[k]
        R[0, 0], R[1, 0], R[2, 0] = fx, fy, fz
        R[0, 1], R[1, 1], R[2, 1] = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
        R[0, 2], R[1, 2], R[2, 2] = nx, ny, nz
    return out


@kernel
def plane_through(places: FloatArray, about: FloatArray, damping: float) -> tuple[float, float, float]:
    """Return height at `about` (2,) and slopes along x and y of the plane nearest to (n, 3) places.

    `damping` [m²] pulls the slopes to zero where the places do not tell them. Centred on the places' mean,
    the normal equations of the slopes are two by two.
    """
    n = len(places)
    mx = my = mz = 0.0
    for k in range(n):
        mx, my, mz = mx + places[k, 0] / n, my + places[k, 1] / n, mz + places[k, 2] / n
    bx, by = mx - about[0], my - about[1]
    # the damping holds the slopes alone, so that eliminating the height leaves the sums about the mean
    xx, xy, yy, xz, yz = damping, 0.0, damping, 0.0, 0.0
    for k in range(n):
        x, y, z = places[k, 0] - mx, places[k, 1] - my, places[k, 2] - mz
        xx, xy, yy = xx + x * x, xy + x * y, yy + y * y
        xz, yz = xz + x * z, yz + y * z
    determinant = xx * yy - xy * xy
    along_x, along_y = (yy * xz - xy * yz) / determinant, (xx * yz - xy * xz) / determinant
    return mz - bx * along_x - by * along_y, along_x, along_y


@kernel
def stance_places(
    contacts: BoolArray, stance: BoolArray, stands: FloatArray, target: FloatArray, frames: FloatArray,
    radii: FloatArray, com: FloatArray, arms: FloatArray, half_stance: int, ground: float, middle: FloatArray,
    slope: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return where each foot stands in each step of a horizon: (N, n, 3).

    A foot stays at its first place until it has flown: after that (for one in the air now: after its next
    stance) it belongs around the centre of mass at the middle of the stance to come, on the ground's plane.

    Parameters
    ----------
    contacts, stance
        (N, n) who carries in each step; (n,) who carries now.
    stands, target
        (n, 3) where feet that carry stand; (n, 3) where the centres of the others will land.
    frames, radii
        (n, 3, 3) of each foot's ground; (n,) of the feet's spheres.
    com, arms
        (N + 1, 3) expected centre of mass; (N + 1, n, 2) from there to where each foot belongs.
    half_stance
        Steps in half a stance.
    ground, middle, slope
        Height of the ground at the (>= 2,) middle, and its rise along world x and y (2,).
    """
    N, n = contacts.shape
    out = np.empty((N, n, 3))
    for k in range(n):
        x, y, z = stands[k, 0], stands[k, 1], stands[k, 2]
        if not stance[k]:
            x, y = target[k, 0] - radii[k] * frames[k, 0, 2], target[k, 1] - radii[k] * frames[k, 1, 2]
            z = target[k, 2] - radii[k] * frames[k, 2, 2]
        flown = False
        for i in range(N):
            if i > 0 and contacts[i, k] and not contacts[i - 1, k]:
                # Later stances follow the body: around the centre of mass halfway through, which the step
                # planner will choose likewise (Raibert's neutral point). The landing of a foot in the air is
                # chosen already.
                if stance[k] or flown:
                    m = min(i + half_stance, N)
                    x, y = com[m, 0] + arms[m, k, 0], com[m, 1] + arms[m, k, 1]
                    z = ground + (x - middle[0]) * slope[0] + (y - middle[1]) * slope[1]
                flown = True
            out[i, k, 0], out[i, k, 1], out[i, k, 2] = x, y, z
    return out


@kernel
def turned_arms(offsets: FloatArray, yaw: FloatArray) -> FloatArray:
    """Return the (k, n, 2) horizontal offsets (n, >= 2) of the feet, turned to (k,) headings."""
    out = np.empty((yaw.size, len(offsets), 2))
    for i in range(yaw.size):
        c, s = math.cos(yaw[i]), math.sin(yaw[i])
        for k in range(len(offsets)):
            x, y = offsets[k, 0], offsets[k, 1]
            out[i, k, 0], out[i, k, 1] = c * x - s * y, s * x + c * y
    return out
