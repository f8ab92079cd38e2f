"""Shared by all tests: MuJoCo is loaded through our own door first, so that it can draw without a screen."""

from __future__ import annotations

import contextlib
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from surefoot.errors import SurefootError
from surefoot.simulation.mujoco import import_mujoco

with contextlib.suppress(SurefootError):  # the tests that need it say so themselves
    import_mujoco()
