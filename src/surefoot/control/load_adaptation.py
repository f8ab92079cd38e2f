"""What a walking controller makes of a payload and of an external wrench that it was not told.

The payload that `WrenchObserver` finds becomes part of the models of the whole-body controller (inertia of
the base) and of the MPC (mass, inertia, centre of mass, and with it the footholds); the rest of the wrench is
a bias force of the whole-body step, and in the MPC an acceleration that fades over its horizon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, real_number
from surefoot.control.controller import RobotState
from surefoot.control.mpc import ConvexMpc
from surefoot.control.walking_body import BodyPlan
from surefoot.control.whole_body import Kinematics, WholeBodyController
from surefoot.estimation.wrench_kernels import point_inertia, tell_wrench
from surefoot.estimation.wrench_observer import Instant, Load, ObserverSettings, WrenchObserver
from surefoot.log.channels import CHANNELS
from surefoot.robot import Robot


@dataclass(frozen=True)
class LoadSettings:
    """What is made of an unknown load.

    Attributes
    ----------
    observer
        See `ObserverSettings`.
    load, wrench
        Share of the payload, and of the rest of the wrench, that the controllers are told; zero to observe
        and do nothing.
    most
        Bound on the rest that they are told, along each axis: force over m g, moment over m g h. More of it
        would make feet slip where the ground gives less than is believed.
    lean
        The observer stands still while the base leans further than this: the robot falls [rad].
    """

    observer: ObserverSettings = field(default_factory=ObserverSettings)
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
    """Observes, and tells the MPC and the whole-body controller; see the module.

    Parameters
    ----------
    robot
        As its model says; with point feet, else nothing is observed.
    dt
        Time between steps [s].
    mpc, whole_body
        Whom to tell.
    settings
        See `LoadSettings`; None to observe nothing.

    Attributes
    ----------
    observer
        What it knows; None if it observes nothing.
    channels, rows
        What it adds to a log, and the values: (4,) [kg, kg m], (6,) [N, N m].
    """

    def __init__(
        self,
        robot: Robot,
        dt: float,
        mpc: ConvexMpc,
        whole_body: WholeBodyController,
        settings: LoadSettings | None,
    ) -> None:
        import pinocchio

        self.robot, self.dt, self.settings = robot, dt, settings or LoadSettings()
        self.observer: WrenchObserver | None = None
        if settings is not None and not any(foot.flat for foot in robot.feet):
            self.observer = WrenchObserver(robot, dt, settings.observer)
            self._most = settings.most * self.observer.wrench_unit
        names = () if self.observer is None else ("load_estimated", "wrench_estimated")
        self.channels = tuple(CHANNELS[name] for name in names)
        self._mpc, self._whole_body = mpc, whole_body
        mpc.fading = self.settings.observer.fading
        self._upright = math.cos(self.settings.lean)
        data = robot.model.createData()
        pinocchio.ccrba(robot.model, data, robot.nominal, np.zeros(robot.model.nv))
        base = data.oMi[1]
        rotation = np.array(base.rotation)
        self._inertia = rotation.T @ np.array(data.Ig.inertia) @ rotation
        self._com = rotation.T @ (np.array(data.com[0]) - np.array(base.translation))
        self.reset()

    def reset(self) -> None:
        """Forget the load."""
        self._before: Instant | None = None
        self._time, self._shift = 0.0, np.zeros(3)
        self._carried: Load | None = None
        self.rows: dict[str, FloatArray] = {}
        if self.observer is None:
            return
        self.observer.reset()
        self._look()
        self._whole_body.carry(None)
        self._mpc.carry(self.robot.mass, self._inertia)
        self._whole_body.outside[:] = self._mpc.outside[:] = 0.0

    def observe(self, state: RobotState) -> None:
        """Learn from the (finite) state in which the last step has ended."""
        before, self._before = self._before, None
        if self.observer is None or before is None or before.pose[2, 2] < self._upright:
            return
        if not 0.5 * self.dt < state.time - self._time < 1.5 * self.dt:
            return  # a step is missing in between
        touching = self._pushing if state.contact is None else self._pushing | state.contact
        if self.observer.observe(before, state.v, self._torques, touching, self._carried):
            self._look()

    def _look(self) -> None:
        """Take what the observer knows now."""
        assert self.observer is not None
        load, self._wrench = self.observer.load, self.observer.wrench
        moments = np.array([load.mass, *load.moment])
        self.rows = {"load_estimated": moments, "wrench_estimated": self._wrench}

    def acted(self, time: float, v: FloatArray, torques: FloatArray, pushing: BoolArray) -> None:
        """Remember what the next `observe` needs of the step that begins.

        Parameters
        ----------
        time
            At its start [s].
        v
            (nv,) velocity then [m/s, rad/s].
        torques
            (joints,) during it [N m].
        pushing
            (n,) which feet may push.
        """
        if self.observer is None:
            return
        self._torques = torques - self._whole_body.friction
        self._time, self._pushing = time, pushing.copy()
        self._before = self._whole_body.instant(v)

    def tell(self, body: BodyPlan | None) -> None:
        """Bring the models up to the estimate, and the plan for the (new) centre of mass, not the body's.

        The body itself stays where it is, its centre of mass moves; None before there is a plan.
        """
        if self.observer is None:
            return
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
        self._carried = load

    def pull(self, now: Kinematics, base: FloatArray) -> None:
        """Tell the rest of the wrench at a state, with (3,) the place of the base [m]."""
        if self.observer is None:
            return
        self._rotation = now.rotation
        tell_wrench(
            self.settings.wrench * self._wrench, self._most, now.rotation, base, now.com,
            self._whole_body.outside, self._mpc.outside,
        )  # fmt: skip
