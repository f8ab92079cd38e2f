"""A mass on a vertical slide over a half-space, in Drake, which this file's neighbour drives."""

from __future__ import annotations

import functools
import json
import subprocess
from dataclasses import asdict
from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ModelError
from surefoot.simulation import drake_python
from surefoot.simulation.drake_python import EXTRA as EXTRA
from surefoot.simulation.drake_python import PACKAGE as PACKAGE
from surefoot.simulation.drops.task import Drop

WORKER = Path(__file__).with_name("drake_worker.py")


@functools.cache
def present() -> bool:
    """Return whether Drake can be run."""
    other = drake_python.named()
    if not other:
        return drake_python.present()
    try:
        done = subprocess.run(
            [other, "-c", "import pydrake.multibody.plant"], capture_output=True, timeout=120
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ModelError(f"{drake_python.VARIABLE}={other!r} cannot be run: {error}") from error
    if done.returncode:
        raise ModelError(f"{drake_python.VARIABLE}={other!r} cannot import pydrake")
    return True


def run(drop: Drop) -> tuple[FloatArray, FloatArray]:
    """Return gaps [m] and speeds [m/s] at every step: (T,)."""
    done = subprocess.run(
        [drake_python.interpreter(), str(WORKER)],
        input=json.dumps(asdict(drop)),
        capture_output=True,
        text=True,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise ModelError(f"Drake's run failed: {last}")
    answer = json.loads(done.stdout)
    return np.array(answer["gaps"]), np.array(answer["speeds"])
