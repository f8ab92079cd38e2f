"""What a walking controller makes of an unknown payload and external wrench.

The payload that `WrenchObserver` finds becomes part of the models of the whole-body controller (inertia of
the base) and of the MPC (mass, inertia, centre of mass, and with it the footholds); the rest of the wrench is
a bias force of the whole-body step, and in the MPC an acceleration that fades over its horizon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.control.controller import RobotState
from surefoot.control.mpc import ConvexMpc
from surefoot.control.walking_body import BodyPlan
from surefoot.control.whole_body import Kinematics, WholeBodyController
from surefoot.estimation.wrench_kernels import point_inertia, tell_wrench
from surefoot.estimation.wrench_observer import FADING, Load, WrenchObserver
from surefoot.robot import Robot
from surefoot.robot.centroidal import composite_inertia


@dataclass(frozen=True)
class LoadSettings:
    """What is made of an unknown load.

    Attributes
    ----------
    load, wrench
        Share of the payload, and of the rest of the wrench, that the controllers get; zero to observe and do
        nothing.
    most
        Bound on the rest that they get, along each axis: force over m g, moment over m g h. More of it would
        make feet slip where the ground gives less than is believed.
    lean
        The observer stands still while the base leans further than this: the robot falls [rad].
    """

    load: float = 1.0
    wrench: float = 1.0
    most: float = 0.1
    lean: float = 0.8

    def __post_init__(self) -> None:
        for name in ("load", "wrench"):
            real_number(name, getattr(self, name), low=0.0, high=1.0)
        real_number("most", self.most, low=0.0)
        real_number("lean", self.lean, low=0.0, high=math.pi)


class LoadAdaptation:
    """Observes, and changes the models of the MPC and the whole-body controller; see the module.

    Parameters
    ----------
    robot
        As its model says; with point feet.
    dt
        Time between steps [s].
    mpc, whole_body
        Whose models.
    settings
        See `LoadSettings`.

    Attributes
    ----------
    observer
        What it knows.
    """

    def __init__(
        self,
        robot: Robot,
        dt: float,
        mpc: ConvexMpc,
        whole_body: WholeBodyController,
        settings: LoadSettings,
    ) -> None:
        self.robot, self.dt, self.settings = robot, dt, settings
        self.observer = WrenchObserver(robot, dt)
        self._mpc, self._whole_body = mpc, whole_body
        mpc.fading = FADING
        self._inertia, self._com, _ = composite_inertia(robot, robot.nominal)
        self.reset()

    @property
    def rows(self) -> dict[str, FloatArray]:
        """The values of the channels: (4,) [kg, kg m], (6,) [N, N m]."""
        load = self.observer.load
        return {
            "load_estimated": np.array([load.mass, *load.moment]),
            "wrench_estimated": self.observer.wrench,
        }

    def reset(self) -> None:
        """Forget the load."""
        self._acting = False
        self._time, self._shift = 0.0, np.zeros(3)
        self._carried = np.zeros(4)
        self.observer.reset()
        self._whole_body.carry(None)
        self._mpc.carry(self.robot.mass, self._inertia)
        self._whole_body.outside[:] = self._mpc.outside[:] = 0.0

    def observe(self, state: RobotState) -> None:
        """Learn from the (finite) state in which the last step has ended."""
        acting, self._acting = self._acting, False
        if not acting:
            return
        before = self._whole_body.instant()
        if before.pose[2, 2] < math.cos(self.settings.lean):
            return
        if not 0.5 * self.dt < state.time - self._time < 1.5 * self.dt:
            return  # a step is missing in between
        touching = self._pushing if state.contact is None else self._pushing | state.contact
        self.observer.observe(before, state.v, self._torques, touching, self._carried)

    def acted(self, time: float, torques: FloatArray, pushing: BoolArray) -> None:
        """Remember what the next `observe` needs of the step that begins with the command of now.

        Parameters
        ----------
        time
            At its start [s].
        torques
            (joints,) during it [N m].
        pushing
            (n,) which feet may push.
        """
        self._torques = torques - self._whole_body.friction
        self._time, self._pushing = time, pushing.copy()
        self._acting = True

    def tell(self, body: BodyPlan | None) -> None:
        """Bring the models up to the estimate, and the plan for the (new) centre of mass, not the body's.

        The body itself stays where it is, its centre of mass moves; None before there is a plan.
        """
        share, mass, load = self.settings.load, self.robot.mass, self.observer.load
        load = Load(share * load.mass, share * load.moment, load.place)
        total = mass + load.mass
        shift = (load.moment - load.mass * self._com) / total
        # a point mass at r beside the robot's own at c: their inertia about the common centre of mass
        arm = load.place - self._com
        reduced = max(load.mass, 0.0) * mass / total
        inertia = self._inertia + reduced * point_inertia(arm)
        self._whole_body.carry(load)
        self._mpc.carry(total, inertia)
        if body is not None:
            moved = shift - self._shift
            body.height += float(moved[2])
            body.position += self._rotation @ moved
            self._shift = shift
        self._carried = np.array([load.mass, *load.moment])

    def pull(self, now: Kinematics, base: FloatArray) -> None:
        """Hand on the rest of the wrench at a state, with (3,) the place of the base [m]."""
        self._rotation = now.rotation
        tell_wrench(
            self.settings.wrench * self.observer.wrench, self.settings.most * self.observer.wrench_unit,
            now.rotation, base, now.com, self._whole_body.outside, self._mpc.outside,
        )  # fmt: skip
