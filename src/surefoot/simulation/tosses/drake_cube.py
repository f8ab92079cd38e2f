"""A tossed cube in Drake: eight small spheres at its corners on a half-space, point contact, SAP.

Drake's own box meets a plane in one point at a time, which rocks; spheres at the corners are what its users
take. It runs in a process of its own, with an interpreter of its own where one is named (`drake_python`).
"""

from __future__ import annotations

import contextlib
import json
import math
import subprocess
from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra, ModelError
from surefoot.estimation.cube_model import FRICTION, LONGEST_STEP
from surefoot.estimation.toss_model import Parameter, Scene
from surefoot.simulation.drake_python import EXTRA, PACKAGE, VARIABLE, interpreter, present

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
        if not present():
            raise MissingExtra(PACKAGE, EXTRA)
        self._worker: subprocess.Popen[str] | None = None

    def rollout(self, values: FloatArray, scene: Scene) -> FloatArray:
        """Return (sum of frames, 7) positions and quaternions.

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
        answer = self._ask(json.dumps(task))
        poses = np.array(answer, dtype=np.float64).reshape(-1, 7)
        if len(poses) != int(scene.frames.sum()):
            raise ModelError(f"Drake returned {len(poses)} poses instead of {int(scene.frames.sum())}")
        return poses

    def _ask(self, line: str) -> list[list[float]]:
        """Return the worker's answer to one line; it lives from task to task."""
        if self._worker is None:
            python = interpreter()
            try:
                self._worker = subprocess.Popen(
                    [python, str(WORKER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
                )
            except OSError as error:
                raise ModelError(f"{VARIABLE}={python!r} cannot be run: {error}") from error
        pipe_in, pipe_out = self._worker.stdin, self._worker.stdout
        assert pipe_in is not None and pipe_out is not None  # noqa: PT018 - asked for
        try:
            pipe_in.write(line + "\n")
            pipe_in.flush()
            answer = json.loads(pipe_out.readline())
        except (BrokenPipeError, json.JSONDecodeError) as error:
            self.close()
            raise ModelError("Drake's process ended before it answered; its message stands above") from error
        if "error" in answer:
            raise ModelError(f"Drake's run failed: {answer['error']}")
        poses: list[list[float]] = answer["poses"]
        return poses

    def close(self) -> None:
        """End the other process."""
        if self._worker is not None:
            for pipe in (self._worker.stdin, self._worker.stdout):
                if pipe is not None:
                    with contextlib.suppress(BrokenPipeError):  # it ended before it read all
                        pipe.close()
            self._worker.wait(timeout=20)
            self._worker = None

    def __del__(self) -> None:
        if getattr(self, "_worker", None) is not None:
            self.close()
