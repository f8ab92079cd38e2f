"""What the logged forces leave unexplained of the motion: Newton-Euler, row by row.

    r = M v̇ + h - S τ - Σ Jᵢᵀ fᵢ - Q - Jᵀ push

with Q what other contacts than the feet's put on the robot, where the log has it.

Its six base rows are the force and the moment that something not in the log puts on the whole robot; the rows
of a leg's joints, as a force at its foot, say which foot's force is wrong.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import loaded_model
from surefoot.records.audit.limits import LIMITS
from surefoot.records.audit.logged_robot import LoggedRobot
from surefoot.records.log import Log

DAMPING = 1e-4
"""Share of a leg's squared lever that keeps its force bounded where the leg is stretched."""
MOTOR_FACTS = ("armature", "viscous_friction", "dry_friction")
"""Facts of a log that say what rotors and friction take of the torques."""


@dataclass(frozen=True)
class UnexplainedForces:
    """What is left over, in rows of a log.

    Attributes
    ----------
    force, moment
        (T, 3) on the whole robot, world axes, the moment about the base [N, N m].
    feet
        (T, n, 3) force on each foot that its leg's joint torques miss, world axes [N]; NaN without torques,
        and for links that are no ends of limbs: few joints with short levers say little of a force there.
    velocities
        (T, 2, p, 3) of the feet's material at the contact points, by the robot's joints before and after the
        step to the next row, in the configuration before it (of means: in either), world axes [m/s].
    """

    force: FloatArray
    moment: FloatArray
    feet: FloatArray
    velocities: FloatArray


def unexplained(
    robot: LoggedRobot,
    log: Log,
    forces_world: FloatArray,
    mass_scale: float = 1.0,
    payload: float = 0.0,
    payload_position: FloatArray | None = None,
    sticking: float = LIMITS.records.sticking,
    means: bool = False,
) -> UnexplainedForces:
    """Return what T rows with their successors, T + 1 in all, leave unexplained in the first T.

    Parameters
    ----------
    robot
        Whose log it is.
    log
        T + 1 rows with q, v, time and contact_positions; torques, push, other_forces, and the fact gravity,
        where it has them.
    forces_world
        (T + 1, p, 3) forces on the contact points, world axes [N].
    mass_scale
        The mass that the log tells over the robot's with its payload, for the base rows.
    payload, payload_position
        Load on the base [kg], see `loaded_model`, and where: (3,) base axes [m]; None for its origin.
    sticking
        A joint slower than this may stick: its dry friction is then any up to its size [rad/s].
    means
        Whether the forces are means over their rows, at means of configurations: what the way from a row's
        configuration to the next makes of each component is then open.
    """
    rows = len(log) - 1
    q, v = np.asarray(log["q"]), np.asarray(log["v"])
    dt = np.diff(np.asarray(log["time"]))[:, None]
    acceleration = np.diff(v, axis=0) / dt
    model = _load_model(robot.model, log, payload, payload_position)
    # M Δv / dt + h in the configuration before the step, with Coriolis forces of the velocity before and
    # after it.
    (torque, later), jacobian = _newton_euler(model, q[:-1], acceleration, v[:-1], v[1:])
    later -= torque
    in_world = _inverse_dynamics(model, q[:-1], v[:-1], _change_in_world(q, v, acceleration, dt)) - torque
    for part in (torque, later, in_world):
        part[:, : robot.base_dof] *= mass_scale
    force, place = forces_world[:-1], np.asarray(log["contact_positions"])[:-1]
    wrench = np.concatenate([force, np.cross(place, force)], axis=2)
    on_points = np.einsum("tpc,tcj->tpj", wrench, jacobian)
    support = robot.support.astype(np.float64)
    rest = torque - np.einsum("tpj,pj->tj", on_points, support)
    ends, open_torque = jacobian, np.zeros_like(rest)
    turned = robot.turned(v[:-1], dt) | means
    if turned.any():
        (end,), after = _newton_euler(model, q[1:][turned], acceleration[turned], v[1:][turned])
        end[:, : robot.base_dof] *= mass_scale
        end -= np.einsum("tpj,pj->tj", np.einsum("tpc,tcj->tpj", wrench[turned], after), support)
        open_torque[turned] = end - rest[turned]
        ends = after if means else jacobian
    pairs = ((jacobian, v[:-1]), (ends, v[1:]))
    twists = np.stack([np.einsum("tcj,tj,pj->tpc", J, speed, support) for J, speed in pairs], axis=1)
    velocities = twists[..., :3] + np.cross(twists[..., 3:], place[:, None])
    base = robot.base_dof
    R = rotation_from_quaternion(q[:-1, 3:7])
    if "push" in log:
        com = np.asarray(robot.model.inertias[1].lever)
        local = np.einsum("tji,tj->ti", R, np.asarray(log["push"])[:-1])
        rest[:, :3] -= local
        rest[:, 3:6] -= np.cross(com, local)
    feet = np.full((rows, robot.owner.max(initial=-1) + 1, 3), np.nan)
    if "other_forces" in log:
        rest -= np.asarray(log["other_forces"])[:-1]
    rest = _of_some_step(rest, later, in_world, base)
    if "torques" in log:
        rest[:, base:] -= np.asarray(log["torques"])[:-1]
        known = np.asarray(robot.model.armature)[base:]  # is in M already
        speeds, change = v[:, base:], acceleration[:, base:]
        rest[:, base:] += _joint_losses(log, speeds, change, rest[:, base:], known, sticking)
    beyond = np.abs(open_torque)  # stages of a row are not on the straight way between its ends
    rest += np.clip(-rest, np.minimum(open_torque, 0.0) - beyond, np.maximum(open_torque, 0.0) + beyond)
    if "torques" in log:
        feet = _at_feet(robot, rest, jacobian, place)
    force_left, moment_left = (np.einsum("tij,tj->ti", R, part) for part in (rest[:, :3], rest[:, 3:6]))
    return UnexplainedForces(force_left, moment_left, feet, velocities)


