"""What became of the tasks of a whole-body step, and what bound it: worked out when somebody reads it.

A step notes in its own memory what it was given (`whole_body_step.WHOLE`), and a command carries a copy: the
loop pays for the copy alone, and a command that is kept tells the truth about its own step for good.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.numerics.points import point_jacobian
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot
from surefoot.motion.control import whole_body_step as core

MISS_SHARE = 0.1
"""A task is met when it is missed by at most this share of what was wanted [-] ..."""
MISS_LEAST = 0.1
"""... or by this share of g [-]: in a calm trot of Go2 the median miss of the centre of mass is 0.04 g, what
tasks that contradict each other cost there (`surefoot walk go2 --velocity 0.5 --seed 1`, 2026-11-26)."""
FOOT_SHARE, FOOT_LEAST = 0.5, 1.0
"""A foot in the air is compromised when it is missed by more than this share of what was wanted, and by this
many g [-]: it weighs little (`TaskWeights.swing`), and G1's miss 0.3 of it in a calm walk (median)."""
BINDING = 1e-6
"""Share of a limit within which a force, torque or acceleration lies on it [-]: solvers keep 1e-9 inside."""


class TaskOutcome(NamedTuple):
    """One task of a step: the reference and what the command gives.

    Attributes
    ----------
    wanted, got
        Arrays of the same shape and unit, as the field of `Tasks` that has the task's name.
    met
        Whether they agree to 10 % of what is wanted, or 0.1 g (turns and joints times the base's height,
        forces over the mass).
    """

    wanted: FloatArray
    got: FloatArray
    met: bool


class BindingLimit(NamedTuple):
    """A limit on which a command lies.

    Attributes
    ----------
    kind
        "friction", "normal_min" or "normal_max" of a contact point; "torque" or "acceleration" (so that its
        speed limit and stops hold) of a joint; "no_contact" of a robot with no foot on the ground.
    name
        Of the contact point ("FL_foot:0"), the joint, or the robot.
    """

    kind: str
    name: str


class StepNotes(NamedTuple):
    """What a command carries of its step.

    Attributes
    ----------
    robot
        That was commanded.
    numbers, memory
        Of the step, see `step_memory`; the memory is a copy of the parts in `whole_body_step.NOTED`.
    mu
        Friction that was counted on [-].
    normals
        Least and largest normal force of every contact point, (p,) each [N].
    """

    robot: Robot
    numbers: IntArray
    memory: FloatArray
    mu: float
    normals: tuple[FloatArray, FloatArray]

    def part(self, which: int, *shape: int) -> FloatArray:
        """Return a part of the memory, see `whole_body_step.part`: a view (...), any unit."""
        start, end = self.numbers[core.PARTS + which : core.PARTS + which + 2] - self.numbers[core.NOTED[0]]
        return self.memory[start:end].reshape(shape)

    @property
    def stance(self) -> BoolArray:
        """(n,) which feet carry."""
        return np.asarray(self.part(core.STANDS, -1) != 0.0)


def task_outcomes(notes: StepNotes, a: FloatArray, forces: FloatArray) -> dict[str, TaskOutcome]:
    """Return the outcome of every task by its name in `Tasks`, for accelerations (nv,) and forces (p, 3)."""
    points, stance = notes.robot.contact_points, notes.stance
    height = max(float(notes.robot.nominal[2]), 0.05)
    whole, rotation, grounds = notes.part(core.WHOLE, -1), notes.part(core.BASE, 3, 3), _grounds(notes)
    mass = float(whole[6])
    # Newton: m c̈ = Σ f + outside + m g, all in world axes
    push = np.einsum("pij,pj->i", grounds[points.foot], forces) + rotation @ whole[7:10]
    com = push / mass - [0.0, 0.0, GRAVITY]
    got = {
        "com_acceleration": (whole[:3], com, 1.0),
        "turn_acceleration": (whole[3:6], rotation @ a[3:6], height),
        "feet": (notes.part(core.MOVES, -1, 6), _foot_accelerations(notes, a), 1.0),
        "joints": (notes.part(core.GAINS, -1), a[6:], height),
        "forces": (notes.part(core.PUSHES, -1, 3), forces, 1.0 / mass),
    }
    out = {name: TaskOutcome(w.copy(), g.copy(), _met(w, g, unit)) for name, (w, g, unit) in got.items()}
    wanted, moved, _ = out["feet"]
    met = all(
        _met(wanted[k, :3], moved[k, :3], 1.0)
        and (not points.flat[k] or _met(wanted[k, 3:], moved[k, 3:], height))
        for k in np.flatnonzero(~stance)
    )
    return out | {"feet": TaskOutcome(wanted, moved, met)}


