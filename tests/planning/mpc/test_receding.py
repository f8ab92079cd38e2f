"""A plan moved on in time and read between its knots, against Pinocchio and plain NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.planning.mpc.receding import move_on, torques_between
from surefoot.planning.shooting.state_space import difference, retract
from surefoot.robot import load_robot

N, DT = 4, 0.02
ROBOT = load_robot("go2")


def plan(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    q = np.empty((N + 1, 19))
    q[0] = ROBOT.nominal
    for k in range(N):
        retract(True, q[k], 0.1 * rng.normal(size=18), q[k + 1])
    return q, rng.normal(size=(N + 1, 18)), rng.normal(size=(N, 12))


def between(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    way, out = np.empty(18), np.empty(19)
    difference(True, a, b, way)
    retract(True, a, share * way, out)
    return out


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_plan_moved_on_is_read_between_its_knots(share: float) -> None:
    q, v, u = plan(0)
    moved = q.copy(), v.copy(), u.copy()
    move_on(True, *moved, share, DT)
    last = np.empty(19)
    retract(True, q[-1], share * DT * v[-1], last)
    want_q = [between(q[k], q[k + 1], share) for k in range(N)]
    np.testing.assert_allclose(moved[0], [*want_q, last], atol=1e-12)
    np.testing.assert_allclose(moved[1], [*((1 - share) * v[:-1] + share * v[1:]), v[-1]], atol=1e-12)
    np.testing.assert_allclose(moved[2], [*((1 - share) * u[:-1] + share * u[1:]), u[-1]], atol=1e-12)


def test_torques_between_knots_feed_the_distance_from_the_planned_state_back() -> None:
    rng = np.random.default_rng(1)
    q, v, u = plan(2)
    gains, limits = rng.normal(size=(N, 12, 36)), np.array([np.full(12, -9.0), np.full(12, 9.0)])
    out, off = np.empty(12), np.empty(36)
    for knot, share in ((0, 0.0), (2, 0.7), (N - 1, 1.0)):
        here = between(q[knot], q[knot + 1], 0.2), v[knot] + 0.1
        torques_between(True, here, (q, v, u), gains, knot, share, limits, out)
        difference(True, between(q[knot], q[knot + 1], share), here[0], off[:18])
        off[18:] = here[1] - ((1 - share) * v[knot] + share * v[knot + 1])
        np.testing.assert_allclose(out, np.clip(u[knot] + gains[knot] @ off, -9.0, 9.0), atol=1e-10)
