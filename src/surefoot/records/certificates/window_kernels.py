"""What a motion needs, averaged over a window: change of momentum less weight, and torques; compiled.

Momenta stand between frames, from the bodies' own displacements, so that their difference over a window is
the exact mean of the forces in it, impacts included. With a window of n intervals and means over m of them,
the mean has the weights of a trapezoid: positive ones, so that it lies in a sum of cones if every force does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.base.numerics.rotations import log_between
from surefoot.base.spatial import GRAVITY
from surefoot.records.certificates.body_tree import SLIDES, BodyTree


class Window(NamedTuple):
    """A window of time about a frame.

    Attributes
    ----------
    length
        Intervals from the mean momentum at its start to that at its end [-].
    mean
        Intervals over which either mean is taken, even or odd as `length` [-].
    reach
        Frames on either side of the middle, (length + mean) / 2.
    step
        Time between frames [s].
    """

    length: int
    mean: int
    reach: int
    step: float


class MotionArrays(NamedTuple):
    """A motion as arrays, T frames and b bodies, world axes.

    Attributes
    ----------
    turns, origins
        (T, b, 3, 3), (T, b, 3) of the joints [-, m].
    centres
        (T, b, 3) centres of mass of the bodies [m].
    momenta
        (T - 1, b, 6) [linear; angular about the world's origin] of the bodies between frames [N s, N m s].
    rates
        (T - 1, b, 3) angular velocity of the bodies between frames [rad/s].
    com
        (T, 3) [m].
    joints
        (j,) bodies whose joints have a torque.
    angles
        (T, j) of those joints [rad, m].
    """

    turns: FloatArray
    origins: FloatArray
    centres: FloatArray
    momenta: FloatArray
    rates: FloatArray
    com: FloatArray
    joints: IntArray
    angles: FloatArray


@inline_kernel
def _spin(turn: FloatArray, inertia: FloatArray, rate: FloatArray, share: float, out: FloatArray) -> None:
    """Add share R I R^T rate to (3,) out [N m s]."""
    for c in range(3):
        own = 0.0
        for a in range(3):
            part = 0.0
            for b in range(3):
                part += turn[b, a] * rate[b]
            own += inertia[c, a] * part
        for a in range(3):
            out[a] += share * turn[a, c] * own


@kernel
def fill_momenta(tree: BodyTree, step: float, motion: MotionArrays) -> None:
    """Fill centres, centre of mass, momenta and rates of a motion from its placements."""
    total = tree.mass.sum()
    for k in range(motion.turns.shape[0]):
        motion.com[k] = 0.0
        for b in range(tree.mass.shape[0]):
            for i in range(3):
                place = motion.origins[k, b, i]
                for j in range(3):
                    place += motion.turns[k, b, i, j] * tree.centre[b, j]
                motion.centres[k, b, i] = place
                motion.com[k, i] += tree.mass[b] / total * place
    spin = np.empty(3)
    for k in range(motion.turns.shape[0] - 1):
        for b in range(tree.mass.shape[0]):
            rate, out = motion.rates[k, b], motion.momenta[k, b]
            log_between(motion.turns[k + 1, b], motion.turns[k, b], rate)
            for i in range(3):
                rate[i] /= step
            spin[:] = 0.0
            _spin(motion.turns[k, b], tree.inertia[b], rate, 0.5, spin)
            _spin(motion.turns[k + 1, b], tree.inertia[b], rate, 0.5, spin)
            for i in range(3):
                out[i] = tree.mass[b] * (motion.centres[k + 1, b, i] - motion.centres[k, b, i]) / step
            for i in range(3):
                a, c = (i + 1) % 3, (i + 2) % 3
                middle_a = 0.5 * (motion.centres[k, b, a] + motion.centres[k + 1, b, a])
                middle_c = 0.5 * (motion.centres[k, b, c] + motion.centres[k + 1, b, c])
                out[3 + i] = spin[i] + middle_a * out[c] - middle_c * out[a]


@kernel
def frame_weights(window: Window) -> FloatArray:
    """Return the weights (2 reach + 1,) of the frames in the mean over a window, whose sum is one."""
    out = np.empty(2 * window.reach + 1)
    for i in range(out.shape[0]):
        t = abs(i - window.reach)
        half, edge = 0.5 * window.length, 0.5 * window.mean
        out[i] = max(min(t + edge, half) - max(t - edge, -half), 0.0)
    total = out.sum()
    for i in range(out.shape[0]):
        out[i] /= total
    return out


@kernel
def needed_wrench(
    tree: BodyTree, motion: MotionArrays, window: Window, weights: FloatArray, k: int, pace: float,
    parts: FloatArray, wrench: FloatArray, torques: FloatArray,
) -> None:  # fmt: skip
    """Fill what the ground and the motors must give about frame k, in the mean over its window.

    Parameters
    ----------
    k
        A frame with its whole window in the motion.
    pace
        Factor on the speed of the motion: momenta change by its square.
    parts
        (b, 6) filled: the wrenches of the bodies with all that hang on them, about the centre of mass.
    wrench
        (6,) filled: [force; moment about the centre of mass at k] [N, N m].
    torques
        (j,) filled: of the joints, were the contacts without force [N m, N].
    """
    first, last = k - window.reach, k + (window.length - window.mean) // 2
    span = window.length * window.step * window.mean
    com = motion.com[k]
    for b in range(tree.mass.shape[0]):
        part = parts[b]
        for i in range(6):
            total = 0.0
            for s in range(window.mean):
                total += motion.momenta[last + s, b, i] - motion.momenta[first + s, b, i]
            part[i] = pace * pace * total / span
        # moment of the weight: its mean place
        x, y = 0.0, 0.0
        for s in range(weights.shape[0]):
            x += weights[s] * motion.centres[first + s, b, 0]
            y += weights[s] * motion.centres[first + s, b, 1]
        weight = tree.mass[b] * GRAVITY
        part[2] += weight
        part[3] += y * weight
        part[4] -= x * weight
        for i in range(3):
            a, c = (i + 1) % 3, (i + 2) % 3
            part[3 + i] -= com[a] * part[c] - com[c] * part[a]
    for b in range(tree.mass.shape[0] - 1, 0, -1):
        if tree.parent[b] >= 0:
            for i in range(6):
                parts[tree.parent[b], i] += parts[b, i]
    for i in range(6):
        wrench[i] = 0.0
        for b in range(tree.mass.shape[0]):
            if tree.parent[b] < 0:
                wrench[i] += parts[b, i]
    axis, arm = np.empty(3), np.empty(3)
    for j in range(motion.joints.shape[0]):
        joint_line(tree, motion, j, k, axis, arm)
        torques[j] = on_joint(tree.kind[motion.joints[j]], axis, arm, parts[motion.joints[j]])


@inline_kernel
def joint_line(
    tree: BodyTree, motion: MotionArrays, j: int, k: int, axis: FloatArray, arm: FloatArray
) -> None:
    """Fill the axis (3,) of a joint and its origin (3,) from the centre of mass, at frame k [-, m]."""
    b = motion.joints[j]
    for i in range(3):
        axis[i] = 0.0
        arm[i] = motion.origins[k, b, i] - motion.com[k, i]
        for c in range(3):
            axis[i] += motion.turns[k, b, i, c] * tree.axis[b, c]


@inline_kernel
def on_joint(kind: int, axis: FloatArray, arm: FloatArray, wrench: FloatArray) -> float:
    """Return what a wrench (6,) about the centre of mass does on a joint's axis [N m, N]."""
    total = 0.0
    for i in range(3):
        if kind == SLIDES:
            total += axis[i] * wrench[i]
        else:
            a, c = (i + 1) % 3, (i + 2) % 3
            total += axis[i] * (wrench[3 + i] - (arm[a] * wrench[c] - arm[c] * wrench[a]))
    return total
