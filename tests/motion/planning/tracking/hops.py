"""References made by hand: a body on ballistic paths, its feet where the legs reach them, no optimiser."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics.robot import Robot, place
from surefoot.mechanics.robot.legs import Legs
from surefoot.motion.planning.tracking import Reference
from surefoot.motion.walking.swing import minimum_jerk

STEP = 0.01


def _base_path(
    height: float, crouch: float, extend: float, climb: float, speed: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return x, z, (k, 2) and whether it flies: crouch, push with constant force, flight, brake, rise."""
    low, high = height - crouch, height + extend
    push = 2.0 * (high - low) / climb
    flight = 2.0 * climb / GRAVITY
    rows, on, x = [], [], 0.0
    for t in np.arange(0.0, 0.3, STEP):
        rows.append((0.0, height - crouch * minimum_jerk(t / 0.3)[0]))
        on.append(True)
    for t in np.arange(0.0, push, STEP):
        rows.append((0.5 * speed / push * t * t, low + 0.5 * climb / push * t * t))
        on.append(True)
    x = 0.5 * speed * push
    for t in np.arange(0.0, flight, STEP):
        rows.append((x + speed * t, high + climb * t - 0.5 * GRAVITY * t * t))
        on.append(False)
    x += speed * flight
    for t in np.arange(0.0, push, STEP):
        left = push - t
        rows.append((x + 0.5 * speed * (push - left * left / push), low + 0.5 * climb / push * left * left))
        on.append(True)
    x += 0.5 * speed * push
    for t in np.arange(0.0, 0.4, STEP):
        rows.append((x, low + (height - low) * minimum_jerk(t / 0.3 if t < 0.3 else 1.0)[0]))
        on.append(True)
    path = np.array(rows)
    return path[:, 0], path[:, 1], np.array(on)


def hop(
    robot: Robot, climb: float = 1.6, speed: float = 0.0, crouch: float = 0.09, extend: float = 0.03
) -> Reference:
    """Return a hop on all feet that leaves the ground with `climb` up and `speed` ahead [m/s]."""
    start = place(robot)
    legs = Legs(robot)
    x, z, on = _base_path(float(start[2]), crouch, extend, climb, speed)
    rest = robot.foot_positions(start)
    flying = np.flatnonzero(~on)
    first, last = int(flying[0]), int(flying[-1])
    share = np.clip((np.arange(len(x)) - first) / (last - first), 0.0, 1.0)
    q = np.tile(start, (len(x), 1))
    joints = start[7:]
    for k in range(len(x)):
        q[k, 0], q[k, 2] = start[0] + x[k], z[k]
        feet = rest.copy()
        if on[k]:
            feet[:, 0] += x[-1] * (k > last)
        else:  # from where they left to where they land, seen from the body
            feet[:, 0] += x[k] + (1.0 - share[k]) * (-x[first]) + share[k] * (x[-1] - x[last])
            feet[:, 2] += z[k] - z[first] + 0.06 * np.sin(np.pi * share[k])
        joints = legs.reach(feet - q[k, :3], joints)
        q[k, 7:] = joints
    time = STEP * np.arange(len(x))
    v = np.zeros((len(x), robot.model.nv))
    v[:-1, 6:] = np.diff(q[:, 7:], axis=0) / STEP
    v[:, 0], v[:, 2] = np.gradient(x, STEP), np.gradient(z, STEP)
    acceleration = np.zeros((len(x) - 1, 3))
    acceleration[1:, 0], acceleration[1:, 2] = np.diff(x, 2) / STEP**2, np.diff(z, 2) / STEP**2
    forces = np.zeros((len(x) - 1, 4, 3))
    forces[:] = 0.25 * robot.mass * (acceleration + np.array([0.0, 0.0, GRAVITY]))[:, None, :]
    stance = np.repeat(on[:-1, None], 4, axis=1)
    forces[~stance] = 0.0
    return Reference(robot, time, q, v, forces, stance)