def _change_in_world(q: FloatArray, v: FloatArray, change: FloatArray, dt: FloatArray) -> FloatArray:
    """Return accelerations (T, nv) as `change`, of a base whose velocity changes in world axes in a step.

    Its own axes turn within the step: the two differ by its length times the square of the turning.
    """
    R, out = rotation_from_quaternion(q[:, 3:7]), change.copy()
    w = np.einsum("tij,tj->ti", R, v[:, :3])
    out[:, :3] = np.einsum("tji,tj->ti", R[:-1], np.diff(w, axis=0) / dt) - np.cross(v[:-1, 3:6], v[:-1, :3])
    return out


def _of_some_step(rest: FloatArray, later: FloatArray, in_world: FloatArray, base: int) -> FloatArray:
    """Return what is left (T, nv) by the step that leaves the least on the base.

    A step may take the velocity before it, after it, or a mean of both for its Coriolis forces (`later` is
    what that after it adds), and change the base's velocity in its own axes or the world's (`in_world`).
    """
    found = []
    for one in (rest, rest + in_world):
        size = np.maximum((later[:, :base] ** 2).sum(axis=1), 1e-24)
        share = -(one * later)[:, :base].sum(axis=1) / size
        found.append(one + np.clip(share, 0.0, 1.0)[:, None] * later)
    sizes = [(one[:, :base] ** 2).sum(axis=1) for one in found]
    return np.asarray(np.where((sizes[1] < sizes[0])[:, None], found[1], found[0]))


def balanced_forces(robot: LoggedRobot, log: Log) -> FloatArray:
    """Return the forces on the feet that the joint torques of each row balance at rest: (T, n, 3) world [N].

    What a controller that gives J^T f to stance legs asks of the ground; inertia of the legs is left out.

    Parameters
    ----------
    robot
        Whose log it is.
    log
        Rows with q, v, torques and contact_positions; the fact gravity where it has one.
    """
    q, v = np.asarray(log["q"]), np.asarray(log["v"])
    model = _load_model(robot.model, log)
    (torque,), jacobian = _newton_euler(model, q, np.zeros(v.shape), v)
    torque[:, robot.base_dof :] -= np.asarray(log["torques"])
    return _at_feet(robot, torque, jacobian, np.asarray(log["contact_positions"]))


