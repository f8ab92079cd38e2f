"""What engines make of a few scenes at their defaults, beside tuned ones: errors and cost."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.worlds.drake.drake_world import contact_words, near_rigid
from surefoot.worlds.experiments.engines.runners import bullet, elsewhere, mujoco, rigid
from surefoot.worlds.experiments.ground import hard

MASS, CUBE, BALL, FLAT = 2.0, 0.2, 0.1, (0.4, 0.4, 0.1)
"""Of every body [kg], edge of the stack's cubes, radius of the ball and edges of the box that slides [m]."""
SPEED, MU, TILT, GRIP, E, HEIGHT = 2.0, 0.4, 20.0, 0.5, 0.6, 0.2
"""Of slides [m/s] and their friction; slope that holds [deg] and its friction; restitution, and fall [m]."""
STACK = 5


class EngineSetup(NamedTuple):
    """An engine: its own step [s], and numbers of the ground for a step and a mass where it is tuned."""

    world: str
    run: Callable[[dict[str, Any]], tuple[list[Any], float]]
    step: float
    contact: Callable[[float, float], dict[str, Any]] | None = None
    tuned: bool = False


class Case(NamedTuple):
    """A scene, and the error that its path (n + 1, bodies, 3) [m] over a step [s] shows."""

    unit: str
    seconds: float
    scene: dict[str, Any]
    error: Callable[[FloatArray], float]


def _scene(*bodies: tuple[Any, float, Any], mu: float = MU, tilt: float = 0.0) -> dict[str, Any]:
    """Return a scene of bodies (size, height of the centre, velocity in the plane and upwards)."""
    turn = math.radians(tilt)
    parts = [
        {"size": list(size), "mass": MASS, "place": [0.0, 0.0, z], "velocity": list(v)}
        for size, z, v in bodies
    ]
    pull = [GRAVITY * math.sin(turn), 0.0, -GRAVITY * math.cos(turn)]
    return {"bodies": parts, "mu": mu, "restitution": E, "gravity": pull, "tilt": tilt}


def _slide(degrees: float) -> Case:
    way, turn = SPEED**2 / (2.0 * MU * GRAVITY), math.radians(degrees)
    start = _scene((FLAT, 0.5 * FLAT[2], (SPEED * math.cos(turn), SPEED * math.sin(turn), 0.0)))

    def error(path: FloatArray) -> float:
        return abs(float(np.linalg.norm(path[-1, 0, :2] - path[0, 0, :2])) / way - 1.0)

    return Case("of its way", 0.9, start, error)


def _bounce(path: FloatArray) -> float:
    gap = path[:, 0, 2] - BALL
    low = int(np.argmax(np.diff(gap) > 0.0))
    top = max(float(gap[low:].max()), 0.0) if low else 0.0
    return abs(math.sqrt(top / HEIGHT) - E)


CASES: dict[str, Case] = {
    "slide": _slide(0.0),
    "slide at 45 deg": _slide(45.0),
    "creep on a slope": Case(
        "m/s", 1.0, _scene((FLAT, 0.5 * FLAT[2], (0.0, 0.0, 0.0)), mu=GRIP, tilt=TILT),
        lambda path: 2.0 * float(np.linalg.norm(path[-1, 0] - path[len(path) // 2, 0])),
    ),
    "restitution": Case("", 0.5, _scene(((BALL,), BALL + HEIGHT, (0.0, 0.0, 0.0))), _bounce),
    "stack": Case(
        "of an edge", 1.0, _scene(*(((CUBE,) * 3, (k + 0.5) * CUBE, (0.0, 0.0, 0.0)) for k in range(STACK))),
        lambda path: float(np.abs(path[-1] - path[0]).max()) / CUBE,
    ),
}  # fmt: skip
"""Closed forms: v² / (2 mu g) in any direction; no motion below the friction angle; 0.6; no motion."""


_DRAKE = partial(elsewhere, engine="drake")
ENGINES: dict[str, EngineSetup] = {
    "rigid": EngineSetup("rigid", rigid, 1e-3),
    "mujoco exact": EngineSetup("mujoco-exact", partial(mujoco, exact=True), 2e-3),
    "mujoco": EngineSetup("mujoco", mujoco, 2e-3),
    "mujoco tuned": EngineSetup("mujoco", mujoco, 1e-3, lambda dt, _: hard("mujoco", dt), True),
    "mjx": EngineSetup("mjx", partial(mujoco, mjx=True), 2e-3),
    "bullet": EngineSetup("bullet", bullet, 1.0 / 240.0),
    "bullet 1 ms": EngineSetup("bullet", bullet, 1e-3, tuned=True),
    "drake": EngineSetup("drake", _DRAKE, 1e-3),
    "drake SAP": EngineSetup("drake", _DRAKE, 1e-3, lambda *_: {"approximation": "sap"}),
    "drake hydroelastic": EngineSetup("drake", partial(_DRAKE, solver="hydroelastic"), 1e-3),
    "drake CENIC": EngineSetup("drake", partial(_DRAKE, solver="cenic"), 1e-2),
    "drake tuned": EngineSetup("drake", _DRAKE, 1e-3, lambda dt, m: contact_words(near_rigid(m, dt)), True),
    **{
        f"newton {name}": EngineSetup("newton", partial(elsewhere, engine="newton", solver=name), 1.0 / 600.0)
        for name in ("XPBD", "SemiImplicit", "Featherstone", "MuJoCo", "Steel")
    },
}
"""Name to engine. Steps are the engines' own; Newton has none, its examples take 1/600 s, CENIC chooses."""


def measured(engine: str, case: str) -> tuple[float, float]:
    """Return the error of a case in an engine (in `Case.unit`), and CPU seconds per simulated second.

    The error is infinite where the path is lost.
    """
    made, asked = ENGINES[engine], CASES[case]
    scene = {**asked.scene, "dt": made.step, "steps": round(asked.seconds / made.step)}
    if made.contact is not None:
        scene["contact"] = made.contact(made.step, MASS * len(scene["bodies"]))
    path, seconds = made.run(scene)
    places = np.array(path, dtype=np.float64)
    return asked.error(places) if np.isfinite(places).all() else math.inf, seconds / asked.seconds
