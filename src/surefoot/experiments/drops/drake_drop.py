"""A mass on a vertical slide over a plane, in Drake: a scene of one joint and one sphere for its worker."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.experiments.drops.drop import SlideDrop
from surefoot.simulation.drake.world import WORKER, contact_words
from surefoot.simulation.drake_python import EXTRA as EXTRA
from surefoot.simulation.drake_python import PACKAGE as PACKAGE
from surefoot.simulation.drake_python import Worker
from surefoot.simulation.drake_python import present as present

RADIUS, MU = 1.0, 0.5
"""Of the sphere [m], which only slides up and down, and its friction, which therefore does nothing."""


def run(drop: SlideDrop) -> tuple[FloatArray, FloatArray]:
    """Return gaps [m] and speeds [m/s] at every step: (T,)."""
    level = np.eye(3).tolist()
    joint = {
        "parent": 0, "rotation": level, "place": [0.0] * 3, "mass": drop.mass, "com": [0.0] * 3,
        "inertia": np.diag([0.4 * drop.mass * RADIUS**2] * 3).tolist(), "kind": "prismatic",
        "axis": [0.0, 0.0, 1.0], "low": -np.inf, "high": np.inf,
    }  # fmt: skip
    words = contact_words(drop.settings)
    scene = {
        "dt": drop.dt, "mu": MU, "gravity": [0.0, 0.0, -drop.gravity], **words, "joints": [joint],
        "near_rigid": 0.0 if words["approximation"] == "sap" else None,
        "spheres": [[1, [0.0] * 3, RADIUS]], "ground": [{"rotation": level, "place": [0.0] * 3}],
    }  # fmt: skip
    worker = Worker(WORKER)
    try:
        worker.ask(["scene", scene])
        worker.ask(["reset", [RADIUS + drop.gap], [drop.speed]])
        answer = worker.ask(["track", drop.steps, RADIUS if drop.until == "apart" else None])
    finally:
        worker.close()
    return np.array([drop.gap, *(np.array(answer["q"]) - RADIUS)]), np.array([drop.speed, *answer["v"]])
