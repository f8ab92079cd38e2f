"""Costs and their slopes against plain NumPy, residual by residual, differentiated by finite differences."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
import scipy.spatial.transform

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.motion.planning.shooting import Costs, FootCost, JointCost, StateCost, TorqueCost
from surefoot.motion.planning.shooting.cost_terms import cost_slopes
from surefoot.motion.planning.shooting.horizon import Horizon
from surefoot.motion.planning.shooting.state_space import difference
from tests.robots import go2

N, DT, MU, H = 2, 0.02, 0.6, 1e-6
rng = np.random.default_rng(3)


def matrix(size: int, rows: int) -> np.ndarray:
    C = np.random.default_rng(size).normal(size=(rows, size))
    return C.T @ C


STATE = {
    "state": StateCost(np.linspace(0.5, 3.0, 36), terminal=np.full(36, 2.0), v=np.linspace(-0.4, 0.5, 18))
}
NONE = StateCost(np.zeros(36))
CASES = {
    "state": Costs(STATE["state"]),
    "torques": Costs(NONE, TorqueCost(0.2, matrix(12, 3), np.linspace(-1.0, 2.0, 12))),
    "slip": Costs(NONE, feet=FootCost(slip=[1.0, 2.0, 0.0, 0.5], width=0.03)),
    "landing": Costs(NONE, feet=FootCost(landing=[1.0, 0.0, 3.0, 0.5], landing_width=0.05)),
    "joint bounds": Costs(NONE, joints=JointCost(2.0, 0.3)),
    "coupling": Costs(NONE, joints=JointCost(coupling=matrix(24, 4))),
    "all": Costs(STATE["state"], TorqueCost(0.1), FootCost(2.0, 0.02, 1.0, 0.05), JointCost(1.0, 1.0)),
}


def motion() -> Horizon:
    """A tumbling robot near the ground."""
    out = Horizon(go2(), N, DT, MU, None)
    draw = np.random.default_rng(0)
    q = pinocchio.integrate(go2().model, go2().nominal, 0.2 * draw.normal(size=18))
    v = 0.5 * draw.normal(size=18)
    out.take(np.tile(q, (N + 1, 1)), np.tile(v, (N + 1, 1)), draw.normal(size=(N, 12)))
    out.q[1] = pinocchio.integrate(go2().model, q, 0.3 * draw.normal(size=18))
    out.q[2] = pinocchio.integrate(go2().model, q, 0.3 * draw.normal(size=18))
    assert out.take(out.q.copy(), out.v.copy(), out.torques.copy())
    return out


def residuals(costs: Costs, k: int, q: np.ndarray, v: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Weighted residuals of one knot, from Pinocchio and SciPy alone."""
    robot, (state, torque, foot, joint) = go2(), costs.tables(go2(), N)
    turned = scipy.spatial.transform.Rotation
    R, wanted = turned.from_quat(q[3:7]).as_matrix(), turned.from_quat(state[1][k, 3:7]).as_matrix()
    e = np.empty(36)
    e[:3], e[3:6] = q[:3] - state[1][k, :3], turned.from_matrix(wanted.T @ R).as_rotvec()
    e[6:18], e[18:] = q[7:] - state[1][k, 7:], v - state[2][k]
    e[18:21], e[21:24] = v[:3] - R.T @ state[2][k, :3], v[3:6] - R.T @ state[2][k, 3:6]
    z = np.r_[e[6:18], e[24:]]
    bounds, weights, C = joint
    x = np.r_[q[7:], v[6:]]
    over = np.maximum(x - bounds[1], 0.0) - np.maximum(bounds[0] - x, 0.0)
    out = [np.sqrt(state[0][k]) * e, np.sqrt(weights) * over]
    if C.size:
        values, vectors = np.linalg.eigh(C)
        out.append(np.sqrt(np.maximum(values, 0.0)) * (vectors.T @ z))
    if k < N:
        values, vectors = np.linalg.eigh(torque[0])
        out.append(np.sqrt(values) * (vectors.T @ (u - torque[1][k])))
        data = robot.model.createData()
        pinocchio.forwardKinematics(robot.model, data, q, v)
        pinocchio.updateFramePlacements(robot.model, data)
        for c, f in enumerate(robot.feet):
            frame, local = data.oMf[f.frame], pinocchio.ReferenceFrame.WORLD
            twist = pinocchio.getFrameVelocity(robot.model, data, f.frame, local)
            centre = frame.act(np.asarray(f.centre))
            gap, point = centre[2] - f.radius, centre - [0.0, 0.0, f.radius]
            speed = twist.linear + np.cross(twist.angular, point)
            near = np.sqrt(1.0 / (1.0 + np.exp(gap / foot[1][[0, 0, 1]])))
            out.append(np.sqrt(foot[0][k, [0, 0, 1], c]) * near * speed)
    return np.concatenate(out)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.sampled(2)
