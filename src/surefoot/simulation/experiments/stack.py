"""A box on a box: what each carries, and what happens when the lower one is struck.

Boxes that touch boxes are each world's own: a scene in the rigid world, MuJoCo's boxes, and in Drake, whose
boxes meet in one point at a time, the corners of the upper one as small spheres on the lower. Drake's
approximation is "lagged" here: SAP, a convex relaxation, throws what is set sliding by a blow into the air
with mu times the speed of sliding, whatever the step.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.collision import Box
from surefoot.simulation.drake.world import SLIP, WORKER, near_rigid
from surefoot.simulation.drake_python import Worker
from surefoot.simulation.experiments.experiment import Curve, Experiment, Measurement, Quantity
from surefoot.simulation.experiments.ground import NEAR_RIGID, STEPS_OF_MUJOCO
from surefoot.simulation.mujoco import FRICTION_RATIO, import_mujoco
from surefoot.simulation.scene import Body, Scene
from surefoot.simulation.scene_world import SceneWorld
from surefoot.spatial import GRAVITY

SIZES = ((0.3, 0.3, 0.06), (0.2, 0.2, 0.04))
MASSES = (4.0, 2.0)
"""Of the lower and the upper box [kg]."""
GROUND_MU, MU, SPEED = 0.3, 0.5, 1.0
"""Frictions under the lower and the upper box, and the speed that the lower one gets [m/s]."""
SETTLE, SECONDS, FINER = 0.05, 0.25, 8.0
"""Durations [s]; an eighth of the step, or soft worlds blur the blow."""
CORNER, GAP = 1e-3, 2e-3
"""Radius of Drake's corners, and what the lower box lacks at its bottom there [m]."""


DISSIPATION = 50.0
"""Drake's Hunt-Crossley dissipation [s/m]: nothing leaves the ground faster than 1 / 50 m/s."""


class StackRun(NamedTuple):
    """(n + 1,) places of both boxes along x [m], and the loads at rest that each carries on itself [N]."""

    lower: FloatArray
    upper: FloatArray
    between: float
    ground: float


def _stack_run(places: list[tuple[float, float]], between: float, ground: float) -> StackRun:
    both = np.array(places, dtype=np.float64)
    return StackRun(both[:, 0], both[:, 1], between, ground)


def _heights() -> tuple[float, float]:
    return 0.5 * SIZES[0][2], SIZES[0][2] + 0.5 * SIZES[1][2]


def _rigid(dt: float) -> StackRun:
    boxes = [
        Body(name, Box(size), mass, (0.0, 0.0, height), friction=MU)
        for name, size, mass, height in zip(("lower", "upper"), SIZES, MASSES, _heights(), strict=True)
    ]
    world = SceneWorld(Scene(boxes), mu=GROUND_MU, dt=dt)
    for _ in range(round(SETTLE / dt)):
        world.step()
    loads = [sum(float(t.force[2]) for t in world.touches() if t.body == name) for name in ("upper", "lower")]
    between = abs(loads[0])
    ground = sum(float(t.force[2]) for t in world.touches() if t.other == "ground")
    q, v = world.state()
    v[:] = 0.0
    v[0] = SPEED
    world.reset(q, v)
    places = [(q[0], q[7])]
    for _ in range(round(SECONDS / dt)):
        world.step()
        q = world.state()[0]
        places.append((q[0], q[7]))
    return _stack_run(places, between, ground)


