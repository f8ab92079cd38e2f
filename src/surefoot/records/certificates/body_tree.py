"""A robot's joints and masses as plain arrays, and where its bodies are at every frame of a motion."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import kernel
from surefoot.base.numerics.rotations import rotation_about, rotation_of
from surefoot.mechanics import Robot

FREE, TURNS, SLIDES, TURNS_ON, OTHER = range(5)
"""Kinds of joints: free flyer, about an axis, along an axis, about an axis by (cos, sin), and all others."""


class BodyTree(NamedTuple):
    """The b joints of a robot, each with the body that it carries, Pinocchio's joint 1 first.

    Attributes
    ----------
    parent
        (b,) index of the parent joint, -1 for the world.
    kind
        (b,) of `FREE`, `TURNS`, `SLIDES`, `TURNS_ON`, `OTHER`.
    first_q, first_v
        (b,) first index in q and v.
    turn, shift
        (b, 3, 3), (b, 3) placement in the parent's frame at zero [-, m].
    axis
        (b, 3) of the joint in its own frame [-].
    mass, centre, inertia
        (b,), (b, 3), (b, 3, 3) of the body: in its joint's frame, about its centre of mass [kg, m, kg m²].
    """

    parent: IntArray
    kind: IntArray
    first_q: IntArray
    first_v: IntArray
    turn: FloatArray
    shift: FloatArray
    axis: FloatArray
    mass: FloatArray
    centre: FloatArray
    inertia: FloatArray


def body_tree(robot: Robot) -> BodyTree:
    """Return the joints and masses of a robot.

    Raises
    ------
    ProblemError
        If its base is fixed: the ground need not give the forces of what is bolted to it.
    """
    import pinocchio

    if not robot.floating:
        raise ProblemError(f"{robot.name} has a fixed base; a certificate is of robots with a free one")
    model, data = robot.model, robot.model.createData()
    pinocchio.computeJointJacobians(model, data, pinocchio.neutral(model))
    count = model.njoints - 1
    kinds, axes = np.empty(count, dtype=np.int64), np.zeros((count, 3))
    for b in range(count):
        kinds[b], axes[b] = _joint(model, data, b + 1)
    joints = [model.joints[b + 1] for b in range(count)]
    places = [model.jointPlacements[b + 1] for b in range(count)]
    bodies = [model.inertias[b + 1] for b in range(count)]
    return BodyTree(
        np.array([int(model.parents[b + 1]) - 1 for b in range(count)], dtype=np.int64),
        kinds,
        np.array([j.idx_q for j in joints], dtype=np.int64),
        np.array([j.idx_v for j in joints], dtype=np.int64),
        np.array([p.rotation for p in places]),
        np.array([p.translation for p in places]),
        axes,
        np.array([body.mass for body in bodies]),
        np.array([body.lever for body in bodies]),
        np.array([body.inertia for body in bodies]),
    )


def _joint(model: Any, data: Any, joint: int) -> tuple[int, FloatArray]:
    """Return the kind of a joint and its axis in its own frame, from its Jacobian at the neutral pose."""
    one = model.joints[joint]
    name = str(one.shortname())
    if name == "JointModelFreeFlyer":
        return FREE, np.zeros(3)
    if one.nv != 1:
        return OTHER, np.zeros(3)
    place = data.oMi[joint]
    column = np.array(data.J)[:, one.idx_v]
    turning = np.linalg.norm(column[3:]) > 0.5
    axis = place.rotation.T @ (column[3:] if turning else column[:3])
    if one.nq == 2:
        return (TURNS_ON, axis) if turning else (OTHER, axis)
    plain = name.startswith(("JointModelR", "JointModelP"))
    return (TURNS if turning else SLIDES, axis) if plain else (OTHER, axis)


def body_places(robot: Robot, tree: BodyTree, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return rotations (T, b, 3, 3) [-] and origins (T, b, 3) [m] of all joints, world axes."""
    turns, origins = np.empty((len(q), len(tree.parent), 3, 3)), np.empty((len(q), len(tree.parent), 3))
    if not (tree.kind == OTHER).any():
        place_bodies(tree, np.ascontiguousarray(q), turns, origins)
        return turns, origins
    import pinocchio

    model, data = robot.model, robot.model.createData()
    for k in range(len(q)):
        pinocchio.forwardKinematics(model, data, q[k])
        for b in range(len(tree.parent)):
            place = data.oMi[b + 1]
            turns[k, b], origins[k, b] = place.rotation, place.translation
    return turns, origins


@kernel
def place_bodies(tree: BodyTree, q: FloatArray, turns: FloatArray, origins: FloatArray) -> None:
    """Fill rotations (T, b, 3, 3) and origins (T, b, 3) of joints at (T, nq) q, joint after joint."""
    own, at, local = np.empty((3, 3)), np.empty(3), np.empty((3, 3))
    for k in range(q.shape[0]):
        for b in range(tree.parent.shape[0]):
            i, kind = tree.first_q[b], tree.kind[b]
            slide = q[k, i] if kind == SLIDES else 0.0
            if kind == FREE:
                rotation_of(q[k, i:], own)
            elif kind == SLIDES:
                own[:] = np.eye(3)
            else:
                c, s = (np.cos(q[k, i]), np.sin(q[k, i])) if kind == TURNS else (q[k, i], q[k, i + 1])
                rotation_about(tree.axis[b], c, s, own)
            for r in range(3):
                at[r] = tree.shift[b, r]
                for a in range(3):
                    move = q[k, i + a] if kind == FREE else slide * tree.axis[b, a]
                    at[r] += tree.turn[b, r, a] * move
                    local[r, a] = 0.0
                    for j in range(3):
                        local[r, a] += tree.turn[b, r, j] * own[j, a]
            up = tree.parent[b]
            for r in range(3):
                origins[k, b, r] = at[r] if up < 0 else origins[k, up, r]
                for a in range(3):
                    if up < 0:
                        turns[k, b, r, a] = local[r, a]
                        continue
                    origins[k, b, r] += turns[k, up, r, a] * at[a]
                    total = 0.0
                    for j in range(3):
                        total += turns[k, up, r, j] * local[j, a]
                    turns[k, b, r, a] = total
