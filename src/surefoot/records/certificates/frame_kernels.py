"""The frames of a motion one by one: contacts near the ground, forces nearest to what is needed; compiled.

Everything is divided by the weight m g, moments and torques by `arm` m g more. A joint beyond what its motor can
give adds a dimension: its torque less the limit, with a ray for all torques within.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.body_tree import BodyTree
from surefoot.records.certificates.cone_distance import nearest_sum
from surefoot.records.certificates.window_kernels import (
    MotionArrays,
    Window,
    joint_line,
    needed_wrench,
    on_joint,
)

MOST_ROWS = 24
"""Torque limits of one frame that may bind together."""
ROUNDS = 8
"""Times that limits which bind are added, at most."""


class PointArrays(NamedTuple):
    """The p points that may touch the ground, at T frames, world axes.

    Attributes
    ----------
    index
        (p,) which of the robot's `TouchingPoints` each is.
    body
        (p,) the body that carries each.
    mu
        (p,) friction of what sticks [-].
    places
        (T, p, 3) the lowest places of the points [m].
    gaps
        (T, p) distance to the ground [m].
    normals
        (T, p, 3) of the ground there; (1, 1, 3) for level ground [-].
    slides
        (T - 1, p, 3) velocity along the ground between frames [m/s].
    """

    index: IntArray
    body: IntArray
    mu: FloatArray
    places: FloatArray
    gaps: FloatArray
    normals: FloatArray
    slides: FloatArray


class MotorArrays(NamedTuple):
    """What j joints can give at T frames: `low` and `high` (T, j) [N m, N], and `inertia` (j,) of rotors [kg m²]."""

    low: FloatArray
    high: FloatArray
    inertia: FloatArray


class Rules(NamedTuple):
    """What counts as a contact, and what it can give.

    Attributes
    ----------
    clearance
        Distance to the ground up to which a point may touch it [m].
    stick
        Speed up to which it may stick [m/s].
    mu_scale
        Factor on the friction of what sticks [-].
    sliding_low, sliding_high
        Friction of what slides [-].
    pace
        Factor on the speed of the motion [-].
    torques
        Whether limits on torques count.
    mass, arm
        Units: [kg], and [m] by which moments are divided.
    """

    clearance: float
    stick: float
    mu_scale: float
    sliding_low: float
    sliding_high: float
    pace: float
    torques: bool
    mass: float
    arm: float


class Contacts(NamedTuple):
    """Cones of one frame: `point` (c,), `frames` (c, 3, 3) whose third column is the cone's axis, `mu` (c,), 0 for a
    ray, `places` (c, 3) from the centre of mass [m], and `maps` (c, 3, d) for the solver."""

    point: IntArray
    frames: FloatArray
    mu: FloatArray
    places: FloatArray
    maps: FloatArray


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
        (T,) sliding speed of the slowest foot [m/s], distance of the lowest point to the ground in the window [m].
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


@inline_kernel
def _frame_on(axis: FloatArray, out: FloatArray) -> None:
    """Fill a rotation (3, 3) whose third column is along (3,) axis."""
    size = np.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    x, y, z = axis[0] / size, axis[1] / size, axis[2] / size
    if abs(x) < 0.8:
        side = np.sqrt(y * y + z * z)
        out[0, 0], out[1, 0], out[2, 0] = 0.0, z / side, -y / side
    else:
        side = np.sqrt(x * x + z * z)
        out[0, 0], out[1, 0], out[2, 0] = z / side, 0.0, -x / side
    out[0, 2], out[1, 2], out[2, 2] = x, y, z
    a, b, c = out[0, 0], out[1, 0], out[2, 0]
    out[0, 1], out[1, 1], out[2, 1] = y * c - z * b, z * a - x * c, x * b - y * a


@inline_kernel
def _add(
    contacts: Contacts, count: int, point: int, mu: float, axis: FloatArray, place: FloatArray, com: FloatArray,
    arm: float,
) -> int:  # fmt: skip
    """Add a cone about an axis at a place; return the new count."""
    if count >= contacts.mu.shape[0]:
        return count
    contacts.point[count], contacts.mu[count] = point, mu
    _frame_on(axis, contacts.frames[count])
    for i in range(3):
        contacts.places[count, i] = place[i] - com[i]
    for a in range(3):
        f, p, row = contacts.frames[count, :, a], contacts.places[count], contacts.maps[count, a]
        row[0], row[1], row[2] = f[0], f[1], f[2]
        row[3] = (p[1] * f[2] - p[2] * f[1]) / arm
        row[4] = (p[2] * f[0] - p[0] * f[2]) / arm
        row[5] = (p[0] * f[1] - p[1] * f[0]) / arm
    return count + 1


@inline_kernel
def _touch(
    points: PointArrays, p: int, first: int, last: int, rules: Rules, place: FloatArray, which: IntArray
) -> tuple[int, float]:
    """Fill the mean place of a point while it may touch, and the first, middle and last such intervals.

    Returns
    -------
    Number of frames in which it may touch, and its least speed in the intervals beside them [m/s].
    """
    count, slowest = 0, np.inf
    place[:] = 0.0
    for s in range(first, last + 1):
        if points.gaps[s, p] <= rules.clearance:
            count += 1
            for i in range(3):
                place[i] += points.places[s, p, i]
    if count == 0:
        return 0, slowest
    place /= count
    found = 0
    for s in range(first, last):
        if points.gaps[s, p] <= rules.clearance or points.gaps[s + 1, p] <= rules.clearance:
            v = points.slides[s, p]
            slowest = min(slowest, np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2))
            which[0] = s if found == 0 else which[0]
            which[2] = s
            found += 1
    which[1] = (which[0] + which[2]) // 2
    return count, slowest


@kernel
def gather(
    motion: MotionArrays, points: PointArrays, window: Window, rules: Rules, k: int, contacts: Contacts
) -> tuple[int, int, int, float, float]:
    """Fill the cones of frame k.

    Returns
    -------
    Number of cones, of points that may touch, of points that slide; speed of the slowest and distance of the lowest
    point to the ground [m/s, m].
    """
    first, last = k - window.reach, k + window.reach
    count, touching, sliding, slowest, lowest = 0, 0, 0, np.inf, np.inf
    place, axis, which = np.empty(3), np.empty(3), np.zeros(3, dtype=np.int64)
    level = points.normals.shape[0] == 1
    for p in range(points.body.shape[0]):
        for s in range(first, last + 1):
            lowest = min(lowest, points.gaps[s, p])
        seen, speed = _touch(points, p, first, last, rules, place, which)
        if seen == 0:
            continue
        touching += 1
        slowest = min(slowest, speed)
        normal = points.normals[0, 0] if level else points.normals[which[1], p]
        if speed <= rules.stick:
            count = _add(contacts, count, p, rules.mu_scale * points.mu[p], normal, place, motion.com[k], rules.arm)
            continue
        sliding += 1
        for n in range(3):
            s = which[n]
            if n > 0 and s == which[n - 1]:
                continue
            v = points.slides[s, p]
            size = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
            for mu in (rules.sliding_low, rules.sliding_high):
                for i in range(3):
                    axis[i] = normal[i] - mu * v[i] / size
                count = _add(contacts, count, p, 0.0, axis, place, motion.com[k], rules.arm)
    return count, touching, sliding, slowest, lowest


@inline_kernel
def _joint_forces(
    tree: BodyTree, motion: MotionArrays, k: int, points: PointArrays, contacts: Contacts, count: int,
    moves: BoolArray, forces: FloatArray, arm: float, torques: FloatArray,
) -> None:  # fmt: skip
    """Take from (j,) torques what (count, 3) forces do on the joints [over m g and `arm`]."""
    axis, place = np.empty(3), np.empty(3)
    for j in range(motion.joints.shape[0]):
        joint_line(tree, motion, j, k, axis, place)
        kind = tree.kind[motion.joints[j]]
        for c in range(count):
            if moves[j, points.body[contacts.point[c]]]:
                torques[j] -= _row(kind, axis, place, contacts, c, forces[c]) / arm


@inline_kernel
def _row(
    kind: int, axis: FloatArray, place: FloatArray, contacts: Contacts, c: int, force: FloatArray
) -> float:
    """Return what a force (3,) of a cone's axes does on a joint [m]."""
    wrench = np.empty(6)
    p = contacts.places[c]
    for i in range(3):
        wrench[i] = 0.0
        for a in range(3):
            wrench[i] += contacts.frames[c, i, a] * force[a]
    wrench[3] = p[1] * wrench[2] - p[2] * wrench[1]
    wrench[4] = p[2] * wrench[0] - p[0] * wrench[2]
    wrench[5] = p[0] * wrench[1] - p[1] * wrench[0]
    return on_joint(kind, axis, place, wrench)


