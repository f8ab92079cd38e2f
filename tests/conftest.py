"""Shared by all tests: fixed seeds for hypothesis, and MuJoCo loaded so that it can draw without a screen."""

from __future__ import annotations

import contextlib
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from hypothesis import settings

from surefoot.errors import SurefootError
from surefoot.simulation.mujoco import import_mujoco

settings.register_profile("fixed", derandomize=True, deadline=None, database=None)
settings.load_profile("fixed")

with contextlib.suppress(SurefootError):  # the tests that need it say so themselves
    import_mujoco()
