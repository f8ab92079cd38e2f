"""How well a walking robot knows its state, and what that costs.

Run: python -m benchmarks.state_estimate [--quick]. Robots walk on what the contact-aided invariant
filter tells their controllers, from IMU, encoders and contacts found in the torques; errors are those
against the truth.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from rich.console import Console
from rich.table import Table

from surefoot.arrays import BoolArray, FloatArray
from surefoot.audit import WalkSummary, summarise_walk
from surefoot.control.walking import WalkingController, WalkSettings
from surefoot.control.walking_body import VelocityCommand
from surefoot.estimation import InvariantEkf, Reading, StateEstimator
from surefoot.robot import load_robot
from surefoot.simulation.run import Ice, Push, Scenario, run
from surefoot.simulation.sensors import SensorModel
from surefoot.simulation.walk_terrain import start_pose
from surefoot.simulation.worlds import make_world
from surefoot.spatial import GRAVITY
from surefoot.terrain import read_terrain

ORDINARY = SensorModel()
MISSED = replace(ORDINARY, touch=replace(ORDINARY.touch, missed=0.05, false=0.2))
UNMAPPED = replace(ORDINARY, heights=False)
MU = 0.6


@dataclass(frozen=True)
class Walk:
    """A walk that is estimated."""

    name: str
    robot: str = "go2"
    world: str = "mujoco"
    terrain: str = "flat"
    gait: str = "trot"
    speed: float = 0.5
    sensors: SensorModel = ORDINARY
    pushes: tuple[Push, ...] = ()
    ice: tuple[Ice, ...] = ()

    def summary(self, seed: int, duration: float) -> WalkSummary:
        """Return what the walk with a seed came to."""
        robot, ground = load_robot(self.robot), read_terrain(self.terrain)
        command = VelocityCommand.constant(self.speed, 0.0, 0.0)
        controller = WalkingController(robot, command, self.gait, ground, WalkSettings(mu=MU))
        scenario = Scenario(
            duration, MU, self.pushes, self.ice, seed, start=start_pose(robot, ground), sensors=self.sensors
        )
        return summarise_walk(run(make_world(self.world, robot, ground, MU), controller, scenario))


WALKS = (
    Walk("go2, MuJoCo"),
    Walk("go2, rigid", world="rigid"),
    Walk("go2, 1 m/s", speed=1.0),
    Walk("go2, 15 degree slope, 0.4 m/s", terrain="slope:15", speed=0.4),
    Walk("go2, stairs of 8 cm, 0.3 m/s", terrain="stairs:0.08,0.3", speed=0.3),
    Walk(
        "go2, 100 N for 0.1 s, then mu 0.2", pushes=(Push(2.0, (0.0, 100.0, 0.0), 0.1),), ice=(Ice(4.0, 0.2),)
    ),
    Walk("go2, four times the noise", sensors=ORDINARY.scaled(4.0)),
    Walk("go2, 5 % missed, 0.2 false touches/s", sensors=MISSED),
    Walk("go2, no map of heights", sensors=UNMAPPED),
    Walk("anymal_c", robot="anymal_c"),
    Walk("solo12, 0.3 m/s", robot="solo12", speed=0.3),
)
"""Trots at 0.5 m/s on flat ground with ordinary sensors, but for what their names say."""


def error_table(walks: Sequence[Walk], seeds: int, duration: float) -> Table:
    """Return the worst errors over the seeds of each walk."""
    table = Table(title=f"state estimate in the loop, {duration:g} s, worst of {seeds} seeds")
    for column in ("run", "walked", "v rms [mm/s]", "drift [%]", "tilt rms [deg]", "heading [deg]", "laws"):
        table.add_column(column, justify="left" if column == "run" else "right")
    for walk in walks:
        summaries = [walk.summary(seed, duration) for seed in range(seeds)]
        errors = [s.estimate for s in summaries if s.estimate is not None]
        drifts = [e.drift_share for e in errors if e.drift_share is not None]
        table.add_row(
            walk.name,
            f"{sum(s.success for s in summaries)} of {seeds}",
            f"{1e3 * max(e.velocity_rms for e in errors):.1f}",
            f"{100 * max(drifts):.2f}" if drifts else "-",
            f"{max(e.tilt_rms_deg for e in errors):.2f}",
            f"{max(abs(e.heading_deg) for e in errors):.2f}",
            f"{sum(not s.laws_broken for s in summaries)} of {seeds}",
        )
    return table


def cost_table(names: Sequence[str], steps: int = 3000) -> Table:
    """Return the CPU time of the filter's and the whole estimator's step."""
    table = Table(title="CPU time of a step of a standing robot [us]")
    for column in ("robot", "filter: predict", "filter: update", "contact detection", "all"):
        table.add_column(column, justify="left" if column == "robot" else "right")
    for name in names:
        robot = load_robot(name)
        estimator = StateEstimator(InvariantEkf(robot, 1e-3))
        rest = np.array([0.0, 0.0, GRAVITY])
        reading = Reading(np.zeros(3), rest, robot.nominal[7:].copy(), np.zeros(robot.joints))
        on, zero = np.ones(len(robot.feet), dtype=bool), np.zeros(robot.joints)
        v = np.zeros(robot.model.nv)
        ekf, detector = estimator.ekf, estimator.detector
        times = (
            cpu_time(steps, partial(ekf.predict, reading.gyro, reading.accelerometer)),
            cpu_time(steps, partial(ekf.update, reading.positions, reading.speeds, on)),
            cpu_time(steps, partial(detector.advance, robot.nominal, v, ekf.normals)),
            cpu_time(steps, partial(whole_step, estimator, reading, on, zero)),
        )
        table.add_row(name, *(f"{t:.0f}" for t in times))
    return table


def whole_step(estimator: StateEstimator, reading: Reading, on: BoolArray, torques: FloatArray) -> None:
    """Take all parts of an estimator's step."""
    estimator.predict(reading)
    estimator.update(on)
    estimator.applied(torques)


def cpu_time(steps: int, task: Callable[[], object]) -> float:
    """Return the CPU time of a task [us], after one call that compiles it."""
    task()
    start = time.process_time()
    for _ in range(steps):
        task()
    return 1e6 * (time.process_time() - start) / steps


def main(arguments: Sequence[str] | None = None) -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="one short run")
    quick = parser.parse_args(arguments).quick
    console = Console()
    if quick:
        console.print(error_table(WALKS[:1], 1, 2.0))
        console.print(cost_table(("go2",), 300))
    else:
        console.print(error_table(WALKS, 3, 10.0))
        console.print(cost_table(("go2", "anymal_c", "g1")))


if __name__ == "__main__":
    main()
