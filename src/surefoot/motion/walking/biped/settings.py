"""How a biped walks, as a value."""

from __future__ import annotations

from dataclasses import dataclass, field

from surefoot.base.settings import Settings, setting
from surefoot.mechanics import Actuators
from surefoot.motion.control.mpc import MpcWeights
from surefoot.motion.control.whole_body import TaskWeights
from surefoot.motion.walking.behaviours import Cruise, MakeBehaviour, StandStill
from surefoot.motion.walking.behaviours.behaviour_settings import BehaviourSettings


@dataclass(frozen=True)
class BipedSettings(Settings):
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
    behaviour_settings
        Settings of the behaviours, a part for each.
    mpc, whole_body
        Weights.
    actuators
        What is known of the motors; None for ideal ones.
    behaviours
        What makes each behaviour, the highest rank first.
    """

    mu: float = setting(0.6, "-", "friction that the controller counts on", low=0.0)
    friction_share: float = setting(
        0.9, "-", "share of the friction that commanded forces may use", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary BipedSettings.friction_share --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 0.9 to 1",
    )  # fmt: skip
    start: float = setting(
        2.5, "sqrt(h / g)", "time to stand before the gait begins", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.start --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 2.5 to 2.5",
    )  # fmt: skip
    stretch: float = setting(
        0.83, "-", "least height of the hips over the ankles, as a share of the leg's length",
        low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary BipedSettings.stretch --value 0.75 --value 0.9 "
        "--task g1-fast --seeds 6`, 2026-11-27: as good from 0.75 to 0.83",
    )  # fmt: skip
    clearance: float = setting(
        0.09, "h", "height of the swing over the ground", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.clearance --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 0.09 to 0.09",
    )  # fmt: skip
    horizon: int = setting(
        14, "-", "steps of the MPC", low=1,
        tuned="`surefoot bench ablation --vary BipedSettings.horizon --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 1 to 14; "
        "5 of 6 fall with 1, which may be chance",
    )  # fmt: skip
    mpc_steps: int = setting(20, "-", "MPC steps in a cycle of the gait", low=1)
    preview: float = setting(
        2.4, "s", "time over which the footsteps ahead shape the reference", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.preview --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 2.4 to 48",
    )  # fmt: skip
    plan_interval: float = setting(0.02, "s", "longest time between plans", low=0.0)
    capture: float = setting(
        0.9, "-", "share of the predicted divergence at touchdown that moves the foothold", low=0.0
    )
    body_stiffness: float = setting(
        2.0, "sqrt(g / h)", "natural frequency of the feedback on the body's plan", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.body_stiffness --factor 20 "
        "--task g1-step --seeds 3`, 2026-11-26: as good from 0.1 to 2",
    )  # fmt: skip
    swing_stiffness: float = setting(
        8.0, "sqrt(g / h)", "natural frequency of the feedback on feet in the air", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.swing_stiffness --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 8 to 8",
    )  # fmt: skip
    joint_stiffness: float = setting(
        3.0, "sqrt(g / h)", "natural frequency of joints outside the legs", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.joint_stiffness --factor 20 "
        "--task g1-step --seeds 3`, 2026-11-26: as good from 0.15 to 3; "
        "2 of 3 fall with 0.15, which may be chance",
    )  # fmt: skip
    sole_damping: tuple[float, float] = setting(
        (16.0, 40.0), "sqrt(g / h)", "rates at which stance soles stop moving along the normal, and turning",
        low=0.0,
    )  # fmt: skip
    sole_press: float = setting(
        0.3, "g", "acceleration with which stance soles press down beyond what keeps them at rest", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.sole_press --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 0.015 to 0.3",
    )  # fmt: skip
    arm_swing: float = setting(0.8, "1/h", "angle of the arms over the distance of the feet", low=0.0)
    normal_min: float = setting(0.002, "m g", "least normal force of a corner of a stance sole", low=0.0)
    normal_max: float = setting(
        1.2, "m g", "largest normal force of a corner of a stance sole", low=0.0,
        tuned="`surefoot bench ablation --vary BipedSettings.normal_max --factor 20 "
        "--task g1-step --seeds 6`, 2026-11-26: as good from 1.2 to 24",
    )  # fmt: skip
    behaviour_settings: BehaviourSettings = field(default_factory=BehaviourSettings)
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
