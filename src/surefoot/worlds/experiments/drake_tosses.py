"""Drake as a rival of our own thrown body, its words of contact to fit."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records import FRICTION, ROUNDING, TossParameter, TossScene, in_plane, in_world
from surefoot.worlds.drake.drake_python import Worker
from surefoot.worlds.drake.drake_world import STICTION, WORKER
from surefoot.worlds.experiments.thrown_links import joint_words, steps_between


class DrakeBody:
    """Drake's point contact at rounded corners, with Hunt and Crossley's dissipation, steps of a millisecond.

    Of a joint's losses it has the damping, hinges do not give; it lives in an interpreter of its own, see
    `drake_python`.

    Parameters
    ----------
    approximation
        "similar", convex; "lagged", Drake's default, takes the last step's normal force, and corners chatter.

    Raises
    ------
    MissingExtra
        If Drake is not installed, and no other interpreter is named.
    """

    name = "drake"
    parameters = (
        FRICTION,
        TossParameter("stiffness_log10", 4.5, 0.1, 3.0, 7.0, "log N/m"),
        TossParameter("dissipation", 1.0, 0.1, 0.0, 50.0, "s/m"),
        ROUNDING,
    )

    def __init__(self, approximation: str = "similar") -> None:
        self._worker, self._approximation = Worker(WORKER), approximation

    def __reduce__(self) -> tuple[Any, ...]:
        return DrakeBody, (self._approximation,)

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, nq) positions [m], quaternions and joints."""
        mu, stiffness, dissipation, rounding = (float(v) for v in values)
        tree, steps = scene.body.rounded(rounding), steps_between(scene.dt)
        gravity, starts = in_plane(scene)
        nq = 6 + tree.masses.size
        # quaternions (w, x, y, z) before places, angular velocities before the others
        order = [6, 3, 4, 5, 0, 1, 2, *range(7, nq)]
        order += [*range(nq + 3, nq + 6), *range(nq, nq + 3), *range(nq + 6, 2 * nq - 1)]
        spheres = zip((tree.links + 1).tolist(), tree.points.tolist(), tree.radii.tolist(), strict=True)
        material = {"point_contact_stiffness": 10.0**stiffness, "hunt_crossley_dissipation": dissipation}
        level = {"rotation": np.eye(3).tolist(), "place": [0.0] * 3}
        words = {
            "dt": scene.dt / steps, "mu": mu, "gravity": gravity.tolist(), "material": material,
            "approximation": self._approximation, "near_rigid": None, "stiction": STICTION, "ground": [level],
            "spheres": list(spheres), "joints": [joint_words(scene.body, i) for i in range(nq - 6)],
        }  # fmt: skip
        self._worker.ask(["scene", words])
        thrown = self._worker.ask(["throw", starts[:, order].tolist(), scene.frames.tolist(), steps])
        poses = np.empty((len(thrown["q"]), nq))
        poses[:, order[:nq]] = thrown["q"]
        return in_world(poses, scene)
