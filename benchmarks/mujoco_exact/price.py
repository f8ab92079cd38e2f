"""What a step costs: MuJoCo's and the exact one in turn, CPU time of the thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

import surefoot as sf
from benchmarks.mujoco_exact.scenes import hand, pinch, press, robot, stack, still
from surefoot.base.arrays import FloatArray
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records.log import Ending

QUICK, WHOLE = 400, 3000
"""Steps of a price."""


@dataclass(frozen=True)
class Price:
    """CPU time of a step [µs]: median and 99th percentile, exact and MuJoCo's, and what was not solved."""

    name: str
    exact: tuple[float, float]
    soft: tuple[float, float]
    unsolved: int
    steps: int

    @property
    def allowed(self) -> float:
        """The larger of three times MuJoCo's median and 30 µs more."""
        return max(3.0 * self.soft[0], self.soft[0] + 30.0)


@dataclass(frozen=True)
class Course:
    """A walk's steps, to be made anew: (n, nq), (n, nv), (n, nu) states and controls before each."""

    qpos: FloatArray
    qvel: FloatArray
    ctrl: FloatArray
    applied: FloatArray

    @classmethod
    def of_walk(cls, name: str, seconds: float, exact: bool) -> tuple[Any, Course]:
        """Return the model, and the steps that are made where a robot walks at 0.3 m/s."""
        world = sf.MujocoWorld(sf.load_robot(name), mu=0.7, exact=exact)
        rows, advance, data = list[tuple[FloatArray, ...]](), world._advance, world.data

        def noted() -> None:
            rows.append(tuple(np.array(a) for a in (data.qpos, data.qvel, data.ctrl, data.qfrc_applied)))
            advance()

        world._advance = noted
        walk = walking_controller(world.robot, sf.VelocityCommand.constant(0.3), mu=0.7)
        log = sf.run(world, walk, sf.Scenario(seconds, 0.7))
        if log.facts["outcome"] != Ending.DONE:
            raise RuntimeError(f"{name} did not walk: {log.facts['outcome']}")
        return world.model, cls(*(np.array(column) for column in zip(*rows, strict=True)))

    def put(self, data: Any, k: int) -> None:
        """Have a data be where step k begins."""
        data.qpos[:], data.qvel[:] = self.qpos[k], self.qvel[k]
        data.ctrl[:], data.qfrc_applied[:] = self.ctrl[k], self.applied[k]


def price(
    name: str, model: Any, control: Callable[[Any], None], steps: int, start: Any = None,
    courses: Sequence[Course] = (),
) -> Price:  # fmt: skip
    """Return what both steps cost in the same loop: each goes its way, or each a course of its own."""
    stepper = sf.MujocoStepper(model)
    both = [mujoco.MjData(model) for _ in range(2)]
    for data in both:
        if start is not None:
            data.qpos[:], data.qvel[:] = start.qpos, start.qvel
    ways: tuple[Callable[[Any], None], ...] = (stepper.step, lambda data: mujoco.mj_step(model, data))
    taken = np.zeros((2, steps))
    for k in range(steps):
        for way in range(2):
            control(both[way])
            if courses:
                courses[way].put(both[way], k)
            begin = time.thread_time_ns()
            ways[way](both[way])
            taken[way, k] = time.thread_time_ns() - begin
    late = taken[:, steps // 10 :] / 1e3
    numbers = [(float(np.median(row)), float(np.percentile(row, 99))) for row in late]
    return Price(name, numbers[0], numbers[1], stepper.unsolved, steps)


def prices(quick: bool) -> Iterator[Price]:
    """Yield the prices of all scenes."""
    steps = QUICK if quick else WHOLE
    for name in ("go2", "g1"):
        model, start = robot(name)
        yield price(f"{name} standing", model, still, steps, start)
        (model, exact), (_, soft) = (Course.of_walk(name, steps * 1e-3, kind) for kind in (True, False))
        yield price(f"{name} walking", model, still, len(exact.qpos), courses=(exact, soft))
    yield price("pinch", pinch(), press, steps)
    for count in (1, 3, 6, 10):
        yield price(f"stack of {count}", stack(count), still, steps if count < 10 else steps // 4)
    yield price("hand of 32 contacts", hand(), still, steps)
