"""Bodies that rest on bodies, stepped by MuJoCo: contact problems as a simulator meets them, step after step.

Boxes of 0.1 m, bricks of 0.1 x 0.1 x 0.05 m at intervals of 0.102 m (every other course shifted by half of
one and a brick shorter), 1 kg each, mu 0.6, steps of 2 ms.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

import surefoot as sf

STEP, SETTLE = 0.002, 20
"""Seconds of a step, and steps before the first problem is taken."""
PUSH, RATE = 6.5, 25.0
"""Force on a pushed body [N], and how fast it turns back and forth [rad/s]."""


@dataclass(frozen=True)
class Scene:
    """Bodies as MJCF text, and whether the first one is pushed."""

    bodies: str
    pushed: bool = False


@dataclass(frozen=True)
class Step:
    """The contact problem of a step, and CPU seconds of MuJoCo's own step."""

    problem: sf.ContactProblem
    mujoco: float


def _box(size: tuple[float, float, float], place: tuple[float, float, float]) -> str:
    return (
        f'<body pos="{place[0]} {place[1]} {place[2]}"><freejoint/>'
        f'<geom type="box" size="{size[0]} {size[1]} {size[2]}" mass="1" friction="0.6"/></body>'
    )


def stack(count: int) -> str:
    """Return boxes that stand on each other."""
    return "".join(_box((0.05, 0.05, 0.05), (0.0, 0.0, 0.05 + 0.1 * k)) for k in range(count))


def wall(courses: int, bricks: int) -> str:
    """Return a wall of bricks, every other course a brick shorter."""
    out = []
    for course in range(courses):
        for k in range(bricks - course % 2):
            x = (k - (bricks - 1) / 2) * 0.102 + 0.051 * (course % 2)
            out.append(_box((0.05, 0.05, 0.025), (x, 0.0, 0.025 + 0.05 * course)))
    return "".join(out)


def table() -> str:
    """Return a table on four legs with flat ends."""
    legs = "".join(
        f'<geom type="box" size=".03 .03 .2" pos="{x} {y} -.2" mass=".3" friction="0.6"/>'
        for x in (-0.3, 0.3)
        for y in (-0.2, 0.2)
    )
    top = '<geom type="box" size=".35 .25 .02" pos="0 0 .02" mass="1"/>'
    return f'<body pos="0 0 .4"><freejoint/>{top}{legs}</body>'


SCENES: Mapping[str, Scene] = MappingProxyType({
    "box": Scene(stack(1)), "pushed box": Scene(stack(1), pushed=True), "table": Scene(table()),
    "stack of 3": Scene(stack(3)), "stack of 6": Scene(stack(6)), "stack of 10": Scene(stack(10)),
    "wall of 11": Scene(wall(3, 4)), "wall of 23": Scene(wall(5, 5)), "wall of 60": Scene(wall(8, 8)),
})  # fmt: skip


def steps(scene: Scene, count: int) -> Iterator[Step]:
    """Yield the problems of so many steps of a scene, after it has settled; without contacts none."""
    import mujoco

    text = (
        f'<mujoco><option timestep="{STEP}" cone="elliptic"/><worldbody>'
        f'<geom type="plane" size="5 5 0.1" friction="0.6"/>{scene.bodies}</worldbody></mujoco>'
    )
    model: Any = mujoco.MjModel.from_xml_string(text)
    data: Any = mujoco.MjData(model)
    for turn in range(SETTLE + count):
        start = time.thread_time()
        mujoco.mj_step(model, data)
        took = time.thread_time() - start
        if turn < SETTLE:
            continue
        if scene.pushed:
            data.xfrc_applied[1, 0] = PUSH * np.sin(RATE * STEP * turn)
        mujoco.mj_forward(model, data)
        problem = sf.contacts_from_mujoco(model, data).problem
        if problem.contacts:
            yield Step(problem, took)
