"""How a biped walks, as a value."""

from __future__ import annotations

from dataclasses import dataclass, field

from surefoot.mechanics import Actuators
from surefoot.motion.control.mpc import MpcWeights
from surefoot.motion.control.whole_body import TaskWeights
from surefoot.motion.walking.behaviours import Cruise, MakeBehaviour, StandStill


@dataclass(frozen=True)
class BipedSettings:
    """How a biped walks; the defaults suit every robot.

    Attributes
    ----------
    mu
        Friction that the controller believes in.
    friction_share
        Share of `mu` that commanded forces may use; the rest is for what the model leaves out.
    start
        Time to stand before the gait begins, in units of sqrt(h / g).
    stretch
        Least height of the hips over the ankles, as a share of the leg's length: a robot whose nominal pose
        is lower rises to it before it walks, so that its ankles have room.
    clearance
        Height of the swing over the ground, as a share of the height of the centre of mass.
    horizon
        Steps of the MPC.
    mpc_steps
        MPC steps in a cycle of the gait.
    preview
        Time over which the footsteps ahead shape the reference [s].
    plan_interval
        Longest time between plans [s].
    capture
        Share of the predicted divergence at touchdown that moves the foothold; the rest goes where the wanted
        body would put it.
    body_stiffness, swing_stiffness, joint_stiffness
        Natural frequencies of the feedback on the plan, of feet in the air and of the joints outside the
        legs, in units of sqrt(g / h).
    sole_damping
        Rates at which soles that carry stop moving along the ground's normal, and turning, in units of
        sqrt(g / h); see `WholeBodyController`.
    sole_press
        Acceleration with which soles that carry press down beyond what keeps them at rest, as a share of g:
        one that is hardly loaded yet stays on the ground, or finds it at this over the first rate.
    arm_swing
        Angle of the arms over the distance of the feet, in units of 1 / h.
    normal_min, normal_max
        Bounds on the normal force of a corner, as shares of m g.
    mpc, whole_body
        Weights.
    actuators
        What is known of the motors; None for ideal ones.
    behaviours
        What makes each behaviour, the highest rank first.
    """

    mu: float = 0.6
    friction_share: float = 0.9
    start: float = 2.5
    stretch: float = 0.83
    clearance: float = 0.09
    horizon: int = 14
    mpc_steps: int = 20
    preview: float = 2.4
    plan_interval: float = 0.02
    capture: float = 0.9
    body_stiffness: float = 2.0
    swing_stiffness: float = 8.0
    joint_stiffness: float = 3.0
    sole_damping: tuple[float, float] = (16.0, 40.0)
    sole_press: float = 0.3
    arm_swing: float = 0.8
    normal_min: float = 0.002
    normal_max: float = 1.2
    mpc: MpcWeights = field(
        default_factory=lambda: MpcWeights(
            position=(40.0, 40.0, 100.0),
            orientation=(50.0, 50.0, 30.0),
            linear_velocity=(3.0, 3.0, 1.0),
            angular_velocity=(0.3, 0.3, 0.3),
            force=1e-6,
        )
    )
    whole_body: TaskWeights = field(default_factory=TaskWeights)
    actuators: Actuators | None = None
    behaviours: tuple[MakeBehaviour, ...] = (StandStill, Cruise)
