"""How a robot walks, and what its walking controller asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.mechanics import Actuators
from surefoot.motion.control.controller import Command
from surefoot.motion.control.mpc import MpcWeights
from surefoot.motion.control.whole_body import TaskWeights
from surefoot.motion.walking.behaviours import BEHAVIOURS, MakeBehaviour
from surefoot.motion.walking.behaviours.arbiter import LOGGED


@dataclass(frozen=True)
class WalkSettings:
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
    actuators
        The motors that it believes to command; None for ideal ones.
    behaviours
        What makes each behaviour, the highest rank first; see docs/add-a-behaviour.md.
    """

    mu: float = 0.6
    watch_friction: bool = False
    friction_share: float = 0.9
    start: float = 0.3
    clearance: float = 0.22
    ease: float = 0.55
    horizon: int = 10
    steps_per_period: int = 14
    plan_interval: float = 0.02
    body_stiffness: float = 2.0
    swing_stiffness: float = 8.0
    normal_min: float = 0.02
    normal_max: float = 1.5
    watch_load: bool = True
    ramp: float = 0.17
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
