"""Recordings that tests make of MuJoCo's own loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import surefoot as sf

mujoco = pytest.importorskip("mujoco")


def recorded(model: Any, steps: int, data: Any = None, before: Callable[[Any], None] | None = None) -> sf.Log:
    """Return the log of so many steps from the start, or from data, with what is done before each."""
    data = mujoco.MjData(model) if data is None else data
    with sf.record(model, data) as log:
        for _ in range(steps):
            if before is not None:
                before(data)
            mujoco.mj_step(model, data)
    return log
