"""What goes into whole-body control and comes out of it: tasks and their weights, kinematics, command."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from surefoot.base.arrays import (
    BoolArray,
    FloatArray,
    finite_array,
    of_kind,
    real_number,
    sized_array,
    sized_flags,
)
from surefoot.base.settings import Settings, setting
from surefoot.contact import Status
from surefoot.mechanics import Actuators
from surefoot.motion.control.whole_body_outcome import (
    BindingLimit,
    StepNotes,
    TaskOutcome,
    binding_limits,
    body_compromised,
    task_outcomes,
)


@dataclass(frozen=True)
class TaskWeights(Settings):
    """Weights of the tasks; all act on squared accelerations.

    Attributes
    ----------
    linear
        Centre of mass [1/(m/s²)²].
    angular
        Base orientation, per squared unit of angular acceleration times the base's height.
    swing
        Feet in the air. They cost no more than a little of the body's motion: where a leg's motors cannot
        lift it as fast as is wanted, with a weight of 1 those on the ground throw the body up to lift it.
        Where legs have more joints than a foot's place takes, feet weigh 1, the legs' joints as much more.
    joints
        Joint accelerations times the base's height, of legs; joints outside the legs count `body` times
        as much.
    body
        See `joints`.
    force
        Distance of the contact forces from the wanted ones, divided by the robot's mass.
    """

    linear: float = setting(
        1.0, "s⁴/m²", "weight of the centre of mass", low=0.0,
        tuned="`surefoot bench ablation --vary TaskWeights.linear --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 1 to 1",
    )  # fmt: skip
    angular: float = setting(
        1.0, "s⁴/m²", "weight of the base's orientation, over the base's height", low=0.0
    )
    swing: float = setting(
        0.02, "s⁴/m²", "weight of feet in the air", low=0.0,
        tuned="`surefoot bench ablation --vary TaskWeights.swing --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.02 to 0.4",
    )  # fmt: skip
    joints: float = setting(
        2e-5, "s⁴/m²", "weight of the legs' joints, over the base's height", low=0.0,
        tuned="`surefoot bench ablation --vary TaskWeights.joints --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 1e-06 to 2e-05",
    )  # fmt: skip
    body: float = setting(5e3, "-", "factor on it for joints outside the legs", low=0.0)
    force: float = setting(
        0.1, "s⁴/m²", "weight of contact forces, over the mass", low=0.0,
        tuned="`surefoot bench ablation --vary TaskWeights.force --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.005 to 0.1",
    )  # fmt: skip


def check_parts(actuators: Actuators | None, weights: TaskWeights | None) -> None:
    """Refuse what are no motors or weights; None is neither."""
    if actuators is not None:
        of_kind("actuators", actuators, Actuators)
    if weights is not None:
        of_kind("weights", weights, TaskWeights)


def control_numbers(
    mu: float, normals: tuple[float, float], rates: tuple[float, float], sole: tuple[float, float] | None
) -> tuple[float, float, float, tuple[float, ...]]:
    """Return what a whole-body controller is given, checked: friction, normal bounds, and the four rates.

    The arguments are those of `WholeBodyController`; without rates of soles they have the contact's damping.
    """
    low, high = normals
    low, high = real_number("normal_min", low, low=0.0), real_number("normal_max", high, low=0.0)
    stiffness, damping = finite_array("baumgarte", rates, (2,)).tolist()
    soles = [damping, damping] if sole is None else finite_array("sole_damping", sole, (2,)).tolist()
    return real_number("mu", mu, low=0.0), low, high, (stiffness, damping, *soles)


class Kinematics(NamedTuple):
    """Where a robot is and how it moves, world axes; see `WholeBodyController.update` for whose arrays.

    Attributes
    ----------
    com, com_velocity
        (3,) centre of mass [m, m/s].
    rotation, angular_velocity
        (3, 3), (3,) of the base.
    centres, twists, drifts
        (n, 3), (n, 6), (n, 6) of the feet: place, velocity [linear; angular], acceleration at zero
        joint acceleration.
    """

    com: FloatArray
    com_velocity: FloatArray
    rotation: FloatArray
    angular_velocity: FloatArray
    centres: FloatArray
    twists: FloatArray
    drifts: FloatArray


class Tasks(NamedTuple):
    """What is wanted in one step; world axes.

    Attributes
    ----------
    stance
        (n,) which feet carry.
    com_acceleration, turn_acceleration
        (3,) of the centre of mass [m/s²] and of the base's orientation [rad/s²].
    feet
        (n, 6) wanted acceleration, linear and angular, of feet in the air [m/s², rad/s²].
    joints
        (joints,) wanted joint accelerations [rad/s²].
    forces
        (p, 3) wanted contact forces, contact frames [N].
    frames
        (n, 3, 3) rotation_world_contact of every foot's ground [-].
    gaps
        (n,) distance of the feet in stance to the ground [m], for the Baumgarte term.
    """

    stance: BoolArray
    com_acceleration: FloatArray
    turn_acceleration: FloatArray
    feet: FloatArray
    joints: FloatArray
    forces: FloatArray
    frames: FloatArray
    gaps: FloatArray

    def fitting(self, feet: int, points: int, joints: int) -> Tasks:
        """Return the tasks of a robot with so many feet, contact points and joints; NaN is let through.

        Raises
        ------
        ProblemError
            For what is no array of its shape.
        """
        shapes = (3,), (3,), (feet, 6), (joints,), (points, 3), (feet, 3, 3), (feet,)
        rows = (sized_array(*one) for one in zip(TASK_NAMES, self[1:], shapes, strict=True))
        return Tasks(sized_flags("stance", self.stance, feet), *rows)


TASK_NAMES = Tasks._fields[1:]


class ForceLimits(NamedTuple):
    """What the contact forces of one step may be, and what acts on the robot beside them.

    Attributes
    ----------
    mu
        Friction to count on [-]; infinite for that of the controller.
    least, most
        Bounds on the normal forces [N], the upper one (n,) by foot, a flat foot's for each of its corners;
        None for those of the controller.
    outside
        (6,) known wrench on the base beside the ground's, about its origin, base axes [N, N m]; None for
        none.
    swing
        How many times their usual weight the places of feet in the air weigh [-].
    """

    mu: float = math.inf
    least: float = 0.0
    most: FloatArray | None = None
    outside: FloatArray | None = None
    swing: float = 1.0


class WholeBodyCommand(NamedTuple):
    """The command of one step of whole-body control, and what became of what was asked for.

    Attributes
    ----------
    torques
        (joints,) within the effort limits [N m].
    accelerations
        (nv,) that go with the forces, Pinocchio's order.
    forces
        (p, 3) contact forces inside every cone and bound, contact frames [N].
    feasible
        Whether dynamics, contacts, cones and torque limits can hold together (False: the torques are
        clipped, or the input was not finite and the command only damps the joints).
    violation
        Largest torque beyond its limit before clipping [N m].
    distribution
        How the force distribution ended; `status` says whether the tasks are met, too.
    notes
        Of the step, which `attained` and `binding` are worked out of when they are read; None for a command
        that only damps the joints.
    """

    torques: FloatArray
    accelerations: FloatArray
    forces: FloatArray
    feasible: bool
    violation: float
    distribution: Status
    notes: StepNotes | None = None

    @property
    def attained(self) -> dict[str, TaskOutcome]:
        """What was wanted and what is got of every task, by its name in `Tasks`; empty without `notes`.

        "feet" counts as met by those in the air. What joints and forces miss is the price of the others, as
        they weigh next to nothing.
        """
        return {} if self.notes is None else task_outcomes(self.notes, self.accelerations, self.forces)

    @property
    def binding(self) -> tuple[BindingLimit, ...]:
        """The cones, bounds and joints' limits on which the command lies, by name; empty without `notes`."""
        if self.notes is None:
            return ()
        return binding_limits(self.notes, self.torques, self.accelerations, self.forces)

    @property
    def status(self) -> Status:
        """How the step ended.

        INVALID for a state or task that nothing can be computed of, INFEASIBLE where torques had to be
        clipped, COMPROMISED where all limits hold but the body does not accelerate as is wanted, or a foot in
        the air not half as much (see `attained` and `binding`), else that of the force distribution.
        """
        if self.distribution is Status.INVALID or self.notes is None:
            return Status.INVALID
        if not self.feasible:
            return Status.INFEASIBLE
        found = self.distribution in (Status.SOLVED, Status.ALMOST)
        if found and body_compromised(self.notes, self.attained):
            return Status.COMPROMISED
        return self.distribution