def _grounds(notes: StepNotes) -> FloatArray:
    return notes.part(core.GROUNDS, -1, 3, 3)


def _met(
    wanted: FloatArray, got: FloatArray, unit: float, share: float = MISS_SHARE, least: float = MISS_LEAST
) -> bool:
    """Return whether a task is met; times its unit it is an acceleration [m/s²]."""
    miss = unit * float(np.linalg.norm(wanted - got))
    return miss <= max(least * GRAVITY, share * unit * float(np.linalg.norm(wanted)))


def body_compromised(notes: StepNotes, outcomes: dict[str, TaskOutcome]) -> bool:
    """Return whether the body's tasks are not met, or a foot in the air hardly gets what was wanted."""
    if not (outcomes["com_acceleration"].met and outcomes["turn_acceleration"].met):
        return True
    wanted, got, _ = outcomes["feet"]
    air = np.flatnonzero(~notes.stance)
    return not all(_met(wanted[k, :3], got[k, :3], 1.0, FOOT_SHARE, FOOT_LEAST) for k in air)


def _foot_accelerations(notes: StepNotes, a: FloatArray) -> FloatArray:
    """Return the accelerations of the feet's centres and their turns (n, 6) [m/s², rad/s²], world axes."""
    nv, support = len(a), notes.robot.contact_points.foot_support
    twists, centres = notes.part(core.TWISTS, 6, nv), notes.part(core.CENTRES, -1, 3)
    out, rows = notes.part(core.DRIFTS, -1, 6).copy(), np.empty((3, nv))
    for k, moves in enumerate(support):
        point_jacobian(twists, moves, centres[k], rows)
        out[k, :3] += rows @ a
        out[k, 3:] += (twists[3:] * moves) @ a
    return out


def binding_limits(
    notes: StepNotes, torques: FloatArray, a: FloatArray, forces: FloatArray
) -> tuple[BindingLimit, ...]:
    """Return the limits on which a command lies, contact points first, then joints, each in their order.

    Torques (joints,) [N m], accelerations a (nv,) and forces (p, 3) [N] as in a `WholeBodyCommand`.
    """
    points, robot, stance = notes.robot.contact_points, notes.robot, notes.stance
    out = [] if stance.any() else [BindingLimit("no_contact", robot.name)]
    low, high = notes.normals
    for k in np.flatnonzero(stance[points.foot]):
        normal, sideways = float(forces[k, 2]), float(np.hypot(*forces[k, :2]))
        size = BINDING * max(robot.mass * GRAVITY, normal)
        if normal >= high[k] - size:
            out.append(BindingLimit("normal_max", points.names[k]))
        if normal <= low[k] + size:
            out.append(BindingLimit("normal_min", points.names[k]))
        if normal > size and sideways >= notes.mu * normal - size:
            out.append(BindingLimit("friction", points.names[k]))
    middle, half, friction, least, most = notes.part(core.SPAN, 5, -1)
    at_torque = np.abs(torques - friction - middle) >= half * (1.0 - BINDING)
    slack = BINDING * np.where(np.isfinite(most - least), most - least, 0.0)
    at_gain = (a[6:] <= least + slack) | (a[6:] >= most - slack)
    loose = ~points.foot_support[stance][:, 6:].any(axis=0)
    for name, torque, gain in zip(robot.joint_names, at_torque, at_gain & loose, strict=True):
        out += [BindingLimit("torque", name)] if torque else []
        out += [BindingLimit("acceleration", name)] if gain else []
    return tuple(out)
