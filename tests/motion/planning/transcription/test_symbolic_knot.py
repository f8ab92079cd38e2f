"""The knot in symbols is the exact step, and rows keep the bounds that they were given."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from surefoot.mechanics.dynamics import MomentumKnot, StepOptions, Stepper
from surefoot.motion.planning.transcription.symbolic_knot import SymbolicKnot, stack_rows

casadi = pytest.importorskip("casadi")


@pytest.mark.parametrize("angle", [0.0, 12.0])
def test_an_exact_step_leaves_nothing_missing(angle: float) -> None:
    """Torques, impulses and states of `dynamics.MomentumKnot`, feet on the ground and above it, at speed."""
    robot, ground, dt = sf.load_robot("go2"), sf.SlopeTerrain(angle), 0.02
    rng = np.random.default_rng(0)
    exact = MomentumKnot(Stepper(robot, ground, StepOptions(dt=dt, order=1)))
    knot = SymbolicKnot(robot, ground, dt)
    forces, torques = casadi.SX.sym("forces", 3, 4), casadi.SX.sym("torques", robot.joints)
    q, v = sf.place(robot, ground), 0.5 * rng.normal(size=18)
    q[2] += 2e-3
    tau = 3.0 * rng.normal(size=12)
    step = exact.step(q, v, tau, 0.5)
    assert step.solved
    assert step.impulses[:, 2].max() > 0.0
    said = casadi.Function(
        "said", [knot.x, knot.after, forces, torques],
        [knot.missing_effort(knot.world(forces), torques), knot.missed_way(), knot.gaps(knot.q),
         knot.point_speeds(knot.q, knot.v_after)],
    )  # fmt: skip
    before, after = np.concatenate([q, v]), np.concatenate([step.q, step.v])
    effort, way, gaps, speeds = (np.array(x) for x in said(before, after, step.impulses.T / dt, tau))
    assert np.abs(effort).max() < 1e-9 * robot.mass * 9.81 / dt
    assert np.abs(way).max() < 1e-12
    assert gaps.ravel() == pytest.approx(step.gaps, abs=1e-12)
    assert speeds.T.ravel() == pytest.approx(step.contacts.J @ step.v, abs=1e-11)


def test_rows_keep_their_bounds() -> None:
    x = casadi.SX.sym("x", 5)
    table = np.arange(6.0).reshape(3, 2)
    rows, (low, high) = stack_rows(
        [(x[:1], 0.0, np.inf), (x[1:3], table, 9.0), (x[3:], [1.0, 2.0], table)], 3
    )
    assert rows.shape == (5, 1)
    assert np.array_equal(low, np.column_stack([np.zeros(3), table, np.ones(3), np.full(3, 2.0)]))
    assert np.array_equal(high[:, 0], np.full(3, np.inf))
    assert np.array_equal(high[:, 1:], np.column_stack([np.full(3, 9.0), np.full(3, 9.0), table]))
