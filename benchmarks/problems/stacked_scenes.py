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


def _box(size: tuple[float, float, float], place: tuple[float, float, float], mass: float = 1.0) -> str:
    return (
        f'<body pos="{place[0]} {place[1]} {place[2]}"><freejoint/>'
        f'<geom type="box" size="{size[0]} {size[1]} {size[2]}" mass="{mass}" friction="0.6"/></body>'
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


def biped() -> str:
    """Return a torso on two sprung legs with box feet."""
    legs = "".join(
        f'<body pos="0 {y} -.1"><joint axis="0 1 0" stiffness="400" damping="5"/>'
        '<geom type="capsule" size=".03" fromto="0 0 0 0 0 -.4" mass="2"/>'
        '<body pos="0 0 -.4"><joint axis="0 1 0" stiffness="200" damping="2"/>'
        '<geom type="box" size=".1 .05 .02" pos=".02 0 -.03" mass=".5" friction="0.6"/></body></body>'
        for y in (-0.1, 0.1)
    )
    torso = '<geom type="box" size=".08 .12 .1" mass="8"/>'
    return f'<body pos="0 0 .551"><freejoint/>{torso}{legs}</body>'


def bridge() -> str:
    """Return a plank on two piles of two boxes, and a heavy box on the plank, off its middle."""
    piles = "".join(_box((0.05, 0.05, 0.05), (x, 0.0, z)) for x in (-0.2, 0.2) for z in (0.05, 0.15))
    plank = _box((0.3, 0.05, 0.01), (0.0, 0.0, 0.21), 0.5)
    return piles + plank + _box((0.05, 0.05, 0.05), (0.08, 0.0, 0.27), 10.0)


def pyramid(base: int) -> str:
    """Return courses of boxes, each a box shorter than the one below it."""
    return "".join(
        _box((0.05, 0.05, 0.05), ((k - (base - course - 1) / 2) * 0.102, 0.0, 0.05 + 0.1 * course))
        for course in range(base)
        for k in range(base - course)
    )


def heavy_on_light() -> str:
    """Return a stack of four boxes, each ten times as heavy as the one below it."""
    return "".join(_box((0.05, 0.05, 0.05), (0.0, 0.0, 0.05 + 0.1 * k), 0.1 * 10.0**k) for k in range(4))


def balls() -> str:
    """Return eight balls in two layers that a square of four walls holds in."""
    walls = "".join(
        f'<geom type="box" size="{sx} {sy} .1" pos="{x} {y} .1" friction="0.6"/>'
        for sx, sy, x, y in (
            (0.01, 0.12, -0.11, 0.0),
            (0.01, 0.12, 0.11, 0.0),
            (0.12, 0.01, 0.0, -0.11),
            (0.12, 0.01, 0.0, 0.11),
        )
    )
    loose = "".join(
        f'<body pos="{x + 0.005 * level} {y - 0.003 * level} {0.05 + 0.095 * level}"><freejoint/>'
        '<geom type="sphere" size=".05" mass="1" friction="0.6"/></body>'
        for level in range(2)
        for x in (-0.05, 0.05)
        for y in (-0.05, 0.05)
    )
    return walls + loose


SCENES: Mapping[str, Scene] = MappingProxyType({
    "box": Scene(stack(1)), "pushed box": Scene(stack(1), pushed=True), "table": Scene(table()),
    "stack of 3": Scene(stack(3)), "stack of 6": Scene(stack(6)), "stack of 10": Scene(stack(10)),
    "biped": Scene(biped()), "bridge": Scene(bridge()), "pyramid of 10": Scene(pyramid(4)),
    "heavy on light": Scene(heavy_on_light()), "balls": Scene(balls()),
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
