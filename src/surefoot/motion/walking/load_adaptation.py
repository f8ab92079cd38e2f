"""What a walking controller makes of an unknown payload and external wrench.

The payload that `WrenchObserver` finds becomes part of the models of the whole-body controller (inertia of
the base) and of the MPC (mass, inertia, centre of mass, and with it the footholds); the rest of the wrench is
a bias force of the whole-body step, and in the MPC an acceleration that fades over its horizon.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.mechanics import Robot, composite_inertia
from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.control.whole_body import Kinematics, WholeBodyController
from surefoot.motion.estimation.wrench_kernels import point_inertia, tell_wrench
from surefoot.motion.estimation.wrench_observer import FADING, WrenchObserver
from surefoot.motion.walking.body_settings import LOAD
from surefoot.motion.walking.walking_body import BodyPlan


class LoadAdaptation(Remembering):
    """Observes, and changes the models of the MPC and the whole-body controller; see the module.

    Parameters
    ----------
    robot
        As its model says.
    dt
        Time between steps [s].
    mpc, whole_body
        Whose models.
    upright
        (3, 3) rotation from the base's axes to those that the MPC turns; None where they are the same.
    fading
        Time constant with which the MPC lets the rest of the wrench fade [s].

    Attributes
    ----------
    observer
        What it knows.
    shift
        (3,) how far the load moves the centre of mass, base axes [m].
    load
        (4,) mass and first moment that the models have, base axes [kg, kg m].
    laden
        Whether a load has been noticed, see `notice`.
    """

    MEMORY = ("observer", "_torques", "_time", "_pushing", "shift", "rotation", "load", "laden")

    def __init__(
        self, robot: Robot, dt: float, mpc: ConvexMpc, whole_body: WholeBodyController,
        upright: FloatArray | None = None, fading: float = FADING,
    ) -> None:  # fmt: skip
        self.robot, self.dt = robot, dt
        self.observer = WrenchObserver(robot, dt)
        self.mpc, self.whole_body = mpc, whole_body
        mpc.expect(np.zeros(6), fading)
        self.inertia, self.com, _ = composite_inertia(robot, robot.nominal)
        self.upright = np.eye(3) if upright is None else upright
        self.reset()

    @property
    def rows(self) -> dict[str, FloatArray]:
        """The values of the channels: (4,) [kg, kg m], (6,) [N, N m]."""
        return {"load_estimated": self.observer.carried, "wrench_estimated": self.observer.wrench}

    def reset(self) -> None:
        """Forget the load."""
        self._torques: FloatArray | None = None  # of the step that has begun
        self._time, self.shift, self.rotation = 0.0, np.zeros(3), np.eye(3)
        self.load, self.laden = np.zeros(4), False
        self.observer.reset()
        self.whole_body.carry(None)
        self.mpc.carry(self.robot.mass, self.upright @ self.inertia @ self.upright.T)
        self.mpc.expect(np.zeros(6))

    def observe(self, state: RobotState) -> None:
        """Learn from the (finite) state in which the last step has ended."""
        torques, self._torques = self._torques, None
        if torques is None or not 0.5 * self.dt < state.time - self._time < 1.5 * self.dt:
            return  # a step is missing in between
        before = self.whole_body.instant()
        if before.pose[2, 2] < math.cos(LOAD.lean):
            return
        touching = self._pushing if state.contact is None else self._pushing | state.contact
        self.observer.observe(before, state.v, torques, touching, self.load)

    def acted(self, time: float, torques: FloatArray, pushing: BoolArray) -> None:
        """Remember what the next `observe` needs of the step that begins with the command of now.

        Parameters
        ----------
        time
            At its start [s].
        torques
            (joints,) during it [N m].
        pushing
            (n,) which feet may push; kept as it is.
        """
        self._torques = torques - self.whole_body.friction
        self._time, self._pushing = time, pushing

    def notice(self, least: float) -> None:
        """Take note of a load of more than a share of the robot's mass, for good."""
        self.laden |= self.observer.load.mass > least * self.robot.mass

    def update_models(self, body: BodyPlan | None) -> None:
        """Bring the models up to the estimate, and the plan for the (new) centre of mass, not the body's.

        The body itself stays where it is, its centre of mass moves; None before there is a plan.
        """
        mass, load = self.robot.mass, self.observer.load
        total = mass + load.mass
        shift = (load.moment - load.mass * self.com) / total
        # a point mass at r beside the robot's own at c: their inertia about the common centre of mass
        arm = load.place - self.com
        reduced = max(load.mass, 0.0) * mass / total
        inertia = self.inertia + reduced * point_inertia(arm)
        self.whole_body.carry(load)
        self.mpc.carry(total, self.upright @ inertia @ self.upright.T)
        if body is not None:
            moved = shift - self.shift
            body.recentre(moved, self.rotation @ moved)
            self.shift = shift
        self.load = self.observer.carried

    def pull(self, now: Kinematics, base: FloatArray) -> FloatArray:
        """Return the rest of the wrench at a state, and let the MPC count on it.

        `base` (3,) is the place of the base [m]. What is returned is (6,) about it, base axes [N, N m].
        """
        self.rotation = now.rotation.copy()
        on_base, on_com = np.empty(6), np.empty(6)
        tell_wrench(
            self.observer.wrench, LOAD.most, self.observer.wrench_unit,
            now.rotation, base, now.com, on_base, on_com,
        )  # fmt: skip
        self.mpc.expect(on_com)
        return on_base
