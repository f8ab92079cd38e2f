"""The world that all stacks walk in: MuJoCo with real actuators, whole bodies and an estimated state."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from surefoot.base.errors import ProblemError, unknown_name
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.robot.actuators import Actuators, actuators_of
from surefoot.mechanics.terrain import Terrain
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.sensors import SensorModel

Motors: TypeAlias = Actuators | None
ESTIMATORS, ACTUATORS, COLLISIONS = ("inekf", "truth"), ("real", "ideal"), ("full", "feet")


@dataclass(frozen=True)
class Setting:
    """What is real about the world; the default is the hard one.

    Attributes
    ----------
    estimator
        "inekf": the controller is told an estimate from an ordinary IMU, encoders and torques; "truth".
    actuators
        "real": rotor inertia, friction and a torque that falls with speed; "ideal".
    collision
        "full": every link can touch the ground and every other; "feet".
    """

    estimator: str = "inekf"
    actuators: str = "real"
    collision: str = "full"

    def __post_init__(self) -> None:
        for kind, name, known in (
            ("estimator", self.estimator, ESTIMATORS),
            ("actuators", self.actuators, ACTUATORS),
            ("collision", self.collision, COLLISIONS),
        ):
            if name not in known:
                raise ProblemError(unknown_name(kind, name, known))

    def sensors(self, noise: float, heights: bool = True) -> SensorModel | None:
        """Return sensors with a multiple of ordinary noise, None for the truth.

        `heights` says whether a map corrects the estimated height where feet land.
        """
        if self.estimator == "truth":
            return None
        return replace(SensorModel().scaled(noise), heights=heights)

    def world(self, robot: Robot, terrain: Terrain, mu: float, dt: float, motors: Motors) -> MujocoWorld:
        """Return the world of a true robot on a true ground, with motors."""
        return MujocoWorld(robot, terrain, mu, dt, collision=self.collision, actuators=motors or "ideal")

    def motors(self, robot: Robot) -> Motors:
        """Return the motors of a robot as its documents have it, None for ideal ones."""
        return actuators_of(robot, self.actuators)


IDEAL = Setting("truth", "ideal", "feet")
HARD = Setting()


def true_robot(
    robot: Robot, mass_factor: float = 1.0, payload: float = 0.0, at: tuple[float, float, float] = (0, 0, 0)
) -> Robot:
    """Return a robot that is heavier than its documents say, and carries a point mass.

    Parameters
    ----------
    robot
        As documented.
    mass_factor
        Of the mass and inertia of every link.
    payload
        Point mass fixed to the base [kg].
    at
        Where, in the base's axes from its origin [m].
    """
    import pinocchio

    model = robot.model.copy()
    for k in range(model.njoints):
        link = model.inertias[k]
        model.inertias[k] = pinocchio.Inertia(mass_factor * link.mass, link.lever, mass_factor * link.inertia)
    if payload > 0.0:
        load = pinocchio.Inertia(payload, np.array(at, dtype=np.float64), np.zeros((3, 3)))
        model.inertias[1] = model.inertias[1] + load
    out = copy.copy(robot)
    out.model, out.data = model, model.createData()
    out.__dict__.pop("mass", None)  # it is computed when asked for
    return out