def test_cost_gradient_and_hessian_are_those_of_the_residuals(name: str) -> None:
    costs, at, model = CASES[name], motion(), go2().model
    tables = costs.tables(go2(), N)
    assert at.differentiate(1e-2)
    lx, lxx, lu, luu = cost_slopes(at.floating, at.motion, at.feet, tables)
    total = 0.0
    for k in range(N + 1):
        q, v, u = at.q[k], at.v[k], at.torques[min(k, N - 1)]
        r = residuals(costs, k, q, v, u)
        total += 0.5 * r @ r

        def moved(
            d: np.ndarray, k: int = k, q: np.ndarray = q, v: np.ndarray = v, u: np.ndarray = u
        ) -> np.ndarray:
            return residuals(costs, k, pinocchio.integrate(model, q, d[:18]), v + d[18:36], u + d[36:])

        J = np.array([(moved(H * e) - moved(-H * e)) / (2 * H) for e in np.eye(48)]).T
        np.testing.assert_allclose(lx[k], (J.T @ r)[:36], atol=2e-7 * max(1.0, np.abs(lx[k]).max()))
        full = J.T @ J
        np.testing.assert_allclose(lxx[k], full[:36, :36], atol=1e-6 * max(1.0, np.abs(full).max()))
        if k < N:
            np.testing.assert_allclose(lu[k], (J.T @ r)[36:], atol=2e-7 * max(1.0, np.abs(lu[k]).max()))
            np.testing.assert_allclose(luu[k], full[36:, 36:], atol=1e-6)
    assert at.price(tables) == pytest.approx(total, rel=1e-10)
    assert total > 1e-3


@pytest.mark.parametrize("floating", [True, False])
def test_differences_are_pinocchios_to_first_order(floating: bool) -> None:
    robot = go2() if floating else load_robot("go2", fixed_base=True)
    model = robot.model
    for _ in range(5):
        a = pinocchio.integrate(model, robot.nominal, rng.normal(size=model.nv))
        tangent, back = 1e-5 * rng.normal(size=model.nv), np.empty(model.nv)
        difference(floating, a, pinocchio.integrate(model, a, tangent), back)
        np.testing.assert_allclose(back, tangent, atol=1e-9)


@pytest.mark.parametrize(
    ("costs", "word"),
    [
        (Costs(StateCost(np.ones(35))), "state weights"),
        (Costs(StateCost(-np.ones(36))), "state weights"),
        (Costs(StateCost(np.ones(36), q=np.full(19, np.nan))), "q"),
        (Costs(NONE, TorqueCost(0.0)), "torque weights"),
        (Costs(NONE, TorqueCost(1.0, np.triu(np.ones((12, 12))))), "torque matrix"),
        (Costs(NONE, feet=FootCost(slip=-1.0)), "slip"),
        (Costs(NONE, feet=FootCost(width=0.0)), "width"),
        (Costs(NONE, joints=JointCost(coupling=-np.eye(24))), "coupling"),
    ],
)
def test_costs_that_are_none_are_refused_by_name(costs: Costs, word: str) -> None:
    with pytest.raises(ProblemError, match=word):
        costs.tables(go2(), N)
