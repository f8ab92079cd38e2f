"""A tossed cube in Drake: eight small spheres at its corners on a half-space, point contact, SAP.

Drake's own box meets a plane in one point at a time, which rocks; spheres at the corners are what its users
take. It runs in a process of its own, with an interpreter of its own where one is named (`drake_python`).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ModelError
from surefoot.estimation.cube_model import FRICTION, LONGEST_STEP
from surefoot.estimation.toss_model import Parameter, Scene
from surefoot.simulation.drake_python import Worker

WORKER = Path(__file__).with_name("drake_cube_worker.py")


class DrakeCube:
    """Drake's discrete SAP contact, steps of a millisecond.

    Raises
    ------
    MissingExtra
        If Drake cannot be imported, and no other interpreter is named.
    """

    name = "drake"
    parameters = (
        FRICTION,
        Parameter("stiffness", 1e2, 1e6, "N/m", logarithmic=True),
        Parameter("relaxation_time", 1e-4, 1.0, "s", logarithmic=True),
    )

    def __init__(self) -> None:
        self._worker = Worker(WORKER)

    def rollout(self, values: FloatArray, scene: Scene) -> FloatArray:
        """Return (sum of frames, 7) positions [m] and quaternions.

        Raises
        ------
        ModelError
            If the interpreter cannot be run, or its run fails.
        """
        axes, steps = scene.plane.rotation, max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        task = {
            "values": values.tolist(), "starts": scene.starts.tolist(), "frames": scene.frames.tolist(),
            "frame": scene.dt, "dt": scene.dt / steps, "height": scene.plane.height,
            "axes": axes.as_matrix().tolist(), "gravity": scene.gravity, "half": scene.cube.half_side,
            "mass": scene.cube.mass, "inertia": scene.cube.inertia,
        }  # fmt: skip
        poses = np.array(self._worker.ask(task)["poses"], dtype=np.float64).reshape(-1, 7)
        if len(poses) != int(scene.frames.sum()):
            raise ModelError(f"Drake returned {len(poses)} poses instead of {int(scene.frames.sum())}")
        return poses

    def close(self) -> None:
        """End the other process."""
        self._worker.close()
