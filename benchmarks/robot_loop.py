"""`surefoot.RobotLoop` in somebody's MuJoCo model of a robot, whose every contact force is audited.

    python -m benchmarks.robot_loop unitree_robots/go2/go2.xml [--seeds 20] [--feet FL,FR,RL,RR]

The file is taken as it is (Unitree's for its Go2 is in github.com/unitreerobotics/unitree_mujoco): its step,
motors and their limits, its contacts; a plane is put under it. The loop runs every 2 ms, reads an IMU and
encoders with noise, and its targets act 4 ms late. The robot stands up from its belly, walks at 0.5 m/s,
is pushed by 150 N for 0.1 s in a direction of its own for each seed, or walks up a slope of 10 degrees of
which it is not told, stands still, and sits down.
"""

from __future__ import annotations

import argparse
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.base.spatial import quaternion_from_rotation, rotation_from_quaternion
from surefoot.motion.control.controller import JointTargets
from surefoot.worlds.mujoco.mujoco_world import import_mujoco, pinocchio_state
from surefoot.worlds.running.motor_robot import lying
from surefoot.worlds.running.sensors import SensorModel, Sensors

SPEED, PUSH, PUSHED, SLOPE = 0.5, 150.0, 0.1, np.radians(10.0)
"""Of the walk [m/s], of the push [N] and its length [s], of the ground [rad]."""
DELAY, MU = 0.004, 0.4
"""From targets to motors [s]; friction that is believed in [-], as Unitree's feet have it."""
STAGES = (("", 0.3), ("stand", 3.5), ("walk", 4.0), ("stand", 2.0), ("sit", 2.5))
"""Modes of the loop, and how long each [s]."""
AT = 5.0
"""When it is pushed [s]."""


def model_of(path: Path, slope: float) -> Any:
    """Return the file's MjModel on a plane that rises forward by so much [rad]."""
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(path))
    w, y = np.cos(0.5 * slope), -np.sin(0.5 * slope)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], quat=[w, 0.0, y, 0.0])
    return spec.compile()


class LoopTrial:
    """A robot of the file's in its own physics, and a loop that moves it."""

    def __init__(self, model: Any, robot: sf.Robot, slope: float, seed: int) -> None:
        self.mujoco, self.model = import_mujoco(), model
        self.data, self.robot = self.mujoco.MjData(model), robot
        self.dt = float(model.opt.timestep)
        self.loop = sf.RobotLoop(robot, self.dt, mu=MU, terrain="blind" if slope else None)
        self.sensors = Sensors(SensorModel(), robot, self.dt, seed)
        joints = [model.joint(name).id for name in robot.joint_names]
        self._motor = [int(np.flatnonzero(model.actuator_trnid[:, 0] == j)[0]) for j in joints]
        self._late: deque[JointTargets] = deque(maxlen=1 + round(DELAY / self.dt))
        q = lying(robot, sf.SlopeTerrain(np.degrees(slope)))
        self.data.qpos[:] = [*q[:3], q[6], *q[3:6], *q[7:]]
        self._error = rotation_from_quaternion(self.sensors.attitude_at_start(robot.nominal)[3:7])

    def step(self, force: np.ndarray) -> None:
        """Read, let the loop decide, and go on by a step of the file's under a (3,) force [N] on the base."""
        data, model, motor = self.data, self.model, self._motor
        q, v = pinocchio_state(data.qpos, data.qvel)
        tilted = quaternion_from_rotation(self._error @ rotation_from_quaternion(q[3:7]))
        given = self.sensors.torques(data.actuator_force[motor])
        self._late.append(
            self.loop.step(sf.RobotReadings(data.time, tilted, *self.sensors.read(q, v), given))
        )
        self.loop.plan_ahead()  # as on the wire
        data.ctrl[motor] = self._late[0].torques(q[7:], v[6:])
        data.xfrc_applied[model.jnt_bodyid[0], :3] = force
        self.mujoco.mj_step(model, data)


def outing(path: Path, robot: sf.Robot, seed: int, slope: float, push: float) -> tuple[bool, str]:
    """Return whether an outing went well, and what is to be said of it."""
    trial = LoopTrial(model_of(path, slope), robot, slope, seed)
    angle = 0.25 * np.pi * seed
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    loop, data = trial.loop, trial.data
    loop.steer([SPEED, 0.0, 0.0])
    walked = 0.0
    with sf.record(trial.model, data) as log:
        for goal, seconds in STAGES:
            if goal:
                try:
                    loop.go(goal)
                except sf.ProblemError as error:
                    return False, f"{loop.fault}; {error}"
            begin = data.qpos[:3].copy()
            for _ in range(round(seconds / trial.dt)):
                now = AT <= data.time < AT + PUSHED
                trial.step(push * way * now)
            walked = max(walked, float(np.linalg.norm(data.qpos[:3] - begin)))
    report = sf.audit_log(log, robot)
    good = not loop.fault and report.verdict == "lawful" and loop.settled
    return good, f"walked {walked:.2f} m, {loop.mode}, audit: {report.sentence} {loop.fault}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print what came of every outing, and how many went well."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", type=Path)
    parser.add_argument("--feet", default="FL,FR,RL,RR")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    given = parser.parse_args(arguments)
    robot = sf.load_robot(str(given.model), feet=given.feet.split(","))
    for name, slope, push in (("a push of 150 N", 0.0, PUSH), ("a slope of 10 degrees", SLOPE, 0.0)):
        count = 0
        for seed in range(given.first, given.first + given.seeds):
            good, said = outing(given.model, robot, seed, slope, push)
            count += good
            print(f"{name}, seed {seed}: {'well' if good else 'NOT well'}, {said}", flush=True)
        print(f"{name}: {count} of {given.seeds}")


if __name__ == "__main__":
    main()