def _joint_losses(
    log: Log,
    speeds: FloatArray,
    acceleration: FloatArray,
    rest: FloatArray,
    known: FloatArray,
    sticking: float,
) -> FloatArray:
    """Return the torques (T, joints) that rotors and joint friction take [N m], where the log states them.

    Rotors that the robot's model has, (joints,) `known`, take it there.

    The dry friction of a joint that sticks, or turns back, in the step of a row is what holds it, up to its
    size: it takes what (T, joints) `rest` leaves over. `speeds` are (T + 1, joints).
    """
    rotor, viscous, dry = (log.fact(name) if name in log.facts else 0.0 for name in MOTOR_FACTS)
    before, after = speeds[:-1], speeds[1:]
    rotor = rotor - known if "armature" in log.facts else 0.0
    lost = np.asarray(rotor * acceleration + viscous * before)
    holding = np.clip(-(rest + lost), -np.asarray(dry), dry)
    sticks = (np.minimum(np.abs(before), np.abs(after)) < sticking) | (before * after < 0.0)
    return np.asarray(lost + np.where(sticks, holding, dry * np.sign(before)))


def _load_model(model: Any, log: Log, payload: float = 0.0, position: FloatArray | None = None) -> Any:
    """Return a copy of a robot's model in the log's gravity, with a payload [kg] on the base."""
    model = loaded_model(model, payload, np.zeros(3) if position is None else position)
    model.gravity.linear = np.asarray(log.facts.get("gravity", model.gravity.linear))
    return model


def _inverse_dynamics(model: Any, q: FloatArray, v: FloatArray, a: FloatArray) -> FloatArray:
    """Return inverse dynamics (T, nv) of each row."""
    import pinocchio

    data, out = model.createData(), np.empty(a.shape)
    rnea: Any = pinocchio.rnea
    for k in range(len(a)):
        out[k] = rnea(model, data, q[k], v[k], a[k])
    return out


def _newton_euler(
    model: Any, q: FloatArray, a: FloatArray, *velocities: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return inverse dynamics (S, T, nv) at S velocities, and the world Jacobian (T, 6, nv), of each row."""
    import pinocchio

    data = model.createData()
    torque, jacobian = np.empty((len(velocities), *a.shape)), np.empty((len(a), 6, a.shape[1]))
    rnea: Any = pinocchio.rnea
    columns: Any = pinocchio.computeJointJacobians
    for k in range(len(a)):
        for out, v in zip(torque, velocities, strict=True):
            out[k] = rnea(model, data, q[k], v[k], a[k])
        jacobian[k] = columns(model, data, q[k])
    return torque, jacobian


def _at_feet(robot: LoggedRobot, rest: FloatArray, jacobian: FloatArray, place: FloatArray) -> FloatArray:
    """Return the joints' rest of every leg as a force at its foot: (T, n, 3), world axes; NaN elsewhere."""
    base = robot.base_dof
    out = np.full((len(rest), int(robot.owner.max(initial=-1)) + 1, 3), np.nan)
    for foot in range(out.shape[1]):
        leg = np.flatnonzero(robot.leg(foot)[base:]) + base
        if not leg.size or not robot.is_foot[robot.owner == foot].all():
            continue
        at = place[:, robot.owner == foot].mean(axis=1)
        J = jacobian[:, :3, leg] + np.cross(jacobian[:, 3:, leg], at[:, :, None], axis=1)
        # Least squares f of Jᵀ f = r over the leg's joints, damped where the leg is stretched.
        JJ = np.einsum("tij,tkj->tik", J, J)
        JJ += DAMPING * np.trace(JJ, axis1=1, axis2=2)[:, None, None] * np.eye(3)
        pulled = np.einsum("tij,tj->ti", J, rest[:, leg])
        out[:, foot] = np.linalg.solve(JJ, pulled[..., None])[..., 0]
    return out
