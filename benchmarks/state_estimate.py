"""How well a walking robot knows its state, and what that costs.

Run: python -m benchmarks.state_estimate [--quick] [--seeds N] [--json]. Robots walk on what the contact-aided
invariant filter tells their controllers, from IMU, encoders and torques, with all their bodies' collision
geometry in MuJoCo; errors are those against the truth.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks.printing import options, show, table
from benchmarks.walks import Walk, known_robot
from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.motion.estimation.inekf_robot import InvariantEkf
from surefoot.motion.estimation.state_estimator import Reading, StateEstimator
from surefoot.worlds.running.run import Ice, Push
from surefoot.worlds.running.sensors import SensorModel

ORDINARY = SensorModel()
NUMB = replace(ORDINARY, touch=replace(ORDINARY.touch, missed=0.1))
HAUNTED = replace(ORDINARY, touch=replace(ORDINARY.touch, false=0.2))
UNMAPPED = replace(ORDINARY, heights=False)
OFFSET = replace(ORDINARY, encoders=replace(ORDINARY.encoders, bias=0.01))
BRISK = 0.5
"""Froude number of the robots' trots: speed over the root of g times the base's height."""
MANY, FEW = 20, 3
"""Seeds of the walks that the promises are about, `PROMISED`, and of the others."""


def late(encoders: float, imu: float = 0.001) -> SensorModel:
    """Return ordinary sensors that tell so late what they measure [s]."""
    return replace(
        ORDINARY,
        imu=replace(ORDINARY.imu, latency=imu),
        encoders=replace(ORDINARY.encoders, latency=encoders),
    )


def trot(speed: float = 0.5, **changed: Any) -> Walk:
    """Return a trot in MuJoCo [m/s] on flat ground with ordinary sensors, but for what is changed."""
    usual: dict[str, Any] = {"options": {"collision": "full"}, "sensors": ORDINARY}
    return Walk(velocity=(speed, 0.0, 0.0), **(usual | changed))


def brisk(name: str) -> Walk:
    """Return the trot of a robot at `BRISK`."""
    return trot(BRISK * math.sqrt(GRAVITY * float(known_robot(name).nominal[2])), robot=name)


PROMISED = {"go2, 0.5 m/s": trot(), "go2, 1 m/s": trot(1.0)}
"""The walks that have `MANY` seeds."""


def walks() -> dict[str, Walk]:
    """Return all walks by name."""
    robots = ("a1", "go1", "b1", "laikago", "solo12", "hyq", "anymal_b", "anymal_c")
    return {
        **PROMISED,
        "go2, 2 m/s asked": trot(2.0),
        "go2, rigid world": trot(world="rigid", options={}),
        **{f"{name}, Froude {BRISK}": brisk(name) for name in robots},
        "go2, pace": trot(gait="pace"),
        "go2, bound": trot(gait="bound"),
        "go2, flying trot, 0.8 m/s": trot(0.8, gait="flying_trot"),
        "go2, walk, 0.3 m/s": trot(0.3, gait="walk"),
        "go2, 20 degree slope, 0.4 m/s": trot(0.4, terrain="slope:20"),
        "go2, stairs of 8 cm, 0.3 m/s": trot(0.3, terrain="stairs:0.08,0.3"),
        "go2, 4 cm rough, 0.4 m/s": trot(0.4, terrain="rough:1,0.04"),
        "go2, 150 N to the left for 0.1 s": trot(pushes=(Push(2.0, (0.0, 150.0, 0.0), 0.1),)),
        "go2, mu 0.2 unknown": trot(ice=(Ice(2.0, 0.2),)),
        "go2, four times the noise": trot(sensors=ORDINARY.scaled(4.0)),
        "go2, joints' zeros off by 0.01 rad": trot(sensors=OFFSET),
        "go2, all 5 ms late": trot(sensors=late(0.005, 0.005)),
        "go2, encoders 10 ms late": trot(sensors=late(0.01)),
        "go2, encoders 20 ms late": trot(sensors=late(0.02)),
        "go2, 10 % of forces missed": trot(sensors=NUMB),
        "go2, 0.2 false forces/s a foot": trot(sensors=HAUNTED),
        "go2, no map of heights": trot(sensors=UNMAPPED),
    }


def error_table(chosen: Mapping[str, Walk], seeds: int | None, duration: float) -> Table:
    """Return the worst errors over the seeds of each walk; None for `MANY` or `FEW` of them."""
    columns = ("run", "walked", "v rms [mm/s]", "drift [%]", "tilt rms [deg]", "heading [deg]", "lawful")
    rows = []
    for name, walk in chosen.items():
        many = seeds or (MANY if name in PROMISED else FEW)
        summaries = [walk.summary(seed, duration) for seed in range(many)]
        errors = [s.estimate for s in summaries if s.estimate is not None]
        drifts = [e.drift_share for e in errors if e.drift_share is not None]
        rows.append((
            name, f"{sum(s.success for s in summaries)} of {many}",
            f"{1e3 * max(e.velocity_rms for e in errors):.1f}",
            f"{100 * max(drifts):.2f}" if drifts else "-",
            f"{max(e.tilt_rms_deg for e in errors):.2f}",
            f"{max(abs(e.heading_deg) for e in errors):.2f}",
            f"{sum(not s.laws_broken for s in summaries)} of {many}",
        ))  # fmt: skip
        print(name, "done", file=sys.stderr, flush=True)
    return table(columns, rows, f"state estimate in the loop, {duration:g} s, worst of the seeds")


def cost_table(names: Sequence[str], steps: int = 3000) -> Table:
    """Return the CPU time of the filter's and the whole estimator's step."""
    rows = []
    for name in names:
        robot = known_robot(name)
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
        rows.append((name, *(f"{t:.0f}" for t in times)))
    columns = ("robot", "filter: predict", "filter: update", "forces", "contacts", "all")
    return table(columns, rows, "CPU time of a step of a standing robot [us]")


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
    parser = options(__doc__, "one short run")
    parser.add_argument("--seeds", type=int, help="of every run; by default 20 of the first two, 3 of others")
    given = parser.parse_args(arguments)
    show(_tables(given.quick, given.seeds), given.json)


def _tables(quick: bool, seeds: int | None) -> Iterator[Table]:
    yield error_table({"go2, 0.5 m/s": trot()}, 1, 2.0) if quick else error_table(walks(), seeds, 10.0)
    yield cost_table(("go2",), 300) if quick else cost_table(("go2", "anymal_c", "g1"))


if __name__ == "__main__":
    main()
