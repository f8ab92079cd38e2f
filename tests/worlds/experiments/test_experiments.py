"""Every world keeps to the closed forms within its own step error, and the judge can say no."""

from __future__ import annotations

import importlib.util
import math

import numpy as np
import pytest

from surefoot.base.errors import ProblemError, SurefootError
from surefoot.base.spatial import GRAVITY
from surefoot.worlds.drake import drake_python
from surefoot.worlds.experiments import EXPERIMENTS, body_experiments, carry_out
from surefoot.worlds.experiments.experiment import Measured, MeasuredQuantity, WorldExperiment, compare

HERE = {
    "rigid": True,
    "mujoco": importlib.util.find_spec("mujoco") is not None,
    "drake": drake_python.present(),
    "bullet": importlib.util.find_spec("pybullet") is not None,
}
QUICK = ("slide", "stick", "roll")
"""What Drake, which answers through a pipe, and Bullet are asked here; `surefoot worlds` asks all."""


@pytest.mark.parametrize("world", HERE)
@pytest.mark.parametrize("name", EXPERIMENTS)
@pytest.mark.sampled(7)
def test_worlds_keep_to_the_closed_forms(name: str, world: str) -> None:
    experiment = EXPERIMENTS[name]
    if not HERE[world]:
        pytest.skip(f"{world} is not here")
    if world in ("drake", "bullet") and name not in QUICK:
        pytest.skip("run by `surefoot worlds`")
    for row in compare(experiment, world):
        assert row.verdict == "agrees", row
        assert np.isfinite(row.value)


def made_up(error: object) -> WorldExperiment:
    """Return an experiment in which a world's value is 1 plus a function of the step."""

    def measure(world: str, dt: float) -> Measured:
        return (MeasuredQuantity("x", "m", 1.0 + error(dt), 1.0),)  # type: ignore[operator]

    return WorldExperiment("made", "", "", measure)


@pytest.mark.parametrize(
    ("error", "verdict"),
    [
        (lambda dt: 3.0 * dt, "agrees"),
        (lambda dt: 2e3 * dt**2, "agrees"),
        (lambda dt: -3.0 * dt + 1e-6, "agrees"),
        (lambda dt: 3.0 * dt + 0.01, "differs"),
        (lambda dt: 1e-4, "differs"),
        (lambda dt: 60.0 * dt, "unresolved"),
        (lambda dt: math.nan, "unresolved"),
        (lambda dt: math.sin(1e5 * dt), "unresolved"),
    ],
)
def test_the_judge_can_say_no(error: object, verdict: str) -> None:
    rows = compare(made_up(error), "rigid")
    assert [row.verdict for row in rows] == [verdict]


def test_a_world_that_fails_is_told_not_raised() -> None:
    def fails(world: str, dt: float) -> Measured:
        raise SurefootError("lost")

    outcome = carry_out(WorldExperiment("x", "", "", fails), ["rigid"])
    assert outcome.failures == {"rigid": "lost"}
    assert not outcome.agrees


@pytest.mark.parametrize("dt", [0.0, -1e-3, math.nan, 1.0])
def test_a_step_that_is_no_step(dt: float) -> None:
    with pytest.raises(ProblemError, match="dt must be"):
        carry_out(EXPERIMENTS["drop"], ["rigid"], dt)


@pytest.mark.skipif(not HERE["mujoco"], reason="MuJoCo is not here")
def test_step_errors_are_those_of_the_scheme() -> None:
    """Semi-implicit Euler falls g t dt / 2 too far: the measured step error is just that."""
    row = compare(EXPERIMENTS["drop"], "mujoco", 1e-3)[0]
    assert row.error == pytest.approx(0.5 * GRAVITY * body_experiments.FALL * 1e-3, rel=1e-9)
    assert row.step_error == pytest.approx(row.error, rel=1e-6)
