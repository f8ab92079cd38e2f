"""Experiments with the Go2: standing, trotting, and one controller on grounds of two frictions."""

from __future__ import annotations

from functools import cache

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.control.controller import Controller
from surefoot.control.standing import StandingController
from surefoot.control.standing_plan import StandingPlan
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.errors import SimulationError
from surefoot.experiments.experiment import Measured, MeasuredQuantity, WorldExperiment
from surefoot.experiments.ground import hard, slid_down
from surefoot.log import Ending, Log
from surefoot.robot import Robot, load_robot, place
from surefoot.simulation.run import run
from surefoot.simulation.scenario import START_DEPTH, Scenario
from surefoot.simulation.worlds import make_world
from surefoot.spatial import GRAVITY
from surefoot.terrain import FlatTerrain, SlopeTerrain, Terrain

ROBOT, MU = "go2", 0.8
STAND, TROT, SPEED = 1.0, 1.5, 0.4
"""Durations [s], and the trot's commanded speed [m/s]."""
DEGREES, GRIP, ICE, HOLD, SLID = 20.0, 0.8, 0.3, 0.5, 0.1
"""Slope [deg], two frictions of the ground, how long on each [s]; the controller believes in `GRIP`."""


@cache
def _robot() -> Robot:
    return load_robot(ROBOT)


def _log(
    world: str, dt: float, controller: Controller, terrain: Terrain, q: FloatArray, seconds: float, mu: float
) -> Log:
    """Return the log of a run that reached its end."""
    made = make_world(world, _robot(), terrain, mu, dt=dt, **hard(world, dt))
    try:
        log = run(made, controller, Scenario(seconds, mu, start=q, depth=START_DEPTH))
    finally:
        getattr(made, "close", lambda: None)()  # of those with a process of their own
    if log.facts["outcome"] != Ending.DONE:
        now = float(log["time"][-1])
        raise SimulationError(f"robot {log.facts['outcome']} and its motion", now, dt, "base", 0.0)
    return log


def _stander(dt: float, terrain: Terrain, q: FloatArray) -> StandingController:
    return StandingController(_robot(), StandingPlan(_robot(), terrain, q, []), terrain, q, MU, dt)


def _momentum(log: Log, steps: FloatArray) -> FloatArray:
    """Return the robot's linear momentum [kg m/s] before the given steps: (k, 3)."""
    import pinocchio

    robot = _robot()
    data, out = robot.model.createData(), np.empty((len(steps), 3))
    for row, k in enumerate(steps):
        pinocchio.centerOfMass(robot.model, data, log["q"][k], log["v"][k])
        out[row] = robot.mass * np.array(data.vcom[0])
    return out


def _balance(log: Log, dt: float, first: int, terrain: Terrain) -> tuple[FloatArray, FloatArray]:
    """Return the ground's mean force [N] from a step to the last one, and what momentum makes of it: (3,).

    Both in the frame of a plane terrain.
    """
    last = len(log["time"]) - 1
    forces = log["forces"][first:last].sum(axis=(0, 1)) / (last - first)
    before, after = _momentum(log, np.array([first, last]))
    weight = np.array([0.0, 0.0, _robot().mass * GRAVITY])
    asked = weight + (after - before) / (dt * (last - first))
    return forces, terrain.frame([0.0, 0.0]).T @ asked


# --- stand


def _stand(world: str, dt: float) -> Measured:
    robot, terrain = _robot(), FlatTerrain()
    q = place(robot, terrain)
    log = _log(world, dt, _stander(dt, terrain, q), terrain, q, STAND, MU)
    got, balance = _balance(log, dt, round(0.5 * STAND / dt), terrain)
    loads = log["forces"][-1, :, 2]
    pressure = loads @ log["contact_positions"][-1, :, :2] / loads.sum()
    ahead = pressure - robot.com(log["q"][-1])[:2]
    return (
        MeasuredQuantity("mean load / what momentum asks", "", got[2] / balance[2], 1.0),
        MeasuredQuantity("centre of pressure ahead of the weight", "m", ahead[0], 0.0, 0.05),
    )


# --- trot


def _trot(world: str, dt: float) -> Measured:
    robot, terrain, h = _robot(), FlatTerrain(), 0.5 * dt  # a trot wants a controller at a kilohertz
    command = VelocityCommand.constant(SPEED)
    controller = WalkingController(robot, command, "trot", terrain, WalkSettings(mu=MU), h)
    log = _log(world, h, controller, terrain, place(robot, terrain), TROT, MU)
    got, balance = _balance(log, h, round(0.5 / h), terrain)
    weight = robot.mass * GRAVITY
    return (
        MeasuredQuantity("mean load / what momentum asks", "", got[2] / balance[2], 1.0),
        MeasuredQuantity(
            "forward force - what momentum asks", "m g", (got[0] - balance[0]) / weight, 0.0, 0.01
        ),
    )


# --- friction


def _friction(world: str, dt: float) -> Measured:
    robot, terrain = _robot(), SlopeTerrain(DEGREES)
    q = place(robot, terrain)
    held = _log(world, dt, _stander(dt, terrain, q), terrain, q, HOLD, GRIP)
    slid = _log(world, dt, _stander(dt, terrain, q), terrain, q, SLID, ICE)
    half = len(held["time"]) // 2
    feet = held["contact_positions"]
    slip = float(np.linalg.norm(feet[-1] - feet[half], axis=1).mean())
    got, asked = _balance(held, dt, half, terrain)
    fast = slid["forces"][len(slid["time"]) // 2 :]
    used = np.linalg.norm(fast[..., :2], axis=-1).sum() / fast[..., 2].sum()
    scale = float(slid_down(np.array(HOLD), DEGREES, ICE))
    return (
        MeasuredQuantity(f"slip of the feet at mu {GRIP:g}", "m", slip, 0.0, scale),
        MeasuredQuantity(f"pull at mu {GRIP:g} / what momentum asks", "", got[0] / asked[0], 1.0),
        MeasuredQuantity(f"friction used at mu {ICE:g}", "", used, ICE),
    )


ROBOTS = (
    WorldExperiment(
        "stand", "The Go2 stands on its controller for a second.",
        "its mean load in the second half against weight and change of momentum, and the centre of pressure "
        "against the weight's place",
        _stand,
    ),
    WorldExperiment(
        "trot", "The Go2 trots at 0.4 m/s; half the step.",
        "the ground's mean force from 0.5 s on against weight and change of momentum, upwards and forwards",
        _trot,
    ),
    WorldExperiment(
        "friction", "The Go2 stands on a slope of 20 degrees; its controller believes in friction 0.8.",
        "on friction 0.8, from 0.25 s to 0.5 s, the feet's slip against none, and their pull against m g sin "
        "and the change of momentum; on 0.3, from 0.05 s to 0.1 s, tangential over normal forces against 0.3",
        _friction,
    ),
)  # fmt: skip
