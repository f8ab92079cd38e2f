"""How a robot walks, and what its walking controller asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.settings import Settings, setting
from surefoot.mechanics import Actuators
from surefoot.motion.control.controller import Command
from surefoot.motion.control.mpc import MpcWeights
from surefoot.motion.control.whole_body import TaskWeights
from surefoot.motion.walking.behaviours import BEHAVIOURS, MakeBehaviour
from surefoot.motion.walking.behaviours.arbiter import LOGGED
from surefoot.motion.walking.behaviours.behaviour_settings import BehaviourSettings


@dataclass(frozen=True)
class WalkSettings(Settings):
    """How a robot walks; the defaults suit every robot.

    Attributes
    ----------
    mu
        Friction that the controller believes in [-].
    watch_friction
        Whether it believes in less where its feet slide, and slows; see `behaviours/slip.py`.
    friction_share
        Share of `mu` that commanded forces may use; the rest is for what the model leaves out.
    start
        Time to stand before the gait begins [s].
    clearance
        Height of the swing over the ground, as a share of the height of the centre of mass.
    ease
        Share of it over ground that is known to be a plane, while the body moves as planned.
    horizon
        Steps of the MPC.
    steps_per_period
        MPC steps in a cycle of the gait.
    plan_interval
        Longest time between plans [s].
    body_stiffness, swing_stiffness
        Natural frequencies of the feedback on the plan and of feet in the air, in units of sqrt(g / h).
    normal_min, normal_max
        Bounds on a stance foot's normal force, as shares of m g [-].
    load
        What is made of an unknown payload and external wrench; None to observe none.
    ramp
        Time over which the upper one grows after touchdown, and falls before lift-off, in units of
        sqrt(h / g) [-].
    gait_lead
        Multiple of its speed that the gait must be fit for before the body goes faster [-].
    catch_clearance
        Height of the swings over the usual one while a body is caught [-].
    held_stiffness
        Natural frequency of joints outside the legs, which hold their pose, in units of sqrt(g / h).
    flying_weight
        Factor on the swing-foot weight while no foot stands [-].
    horizon_period, horizon_stance
        Cycle that the horizon of a schedule without one is measured by, at a height of 0.3 m [s], and its
        stance as a share of it [-].
    behaviour_settings
        Settings of the behaviours, a part for each.
    actuators
        The motors that it believes to command; None for ideal ones.
    behaviours
        What makes each behaviour, the highest rank first; see docs/add-a-behaviour.md.
    """

    mu: float = setting(0.6, "-", "friction that the controller counts on", low=0.0)
    watch_friction: bool = False
    friction_share: float = setting(
        0.9, "-", "share of the friction that commanded forces may use", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary WalkSettings.friction_share --factor 4 "
        "--task trot --seeds 3`, 2026-11-25: as good from 0.9 to 1",
    )  # fmt: skip
    start: float = setting(
        0.3, "s", "time to stand before the gait begins", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.start --factor 4 "
        "--task gait-flying-trot --seeds 3`, 2026-11-25: as good from 0.075 to 0.3",
    )  # fmt: skip
    clearance: float = setting(
        0.22, "h", "height of the swing over the ground", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.clearance --factor 20 "
        "--task steps-up --seeds 3`, 2026-11-26: as good from 0.22 to 4.4; "
        "3 of 3 fall with 4.4, which may be chance",
    )  # fmt: skip
    ease: float = setting(
        0.55, "-", "share of it over a known plane while the body moves as planned", low=0.0, high=1.0,
        tuned="`surefoot bench ablation --vary WalkSettings.ease --factor 20 "
        "--task trot --seeds 3`, 2026-11-26: as good from 0.55 to 0.55; "
        "without it (`--only ease`) a trot takes 12 to 30 % more work at 0.8 to 1.4 m/s",
    )  # fmt: skip
    horizon: int = setting(
        10, "-", "steps of the MPC", low=1,
        tuned="`surefoot bench ablation --vary WalkSettings.horizon --factor 5 "
        "--task trot --seeds 3`, 2026-11-25: as good from 2 to 10",
    )  # fmt: skip
    steps_per_period: int = setting(
        14, "-", "MPC steps in a cycle of the gait", low=1,
        tuned="`surefoot bench ablation --vary WalkSettings.steps_per_period --factor 5 "
        "--task trot --task gait-flying-trot --seeds 6`, 2026-11-25: as good from 14 to 14",
    )  # fmt: skip
    plan_interval: float = setting(
        0.02, "s", "longest time between plans", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.plan_interval --factor 5 "
        "--task gait-flying-trot --seeds 3`, 2026-11-25: as good from 0.02 to 0.1",
    )  # fmt: skip
    body_stiffness: float = setting(
        2.0, "sqrt(g / h)", "natural frequency of the feedback on the body's plan", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.body_stiffness --factor 20 "
        "--task fast --seeds 3`, 2026-11-25: as good from 0.1 to 2",
    )  # fmt: skip
    swing_stiffness: float = setting(
        8.0, "sqrt(g / h)", "natural frequency of the feedback on feet in the air", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.swing_stiffness --factor 5 "
        "--task trot --seeds 3`, 2026-11-25: as good from 1.6 to 8",
    )  # fmt: skip
    normal_min: float = setting(
        0.02, "m g", "least normal force of a stance foot", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.normal_min --factor 5 "
        "--task shoved --seeds 3`, 2026-11-25: as good from 0.004 to 0.02",
    )  # fmt: skip
    normal_max: float = setting(
        1.5, "m g", "largest normal force of a stance foot", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.normal_max --factor 20 "
        "--task turn --seeds 6`, 2026-11-26: as good from 1.5 to 30; "
        "30 takes less work on `fast`",
    )  # fmt: skip
    watch_load: bool = True
    ramp: float = setting(
        0.17, "sqrt(h / g)", "time of the normal force's ramp after touchdown and before lift-off", low=0.0,
        tuned="`surefoot bench ablation --vary WalkSettings.ramp --factor 20 "
        "--task turn --seeds 6`, 2026-11-26: as good from 0.0085 to 0.17; "
        "a twentieth takes less work on `fast`",
    )  # fmt: skip
    gait_lead: float = setting(
        1.15, "-", "multiple of its speed that the gait must be fit for before the body goes faster", low=1.0
    )
    catch_clearance: float = setting(
        0.5, "-", "height of the swings over the usual one while a body is caught: they are quick", low=0.0
    )
    held_stiffness: float = setting(
        3.0, "sqrt(g / h)", "natural frequency of joints outside the legs, which hold their pose", low=0.0
    )
    flying_weight: float = setting(
        10.0, "-", "factor on the swing-foot weight while no foot stands, so that legs are not swung", low=0.0
    )
    horizon_period: float = setting(
        0.4, "s", "cycle that the horizon of a schedule without one is measured by, at a height of 0.3 m",
        low=1e-3,
    )  # fmt: skip
    horizon_stance: float = setting(
        0.55, "-", "stance of such a schedule as a share of that cycle", low=0.0, high=1.0
    )
    behaviour_settings: BehaviourSettings = field(default_factory=BehaviourSettings)
    mpc: MpcWeights = field(default_factory=MpcWeights)
    whole_body: TaskWeights = field(default_factory=TaskWeights)
    actuators: Actuators | None = None
    behaviours: tuple[MakeBehaviour, ...] = BEHAVIOURS


@dataclass(frozen=True, kw_only=True)
class WalkCommand(Command):
    """What the walking controller asks for at one step.

    Attributes
    ----------
    planned
        (n,) which feet the gait wants on the ground; `active` are those that push.
    frames
        (n, 3, 3) rotation_world_contact in which the forces are given.
    wanted
        (3,) velocity command after limits and ramp: forward, left, yaw rate.
    targets
        (n, 3) where feet in the air will touch, or last did.
    load
        Values of the channels of `LoadAdaptation`.
    asked_by
        (13,) rank of the behaviour that has got its way with each quantity of
        `surefoot.motion.walking.behaviours.arbiter.LOGGED`; -1 for none.
    """

    planned: BoolArray
    frames: FloatArray
    wanted: FloatArray
    targets: FloatArray
    load: Mapping[str, FloatArray] = field(default_factory=dict)
    asked_by: IntArray = field(default_factory=lambda: np.full(len(LOGGED), -1))

    def rows(self) -> dict[str, Any]:
        """Return planned contacts, wanted velocity, who asked for what, and what is observed of a load."""
        own = {"planned": self.planned, "command": self.wanted, "asked_by": self.asked_by}
        return {**own, **self.load}