def _mujoco(dt: float) -> StackRun:
    mujoco = import_mujoco()
    boxes = "".join(
        f'<body pos="0 0 {height!r}"><freejoint/><geom name="{name}" type="box" mass="{mass!r}" '
        f'size="{" ".join(repr(0.5 * x) for x in size)}"/></body>'
        for name, size, mass, height in zip(("lower", "upper"), SIZES, MASSES, _heights(), strict=True)
    )
    soft = f'solref="{STEPS_OF_MUJOCO * dt!r} 1" solimp="{" ".join(map(repr, NEAR_RIGID))}" condim="3"'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{dt!r}" cone="elliptic" impratio="{FRICTION_RATIO!r}" tolerance="1e-10" '
        f'iterations="50" gravity="0 0 {-GRAVITY!r}"/>'
        f'<worldbody><geom name="ground" type="plane" size="9 9 1"/>{boxes}</worldbody><contact>'
        f'<pair geom1="ground" geom2="lower" {soft} friction="{GROUND_MU} {GROUND_MU} 0 0 0"/>'
        f'<pair geom1="lower" geom2="upper" {soft} friction="{MU} {MU} 0 0 0"/></contact></mujoco>'
    )
    data, force = mujoco.MjData(model), np.zeros(6)
    for _ in range(round(SETTLE / dt)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    loads = {0: 0.0, 1: 0.0}
    for k in range(data.ncon):
        mujoco.mj_contactForce(model, data, k, force)
        loads[int(data.contact[k].geom.min())] += float(force[0])
    data.qvel[:] = 0.0
    data.qvel[0] = SPEED
    places = [(data.qpos[0], data.qpos[7])]
    for _ in range(round(SECONDS / dt)):
        mujoco.mj_step(model, data)
        places.append((data.qpos[0], data.qpos[7]))
    return _stack_run(places, loads[1], loads[0])


def _drake(dt: float) -> StackRun:
    stiffness = near_rigid(sum(MASSES), dt)["each_body"]["point_contact_stiffness"]
    material = {"point_contact_stiffness": stiffness, "hunt_crossley_dissipation": DISSIPATION}
    worker = Worker(WORKER)
    worker.ask(["scene", {
        "dt": dt, "mu": GROUND_MU, "near_rigid": None, "gravity": [0.0, 0.0, -GRAVITY],
        "approximation": "lagged", "material": material, "stiction": SLIP * dt,
        "joints": [_free(size, mass) for size, mass in zip(SIZES, MASSES, strict=True)],
        "spheres": [*_corners(0, GROUND_MU), *_corners(1, MU)],
        "boxes": [[1, [0.0, 0.0, 0.5 * GAP], [*SIZES[0][:2], SIZES[0][2] - GAP], MU]],
        "ground": [{"rotation": np.eye(3).tolist(), "place": [0.0, 0.0, 0.0]}],
    }])  # fmt: skip
    still, (low, high) = [0.0] * 12, _heights()
    worker.ask(["reset", [1.0, 0, 0, 0, 0, 0, low, 1.0, 0, 0, 0, 0, 0, high], still])
    answer: dict[str, Any] = {}
    for _ in range(round(SETTLE / dt)):
        answer = worker.ask(["step", still])
    loads = [sum(c[3] for c in answer["contacts"] if c[0] // 4 == k) for k in (0, 1)]
    start = [*still]
    start[3] = SPEED  # angular velocity comes first
    worker.ask(["reset", answer["q"], start])
    places = [(answer["q"][4], answer["q"][11])]
    for _ in range(round(SECONDS / dt)):
        answer = worker.ask(["step", still])
        places.append((answer["q"][4], answer["q"][11]))
    worker.close()
    return _stack_run(places, loads[1], loads[0])


def _free(size: tuple[float, float, float], mass: float) -> dict[str, Any]:
    """Return a free box as Drake's worker takes it."""
    squares = np.array(size) ** 2
    return {
        "parent": 0, "rotation": np.eye(3).tolist(), "place": [0.0] * 3, "mass": mass, "com": [0.0] * 3,
        "inertia": np.diag(mass / 12.0 * (squares.sum() - squares)).tolist(), "kind": "free",
        "axis": [0.0] * 3, "low": 0.0, "high": 0.0,
    }  # fmt: skip


def _corners(box: int, mu: float) -> list[list[Any]]:
    """Return the lower corners of a box as spheres."""
    x, y, z = (0.5 * edge - CORNER for edge in SIZES[box])
    return [[box + 1, [i * x, j * y, -z], CORNER, mu] for i in (1.0, -1.0) for j in (1.0, -1.0)]


_RUNS: dict[str, Callable[[float], StackRun]] = {"rigid": _rigid, "mujoco": _mujoco, "drake": _drake}


def _times() -> tuple[float, float, float]:
    """Return how the lower box slows down and the upper gains speed [m/s²], and when they meet [s]."""
    slows = (GROUND_MU * sum(MASSES) + MU * MASSES[1]) * GRAVITY / MASSES[0]
    gains = MU * GRAVITY
    return slows, gains, SPEED / (slows + gains)


def shift(time: FloatArray) -> FloatArray:
    """Return how far the lower box has left the upper behind [m] at times (T,) [s]."""
    slows, gains, meet = _times()
    t = np.minimum(time, meet)
    return np.asarray(SPEED * t - 0.5 * (slows + gains) * t**2)


def _stack(world: str, dt: float) -> Measurement:
    h = dt / FINER
    run = _RUNS[world](h)
    slows, gains, meet = _times()
    together = gains * meet
    way = SPEED * meet - 0.5 * slows * meet**2 + together**2 / (2.0 * GROUND_MU * GRAVITY)
    apart = run.lower - run.upper
    quantities = (
        Quantity("load between / upper weight", "", 1.0),
        Quantity("load on the ground / weight", "", 1.0),
        Quantity("lower ahead of upper", "m", float(shift(np.array(math.inf)))),
        Quantity("way of the lower box", "m", way),
    )
    values = (
        run.between / (MASSES[1] * GRAVITY),
        run.ground / (sum(MASSES) * GRAVITY),
        apart[-1] - apart[0],
        run.lower[-1] - run.lower[0],
    )
    time = np.arange(len(apart), dtype=np.float64) * h
    return Measurement(values, quantities, Curve(time, apart - apart[0]))


STACK = Experiment(
    "stack",
    "A box of 2 kg rests on one of 4 kg, which is then struck: 1 m/s; friction 0.5 on 0.3; step/8.",
    "loads at rest against weights; how far the lower box leaves the upper behind, and its way, against two "
    "constant decelerations",
    _stack,
    lambda: Curve.over(SECONDS, shift),
    ("time [s]", "lower ahead of upper [m]"),
    tuple(_RUNS),
)
