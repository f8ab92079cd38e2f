"""The frames of a motion one by one: the forces of their contacts nearest to what they need; compiled.

Everything is divided by the weight m g, moments and torques by `arm` m g more. A joint beyond what its
motor can give adds a dimension: its torque less the limit, with a ray for all torques within.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.body_tree import BodyTree
from surefoot.records.certificates.bounds import left_over, proven_bound
from surefoot.records.certificates.cone_distance import nearest_sum
from surefoot.records.certificates.contact_cones import (
    MOST_ROWS,
    Contacts,
    PointArrays,
    Rules,
    Touch,
    gather,
    room_for,
)
from surefoot.records.certificates.torque_rows import MotorArrays, add_rotors, add_torque_row, take_forces
from surefoot.records.certificates.window_kernels import MotionArrays, Window, needed_wrench

ROUNDS = 8
"""Times that limits which bind are added, at most."""
NOTHING = 1e-7
"""Torque over m g and `arm` by which a limit may be exceeded without a row of its own [-]."""


class Answer(NamedTuple):
    """What is found of T frames; of frames without a window NaN.

    Attributes
    ----------
    share, bound
        (T,) what the forces that were found leave, and what no forces do better than [m g].
    wrench
        (T, 6) left of force and moment [N, N m].
    torques
        (T, j) multipliers of the torque limits in the certificate, as torques [N m, N].
    needed
        (T, 6) wrench [N, N m].
    contacts, sliding
        (T,) points that may touch, and of those that slide.
    slowest, lowest
        (T,) sliding speed of the slowest foot [m/s], distance of the lowest point to the ground in the window
        [m].
    """

    share: FloatArray
    bound: FloatArray
    wrench: FloatArray
    torques: FloatArray
    needed: FloatArray
    contacts: IntArray
    sliding: IntArray
    slowest: FloatArray
    lowest: FloatArray


class Model(NamedTuple):
    """A motion as arrays: bodies, points that touch, motors, which joints move which bodies, and rules.

    Attributes
    ----------
    moves
        (j, b) [-].
    weights
        (2 reach + 1,) of the frames of a window [-].
    """

    tree: BodyTree
    motion: MotionArrays
    points: PointArrays
    motors: MotorArrays
    moves: BoolArray
    window: Window
    weights: FloatArray
    rules: Rules


class Workspace(NamedTuple):
    """Memory of one frame, and what is found of it.

    Attributes
    ----------
    contacts
        Its cones.
    parts
        (b, 6) wrenches of bodies [N, N m].
    wrench, free
        (6,), (j,) needed wrench, and torques without contact forces [N, N m].
    b, r
        (6 + `MOST_ROWS`,) what is needed, and the certificate [m g].
    forces
        (c, 3) in the cones' axes [m g].
    work
        Of `nearest_sum`.
    joint
        (`MOST_ROWS`,) joints of the torque rows: 2 j + 1 for an upper limit, 2 j for a lower one.
    torques
        (j,) with those forces [over m g and `arm`].
    """

    contacts: Contacts
    parts: FloatArray
    wrench: FloatArray
    free: FloatArray
    b: FloatArray
    r: FloatArray
    forces: FloatArray
    work: FloatArray
    joint: IntArray
    torques: FloatArray


@kernel
def workspace(points: int, bodies: int, joints: int) -> Workspace:
    """Return memory for a robot."""
    contacts = room_for(points)
    top, rows = contacts.mu.shape[0], 6 + MOST_ROWS
    return Workspace(
        contacts,
        np.empty((bodies, 6)),
        np.empty(6),
        np.empty(joints),
        np.empty(rows),
        np.empty(rows),
        np.zeros((top, 3)),
        np.empty((top + 40, rows)),
        np.empty(MOST_ROWS, dtype=np.int64),
        np.empty(joints),
    )


@inline_kernel
def _find_excess(model: Model, k: int, unit: float, rows: int, work: Workspace) -> tuple[float, int]:
    """Return the sum of squares of torques beyond limits, and how many new rows were named for them."""
    excess, new = 0.0, 0
    for j in range(work.torques.shape[0]):
        over = work.torques[j] - model.motors.high[k, j] / unit
        under = model.motors.low[k, j] / unit - work.torques[j]
        most = max(over, under)
        if most <= 0.0:
            continue
        excess += most * most
        name = 2 * j + (1 if over > 0.0 else 0)
        known = False
        for i in range(rows + new):
            known = known or work.joint[i] == name
        if not known and most > NOTHING and rows + new < MOST_ROWS:
            work.joint[rows + new] = name
            new += 1
    return excess, new


@inline_kernel
def _add_rows(model: Model, k: int, unit: float, count: int, rows: int, new: int, work: Workspace) -> None:
    """Add the torque rows that were named after the first `rows` of them."""
    for row in range(rows, rows + new):
        j, upper = work.joint[row] // 2, work.joint[row] % 2 == 1
        limit = model.motors.high[k, j] if upper else model.motors.low[k, j]
        work.b[6 + row] = (work.free[j] - limit) / unit
        add_torque_row(
            model.tree, model.motion, k, model.points, work.contacts, count, model.moves, j, row,
            1.0 if upper else -1.0, model.rules.arm,
        )  # fmt: skip


@kernel
def solve_frame(model: Model, k: int, work: Workspace) -> tuple[int, int, float, float, Touch]:
    """Fill the (6,) wrench that frame k needs, forces nearest to it, the certificate and its torque rows.

    Returns
    -------
    Numbers of cones and of rows, what the forces leave and what none leave less than [m g], and what touches.
    """
    rules, motion = model.rules, model.motion
    weight = rules.mass * GRAVITY
    unit = weight * rules.arm
    needed_wrench(
        model.tree, motion, model.window, model.weights, k, rules.pace, work.parts, work.wrench, work.free
    )
    add_rotors(motion, model.motors, model.window, rules.pace, k, work.free)
    count, touch = gather(motion, model.points, model.window, rules, k, work.contacts)
    for i in range(6):
        work.b[i] = work.wrench[i] / (weight if i < 3 else unit)
    rows, share, bound = 0, np.inf, 0.0
    for _ in range(ROUNDS):
        nearest_sum(
            work.contacts.maps,
            work.contacts.mu,
            count + rows,
            6 + rows,
            work.b,
            work.r,
            work.forces,
            work.work,
        )
        share = left_over(work.contacts, count, work.b, work.forces)
        bound = proven_bound(work.contacts, count + rows, 6 + rows, work.b, work.r)
        if not rules.torques:
            break
        for j in range(work.torques.shape[0]):
            work.torques[j] = work.free[j] / unit
        take_forces(
            model.tree, motion, k, model.points, work.contacts, count, model.moves, work.forces, rules.arm,
            work.torques,
        )  # fmt: skip
        excess, new = _find_excess(model, k, unit, rows, work)
        share = np.sqrt(share * share + excess)
        if new == 0:
            break
        _add_rows(model, k, unit, count, rows, new, work)
        rows += new
    return count, rows, share, bound, touch


@kernel
def solve_frames(model: Model, frames: IntArray, answer: Answer) -> None:
    """Fill the answers of (n,) frames, all with their windows in the motion."""
    work = workspace(model.points.body.shape[0], model.tree.mass.shape[0], model.motion.joints.shape[0])
    weight = model.rules.mass * GRAVITY
    for k in frames:
        _, rows, share, bound, touch = solve_frame(model, k, work)
        answer.share[k], answer.bound[k] = share, bound
        for i in range(6):
            answer.wrench[k, i] = work.r[i] * (weight if i < 3 else weight * model.rules.arm)
            answer.needed[k, i] = work.wrench[i]
        for j in range(answer.torques.shape[1]):
            answer.torques[k, j] = 0.0
        for i in range(rows):
            answer.torques[k, work.joint[i] // 2] += work.r[6 + i] * weight * model.rules.arm
        answer.contacts[k], answer.sliding[k] = touch.points, touch.sliding
        answer.slowest[k], answer.lowest[k] = touch.slowest, touch.lowest


@kernel
def sum_forces(model: Model, frames: IntArray, group: IntArray, out: FloatArray) -> None:
    """Fill what the best forces of frames sum to, by groups of points.

    Parameters
    ----------
    frames
        (n,) all with their windows in the motion.
    group
        (p,) group of each point.
    out
        (T, groups, 6) force and moment about the centre of mass, zero before [N, N m].
    """
    work = workspace(model.points.body.shape[0], model.tree.mass.shape[0], model.motion.joints.shape[0])
    weight = model.rules.mass * GRAVITY
    for k in frames:
        count = solve_frame(model, k, work)[0]
        for c in range(count):
            sums = out[k, group[work.contacts.point[c]]]
            for a in range(2 if work.contacts.mu[c] <= 0.0 else 0, 3):
                for i in range(6):
                    unit = weight if i < 3 else weight * model.rules.arm
                    sums[i] += unit * work.contacts.maps[c, a, i] * work.forces[c, a]
