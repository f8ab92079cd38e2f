"""A mass on a vertical slide over a half-space, in Drake: here, or in an environment of Drake's own.

Drake's wheel is large and bound to single Python versions, so it may live elsewhere: SUREFOOT_DRAKE_PYTHON
names an interpreter that can import pydrake, and this file's neighbour runs in it.
"""

from __future__ import annotations

import functools
import importlib.util
import json
import os
import subprocess
import sys
from dataclasses import asdict
from pathlib import Path

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ModelError
from surefoot.simulation.drops.task import Drop

PACKAGE, EXTRA = "drake", "drake"
VARIABLE = "SUREFOOT_DRAKE_PYTHON"
WORKER = Path(__file__).with_name("drake_worker.py")


@functools.cache
def present() -> bool:
    """Return whether Drake can be run."""
    other = os.environ.get(VARIABLE)
    if not other:
        return importlib.util.find_spec("pydrake") is not None
    try:
        done = subprocess.run(
            [other, "-c", "import pydrake.multibody.plant"], capture_output=True, timeout=120
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise ModelError(f"{VARIABLE}={other!r} cannot be run: {error}") from error
    if done.returncode:
        raise ModelError(f"{VARIABLE}={other!r} cannot import pydrake")
    return True


def run(drop: Drop) -> tuple[FloatArray, FloatArray]:
    """Return gaps [m] and speeds [m/s] at every step."""
    python = os.environ.get(VARIABLE) or sys.executable
    done = subprocess.run(
        [python, str(WORKER)], input=json.dumps(asdict(drop)), capture_output=True, text=True
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise ModelError(f"Drake's run failed: {last}")
    answer = json.loads(done.stdout)
    return np.array(answer["gaps"]), np.array(answer["speeds"])
