"""How well a walking robot knows its state, and what that costs.

Run: python -m benchmarks.state_estimate [--quick] [--seeds N] [--json]. Robots walk on what the contact-aided
invariant filter tells their controllers, from IMU, encoders and torques, with all their bodies' collision
geometry in MuJoCo; errors are those against the truth.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from rich.table import Table

from benchmarks.printing import show
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
NUMB = replace(ORDINARY, touch=replace(ORDINARY.touch, missed=0.1))
HAUNTED = replace(ORDINARY, touch=replace(ORDINARY.touch, false=0.2))
UNMAPPED = replace(ORDINARY, heights=False)
OFFSET = replace(ORDINARY, encoders=replace(ORDINARY.encoders, bias=0.01))
MU = 0.6
BRISK = 0.5
"""Froude number of the robots' trots: speed over the root of g times the base's height."""
MANY, FEW = 20, 3
"""Seeds of the walks that the promises are about, and of the others."""


def late(encoders: float, imu: float = 0.001) -> SensorModel:
    """Return ordinary sensors that tell so late what they measure [s]."""
    return replace(
        ORDINARY,
        imu=replace(ORDINARY.imu, latency=imu),
        encoders=replace(ORDINARY.encoders, latency=encoders),
    )


@dataclass(frozen=True)
class Walk:
    """A walk that is estimated; `speed` [m/s] is None for `BRISK`."""

    name: str
    robot: str = "go2"
    world: str = "mujoco"
    terrain: str = "flat"
    gait: str = "trot"
    speed: float | None = 0.5
    sensors: SensorModel = ORDINARY
    pushes: tuple[Push, ...] = ()
    ice: tuple[Ice, ...] = ()
    seeds: int = FEW

    def summary(self, seed: int, duration: float) -> WalkSummary:
        """Return what the walk with a seed came to."""
        robot, ground = load_robot(self.robot), read_terrain(self.terrain)
        brisk = BRISK * math.sqrt(GRAVITY * float(robot.nominal[2]))
        command = VelocityCommand.constant(brisk if self.speed is None else self.speed)
        controller = WalkingController(robot, command, self.gait, ground, WalkSettings(mu=MU))
        scenario = Scenario(
            duration, MU, self.pushes, self.ice, seed, start=start_pose(robot, ground), sensors=self.sensors
        )
        options = {"collision": "full"} if self.world == "mujoco" else {}
        return summarise_walk(run(make_world(self.world, robot, ground, MU, **options), controller, scenario))


WALKS = (
    Walk("go2, 0.5 m/s", seeds=MANY),
    Walk("go2, 1 m/s", speed=1.0, seeds=MANY),
    Walk("go2, 2 m/s asked", speed=2.0),
    Walk("go2, rigid world", world="rigid"),
    *(Walk(f"{name}, Froude {BRISK}", robot=name, speed=None) for name in (
        "a1", "go1", "b1", "laikago", "solo12", "hyq", "anymal_b", "anymal_c",
    )),
    Walk("go2, pace", gait="pace"),
    Walk("go2, bound", gait="bound"),
    Walk("go2, flying trot, 0.8 m/s", gait="flying_trot", speed=0.8),
    Walk("go2, walk, 0.3 m/s", gait="walk", speed=0.3),
    Walk("go2, 20 degree slope, 0.4 m/s", terrain="slope:20", speed=0.4),
    Walk("go2, stairs of 8 cm, 0.3 m/s", terrain="stairs:0.08,0.3", speed=0.3),
    Walk("go2, 4 cm rough, 0.4 m/s", terrain="rough:1,0.04", speed=0.4),
    Walk("go2, 150 N to the left for 0.1 s", pushes=(Push(2.0, (0.0, 150.0, 0.0), 0.1),)),
    Walk("go2, mu 0.2 unknown", ice=(Ice(2.0, 0.2),)),
    Walk("go2, four times the noise", sensors=ORDINARY.scaled(4.0)),
    Walk("go2, joints' zeros off by 0.01 rad", sensors=OFFSET),
    Walk("go2, all 5 ms late", sensors=late(0.005, 0.005)),
    Walk("go2, encoders 10 ms late", sensors=late(0.01)),
    Walk("go2, encoders 20 ms late", sensors=late(0.02)),
    Walk("go2, 10 % of forces missed", sensors=NUMB),
    Walk("go2, 0.2 false forces/s a foot", sensors=HAUNTED),
    Walk("go2, no map of heights", sensors=UNMAPPED),
)  # fmt: skip
"""Trots at 0.5 m/s in MuJoCo on flat ground with ordinary sensors, but for what their names say."""


def error_table(walks: Sequence[Walk], seeds: int | None, duration: float) -> Table:
    """Return the worst errors over the seeds of each walk; None for as many seeds as it names."""
    table = Table(title=f"state estimate in the loop, {duration:g} s, worst of the seeds")
    columns = ("run", "walked", "v rms [mm/s]", "drift [%]", "tilt rms [deg]", "heading [deg]", "lawful")
    for column in columns:
        table.add_column(column, justify="left" if column == "run" else "right")
    for walk in walks:
        many = seeds or walk.seeds
        summaries = [walk.summary(seed, duration) for seed in range(many)]
        errors = [s.estimate for s in summaries if s.estimate is not None]
        drifts = [e.drift_share for e in errors if e.drift_share is not None]
        table.add_row(
            walk.name,
            f"{sum(s.success for s in summaries)} of {many}",
            f"{1e3 * max(e.velocity_rms for e in errors):.1f}",
            f"{100 * max(drifts):.2f}" if drifts else "-",
            f"{max(e.tilt_rms_deg for e in errors):.2f}",
            f"{max(abs(e.heading_deg) for e in errors):.2f}",
            f"{sum(not s.laws_broken for s in summaries)} of {many}",
        )
        print(walk.name, "done", file=sys.stderr, flush=True)
    return table


def cost_table(names: Sequence[str], steps: int = 3000) -> Table:
    """Return the CPU time of the filter's and the whole estimator's step."""
    table = Table(title="CPU time of a step of a standing robot [us]")
    for column in ("robot", "filter: predict", "filter: update", "forces", "contacts", "all"):
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
            cpu_time(steps, partial(detector.observe, robot.nominal, v, ekf.normals)),
            cpu_time(steps, estimator.decide),
            cpu_time(steps, partial(whole_step, estimator, reading, on, zero)),
        )
        table.add_row(name, *(f"{t:.0f}" for t in times))
    return table


def whole_step(estimator: StateEstimator, reading: Reading, on: BoolArray, torques: FloatArray) -> None:
    """Take all parts of an estimator's step."""
    estimator.predict(reading)
    estimator.decide()
    estimator.update(on)
    estimator.expect(on, on)
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
    parser.add_argument("--seeds", type=int, help="of every run; by default 20 of the first two, 3 of others")
    parser.add_argument("--json", action="store_true", help="print the tables as JSON")
    given = parser.parse_args(arguments)
    show(_tables(given.quick, given.seeds), given.json)


def _tables(quick: bool, seeds: int | None) -> Iterator[Table]:
    yield error_table(WALKS[:1], 1, 2.0) if quick else error_table(WALKS, seeds, 10.0)
    yield cost_table(("go2",), 300) if quick else cost_table(("go2", "anymal_c", "g1"))


if __name__ == "__main__":
    main()
