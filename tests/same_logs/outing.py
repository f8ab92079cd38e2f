"""Twenty seconds of `sf.RobotLoop` in a MuJoCo world, on public names alone; run as a process of its own.

    PYTHONPATH=TREE/src python -m tests.same_logs.outing LOG.npz

The robot sinks to the ground with its joints damped, stands up, walks, turns, is pushed, loses three in ten
readings, walks lower with its nose up, stands, sits and lies down. Sensors are noisy and biased, their random
numbers seeded; targets act 4 ms late.
"""

from __future__ import annotations

import sys
from collections import defaultdict, deque
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import surefoot as sf

Array = NDArray[np.float64]
DT, LATE, MU = 0.002, 4, 0.6
"""Of the loop [s]; from targets to motors, in the world's steps of 1 ms; friction."""
IMU, ENCODERS = (3e-3, 0.03), (3e-4, 0.03)
"""White noise of gyro [rad/s] and accelerometer [m/s²], of angles [rad] and speeds [rad/s]."""
UP = np.array([0.0, 0.0, 9.81])


class Stage(NamedTuple):
    """A part of the outing.

    Attributes
    ----------
    seconds
        Its length [s].
    goal
        Mode that is asked for at its start; empty for the one before.
    velocity, posture
        As `RobotLoop.steer` takes them.
    loss
        Share of the readings that do not come.
    push
        (3,) force on the base in its first tenth of a second [N].
    """

    seconds: float
    goal: str = ""
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    posture: tuple[float, float, float] = (0.0, 0.0, 0.0)
    loss: float = 0.0
    push: tuple[float, float, float] = (0.0, 0.0, 0.0)


STAGES = (
    Stage(1.0),
    Stage(3.4, "stand"),
    Stage(2.0, "walk", (0.5, 0.0, 0.0)),
    Stage(1.5, "", (0.4, 0.0, 0.5), push=(40.0, 80.0, 0.0)),
    Stage(2.0, "", (0.5, 0.0, 0.0), loss=0.3),
    Stage(2.0, "", (0.4, 0.1, 0.0), (-0.05, -0.12, 0.02)),
    Stage(2.2, "stand"),
    Stage(0.8, "", posture=(0.02, 0.05, 0.0), push=(0.0, -60.0, 0.0)),
    Stage(2.4, "sit"),
    Stage(2.7, "lie"),
)
"""Twenty seconds together."""


class Sensors:
    """What IMU and encoders say of a world's motion; the accelerometer differentiates the base's velocity."""

    def __init__(self, joints: int, seed: int) -> None:
        self.random, self.joints = np.random.default_rng(seed), joints
        self.gyro_bias, self.pull_bias = 5e-3 * self.random.normal(size=3), 0.05 * self.random.normal(size=3)
        self.zeros = 1e-3 * self.random.normal(size=joints)
        self.before: Array | None = None

    def read(self, time: float, q: Array, v: Array, torques: Array) -> sf.RobotReadings:
        """Return the readings at a time [s], `DT` after the last."""
        noise, turn = self.random.normal(size=6 + 2 * self.joints), rotation(q[3:7])
        moving = turn @ v[:3]
        rate = np.zeros(3) if self.before is None else (moving - self.before) / DT
        self.before = moving
        gyro = v[3:6] + self.gyro_bias + IMU[0] * noise[:3]
        pull = turn.T @ (rate + UP) + self.pull_bias + IMU[1] * noise[3:6]
        angles = q[7:] + self.zeros + ENCODERS[0] * noise[6 : 6 + self.joints]
        speeds = v[6:] + ENCODERS[1] * noise[6 + self.joints :]
        return sf.RobotReadings(time, q[3:7].copy(), gyro, pull, angles, speeds, torques.copy())


def rotation(quaternion: Array) -> Array:
    """Return the (3, 3) rotation of (4,) x, y, z, w."""
    x, y, z, w = quaternion
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def named(holder: Any, *names: str) -> Any:
    """Return the first attribute that there is: revisions call some things by other names."""
    return next(getattr(holder, name) for name in names if hasattr(holder, name))


def measured(world: Any) -> tuple[Array, Array]:
    """Return the world's q and v."""
    q, v = named(world, "q_v", "state")()
    return np.array(q), np.array(v)


class Outing:
    """A Go2 in its world, the loop that moves it, and rows of what both did."""

    def __init__(self) -> None:
        self.robot = sf.load_robot("go2")
        self.world = sf.MujocoWorld(
            self.robot, sf.FlatTerrain(), MU, 1e-3, collision="full", actuators="real"
        )
        self.loop = sf.RobotLoop(self.robot, DT, mu=MU)
        self.world.reset(sf.place(self.robot, sf.FlatTerrain()))
        self.sensors, self.random = Sensors(self.robot.joints, 0), np.random.default_rng(1)
        self.torques, self.late = np.zeros(self.robot.joints), deque[Any](maxlen=LATE + 1)
        self.rows, self.count = defaultdict[str, list[Any]](list), 0

    def stage(self, stage: Stage) -> None:
        """Make one part of the outing."""
        self.loop.steer(stage.velocity, stage.posture)
        if stage.goal:
            self.loop.go(stage.goal)
        for k in range(round(stage.seconds / DT)):
            self.step(stage.loss, np.array(stage.push) if k * DT < 0.1 else None)

    def step(self, loss: float, push: Array | None) -> None:
        """Read, let the loop answer, and go on to the next reading."""
        q, v = measured(self.world)
        readings = self.sensors.read(self.count * DT, q, v, self.torques)
        targets = self.loop.step(None if self.random.random() < loss else readings)
        self.note(q, v, targets)
        for _ in range(round(DT / self.world.dt)):
            self.late.append(targets)
            q, v = measured(self.world)
            self.world.step(self.late[0].torques(q[7:], v[6:]), push)
        self.torques = np.array(self.world.applied)
        self.count += 1

    def note(self, q: Array, v: Array, targets: Any) -> None:
        """Add a row: NaN for what a mode without balance does not say."""
        loop, robot = self.loop, self.robot
        estimate, command = named(loop, "estimate", "state"), loop.command
        row: dict[str, Any] = {
            "time": self.count * DT, "q": q, "v": v, "torques": self.torques,
            "mode": loop.mode.name, "settled": bool(loop.settled),
            "fault": str(loop.fault), "targets": np.stack([np.asarray(part) for part in targets]),
            "q_estimated": np.full(robot.model.nq, np.nan) if estimate is None else estimate.q,
            "v_estimated": np.full(robot.model.nv, np.nan) if estimate is None else estimate.v,
            "torques_commanded": np.full(robot.joints, np.nan) if command is None else command.torques,
            "forces_commanded": np.full((len(robot.feet), 3), np.nan) if command is None else command.forces,
        }  # fmt: skip
        for name, value in row.items():
            self.rows[name].append(np.array(value))


def main(path: Path) -> None:
    """Make the outing and write its rows."""
    outing = Outing()
    for stage in STAGES:
        outing.stage(stage)
    # a mode that was refused, or a fall, would be as equal in both revisions and prove little
    reached = outing.loop.mode.name == "LIE" and not outing.loop.fault
    # text has the width of its longest row: fixed here, so that a shape says nothing of the words
    arrays = {name: np.array(rows) for name, rows in outing.rows.items()}
    np.savez_compressed(path, fact_reached=np.array(reached), **arrays)  # type: ignore[arg-type]


if __name__ == "__main__":
    main(Path(sys.argv[1]))