@inline_kernel
def _add_row(
    tree: BodyTree, motion: MotionArrays, k: int, points: PointArrays, contacts: Contacts, count: int,
    moves: BoolArray, j: int, row: int, rows: int, sign: float, arm: float,
) -> None:  # fmt: skip
    """Fill dimension 6 + row of all maps with joint j, and a ray of torques within its limit at count + row."""
    axis, place, one = np.empty(3), np.empty(3), np.zeros(3)
    joint_line(tree, motion, j, k, axis, place)
    kind = tree.kind[motion.joints[j]]
    for c in range(count):
        for a in range(3):
            one[:] = 0.0
            one[a] = 1.0
            on = moves[j, points.body[contacts.point[c]]]
            contacts.maps[c, a, 6 + row] = _row(kind, axis, place, contacts, c, one) / arm if on else 0.0
    at = count + row
    contacts.mu[at] = 0.0
    for other in range(rows + 1):
        contacts.maps[count + other, 2, 6 + row] = 0.0
        contacts.maps[at, 2, 6 + other] = 0.0
    for i in range(6):
        contacts.maps[at, 2, i] = 0.0
    contacts.maps[at, 2, 6 + row] = -sign


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
        share = _left(contacts, count, b, forces)
        bound = _proven(contacts, count + rows, 6 + rows, b, r)
        if not rules.torques:
            break
        for j in range(motion.joints.shape[0]):
            torques[j] = free_torques[j] / unit
        _joint_forces(tree, motion, k, points, contacts, count, moves, forces, rules.arm, torques)
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
        for i in range(new):
            name = joint[rows]
            sign = 1.0 if name % 2 == 1 else -1.0
            limit = motors.high[k, name // 2] if name % 2 == 1 else motors.low[k, name // 2]
            b[6 + rows] = (free_torques[name // 2] - limit) / unit
            _add_row(
                tree, motion, k, points, contacts, count, moves, name // 2, rows, rows, sign, rules.arm
            )
            rows += 1
    return rows, share, bound


@inline_kernel
def _left(contacts: Contacts, count: int, b: FloatArray, forces: FloatArray) -> float:
    """Return the size of what the contact forces leave of the wrench [m g]."""
    total = 0.0
    for i in range(6):
        left = b[i]
        for c in range(count):
            first = 2 if contacts.mu[c] <= 0.0 else 0
            for a in range(first, 3):
                left -= contacts.maps[c, a, i] * forces[c, a]
        total += left * left
    return np.sqrt(total)


@inline_kernel
def _proven(contacts: Contacts, count: int, d: int, b: FloatArray, r: FloatArray) -> float:
    """Move r into the polar of all cones, to the last bit but rounding, and return r.b / |r| [m g].

    A push down takes what is left over from every contact on ground that is not a wall; what a contact on a wall,
    or a ray of torque, still has makes the bound worthless, which is what it returns: 0.
    """
    push = 0.0
    for c in range(count):
        over = _over(contacts, c, d, r)
        down = contacts.frames[c, 2, 2] if contacts.maps[c, 2, 2] != 0.0 else 0.0
        side = 0.0
        if contacts.mu[c] > 0.0:
            side = contacts.mu[c] * np.hypot(contacts.frames[c, 2, 0], contacts.frames[c, 2, 1])
        if over > 0.0:
            if down - side > 0.05:
                push = max(push, 1.000001 * over / (down - side))
            elif contacts.maps[c, 2, 2] == 0.0:  # a ray of torque: take what is over from its own entry
                for i in range(6, d):
                    r[i] -= over * contacts.maps[c, 2, i]
            else:
                return 0.0
    r[2] -= push
    size, product = 0.0, 0.0
    for i in range(d):
        size += r[i] * r[i]
        product += r[i] * b[i]
    for c in range(count):
        if _over(contacts, c, d, r) > 1e-9 * np.sqrt(size):
            return 0.0
    return max(product / np.sqrt(size), 0.0) if size > 0.0 else 0.0


@inline_kernel
def _over(contacts: Contacts, c: int, d: int, r: FloatArray) -> float:
    """Return the largest product of r with the forces of a cone per newton along its axis."""
    u0, u1, u2 = 0.0, 0.0, 0.0
    for i in range(d):
        u2 += contacts.maps[c, 2, i] * r[i]
    if contacts.mu[c] <= 0.0:
        return u2
    for i in range(d):
        u0 += contacts.maps[c, 0, i] * r[i]
        u1 += contacts.maps[c, 1, i] * r[i]
    return u2 + contacts.mu[c] * np.hypot(u0, u1)


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
    work, joint, torques = np.empty((top + 40, 6 + MOST_ROWS)), np.empty(MOST_ROWS, dtype=np.int64), np.empty(j)
    weight = rules.mass * GRAVITY
    for k in frames:
        needed_wrench(tree, motion, window, weights, k, rules.pace, parts, wrench, free)
        add_rotors(motion, motors, window, rules.pace, k, free)
        count, touching, sliding, slowest, lowest = gather(motion, points, window, rules, k, contacts)
        rows, share, bound = solve_frame(
            tree, motion, points, motors, moves, window, rules, k, count, contacts, wrench, free, b, r, forces,
            work, joint, torques,
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


@kernel
def room_for(points: int) -> Contacts:
    """Return memory for the cones of so many points and for torque rows."""
    top = 6 * points + MOST_ROWS
    return Contacts(
        np.zeros(top, dtype=np.int64),
        np.zeros((top, 3, 3)),
        np.zeros(top),
        np.zeros((top, 3)),
        np.zeros((top, 3, 6 + MOST_ROWS)),
    )


@kernel
def add_rotors(
    motion: MotionArrays, motors: MotorArrays, window: Window, pace: float, k: int, torques: FloatArray
) -> None:
    """Add to (j,) torques what speeds up the rotors about frame k [N m]."""
    first, last = k - window.reach, k + (window.length - window.mean) // 2
    n = window.mean
    for j in range(torques.shape[0]):
        change = motion.angles[last + n, j] - motion.angles[last, j]
        change -= motion.angles[first + n, j] - motion.angles[first, j]
        torques[j] += pace * pace * motors.inertia[j] * change / (n * window.length * window.step**2)
