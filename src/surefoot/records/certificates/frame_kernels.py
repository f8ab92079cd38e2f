"""The frames of a motion one by one: the forces of their contacts nearest to what they need; compiled.

Everything is divided by the weight m g, moments and torques by `arm` m g more. A joint beyond what its
motor can give adds a dimension: its torque less the limit, with a ray for all torques within.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import kernel
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.body_tree import BodyTree
from surefoot.records.certificates.bounds import left_over, proven_bound
from surefoot.records.certificates.cone_distance import nearest_sum
from surefoot.records.certificates.contact_cones import (
    MOST_ROWS,
    Contacts,
    PointArrays,
    Rules,
    gather,
    room_for,
)
from surefoot.records.certificates.torque_rows import MotorArrays, add_rotors, add_torque_row, take_forces
from surefoot.records.certificates.window_kernels import MotionArrays, Window, needed_wrench

ROUNDS = 8
"""Times that limits which bind are added, at most."""


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


@kernel
def solve_frame(
    tree: BodyTree, motion: MotionArrays, points: PointArrays, motors: MotorArrays, moves: BoolArray,
    window: Window, rules: Rules, k: int, count: int, contacts: Contacts, wrench: FloatArray,
    free_torques: FloatArray, b: FloatArray, r: FloatArray, forces: FloatArray, work: FloatArray,
    joint: IntArray, torques: FloatArray,
) -> tuple[int, float, float]:  # fmt: skip
    """Fill forces nearest to what frame k needs, the certificate r, and the joints of its torque rows.

    Parameters
    ----------
    moves
        (j, b) whether a joint moves a body.
    wrench, free_torques
        (6,), (j,) of `needed_wrench`.
    b, r
        (6 + MOST_ROWS,) filled.
    joint
        (MOST_ROWS,) filled: joints of the rows, as 2 j + 1 for an upper limit and 2 j for a lower one.
    torques
        (j,) filled: torques of the joints with those forces [over m g and `arm`].

    Returns
    -------
    Number of rows, what the forces leave, and what no forces do better than [m g].
    """
    weight = rules.mass * GRAVITY
    unit = weight * rules.arm
    for i in range(6):
        b[i] = wrench[i] / (weight if i < 3 else unit)
    rows, share, bound = 0, np.inf, 0.0
    for _ in range(ROUNDS):
        nearest_sum(contacts.maps, contacts.mu, count + rows, 6 + rows, b, r, forces, work)
        share = left_over(contacts, count, b, forces)
        bound = proven_bound(contacts, count + rows, 6 + rows, b, r)
        if not rules.torques:
            break
        for j in range(motion.joints.shape[0]):
            torques[j] = free_torques[j] / unit
        take_forces(tree, motion, k, points, contacts, count, moves, forces, rules.arm, torques)
        excess, new = 0.0, 0
        for j in range(motion.joints.shape[0]):
            over, under = torques[j] - motors.high[k, j] / unit, motors.low[k, j] / unit - torques[j]
            most = max(over, under)
            if most <= 0.0:
                continue
            excess += most * most
            name = 2 * j + (1 if over > 0.0 else 0)
            known = False
            for i in range(rows + new):
                known = known or joint[i] == name
            if known or most <= 1e-7 or rows + new >= MOST_ROWS:
                continue
            joint[rows + new] = name
            new += 1
        share = np.sqrt(share * share + excess)
        if new == 0:
            break
        for _ in range(new):
            name = joint[rows]
            sign = 1.0 if name % 2 == 1 else -1.0
            limit = motors.high[k, name // 2] if name % 2 == 1 else motors.low[k, name // 2]
            b[6 + rows] = (free_torques[name // 2] - limit) / unit
            add_torque_row(
                tree, motion, k, points, contacts, count, moves, name // 2, rows, rows, sign, rules.arm
            )
            rows += 1
    return rows, share, bound


@kernel
def solve_frames(
    tree: BodyTree, motion: MotionArrays, points: PointArrays, motors: MotorArrays, moves: BoolArray,
    window: Window, weights: FloatArray, rules: Rules, frames: IntArray, answer: Answer,
) -> None:  # fmt: skip
    """Fill the answers of some frames, all with their windows in the motion."""
    p, bodies, j = points.body.shape[0], tree.mass.shape[0], motion.joints.shape[0]
    contacts = room_for(p)
    top = contacts.mu.shape[0]
    parts, wrench, free = np.empty((bodies, 6)), np.empty(6), np.empty(j)
    b, r, forces = np.empty(6 + MOST_ROWS), np.empty(6 + MOST_ROWS), np.zeros((top, 3))
    work, joint, torques = (
        np.empty((top + 40, 6 + MOST_ROWS)),
        np.empty(MOST_ROWS, dtype=np.int64),
        np.empty(j),
    )
    weight = rules.mass * GRAVITY
    for k in frames:
        needed_wrench(tree, motion, window, weights, k, rules.pace, parts, wrench, free)
        add_rotors(motion, motors, window, rules.pace, k, free)
        count, touching, sliding, slowest, lowest = gather(motion, points, window, rules, k, contacts)
        rows, share, bound = solve_frame(
            tree, motion, points, motors, moves, window, rules, k, count, contacts, wrench, free, b, r,
            forces, work, joint, torques,
        )  # fmt: skip
        answer.share[k], answer.bound[k] = share, bound
        for i in range(6):
            answer.wrench[k, i] = r[i] * (weight if i < 3 else weight * rules.arm)
            answer.needed[k, i] = wrench[i]
        answer.torques[k] = 0.0
        for i in range(rows):
            answer.torques[k, joint[i] // 2] += r[6 + i] * weight * rules.arm
        answer.contacts[k], answer.sliding[k] = touching, sliding
        answer.slowest[k], answer.lowest[k] = slowest, lowest
