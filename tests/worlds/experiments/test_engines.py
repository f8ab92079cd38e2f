"""Engines as they come on scenes with closed forms: the runners put the same scene into each."""

from __future__ import annotations

import importlib.util

import pytest

from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments.engines.defaults import CASES, ENGINES, measured

LIMITS = {
    "rigid": (1e-5, 1e-5, 1e-9, 1e-5, 1e-9),
    "mujoco exact": (4e-3, 4e-3, 1e-9, 5e-3, 1e-9),
    "mujoco tuned": (5e-3, 5e-3, 1e-3, 1.0, 1e-3),
    "bullet": (0.1, 0.1, 1e-3, 0.2, 0.01),
}
"""Largest errors in the order of `CASES`: what is known of an engine, not what is hoped for."""


@pytest.mark.parametrize("engine", LIMITS)
@pytest.mark.long
def test_a_scene_is_the_same_in_every_engine(engine: str) -> None:
    module = {"bullet": "pybullet", "mujoco": "mujoco", "mujoco-exact": "mujoco"}.get(ENGINES[engine].world)
    if module is not None and importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not here")
    for case, limit in zip(CASES, LIMITS[engine], strict=True):
        error, cost = measured(engine, case)
        assert error <= limit, case
        assert cost > 0.0


@pytest.mark.skipif(not drake_python.present(), reason="Drake is not here")
@pytest.mark.parametrize("engine", ["drake hydroelastic", "drake CENIC"])
def test_drakes_boxes_slide(engine: str) -> None:
    assert measured(engine, "slide at 45 deg")[0] < 0.02
