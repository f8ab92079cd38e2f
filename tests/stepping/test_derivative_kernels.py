"""Rates of contact velocities, forces and centres against differences of Pinocchio's Jacobians."""

from __future__ import annotations

import numpy as np
import pytest

pin = pytest.importorskip("pinocchio")

from surefoot.robot import load_robot  # noqa: E402
from surefoot.stepping.derivative_kernels import centre_rates, force_rates, velocity_rates  # noqa: E402

POINTS = 5
H = 1e-6


class Scene:
    """Spheres fixed to random bodies; their contact frames turn with the place, as on curved ground."""

    def __init__(self, robot: str, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.model = load_robot(robot).model
        self.data = self.model.createData()
        self.q = pin.randomConfiguration(
            self.model, np.full(self.model.nq, -1.0), np.full(self.model.nq, 1.0)
        )
        self.joints = rng.integers(1, self.model.njoints, POINTS)
        self.local = rng.normal(scale=0.2, size=(POINTS, 3))
        self.radii = rng.uniform(0.0, 0.1, POINTS)
        self.turns = rng.normal(size=(2, POINTS, 3, 3))
        self.frames = np.linalg.qr(rng.normal(size=(POINTS, 3, 3)))[0]
        self.start = self.centres(self.q)
        self.v, self.impulses = rng.normal(size=self.model.nv), rng.normal(size=(POINTS, 3))
        self.impulses[0] = 0.0

    def centres(self, q: np.ndarray) -> np.ndarray:
        pin.computeJointJacobians(self.model, self.data, q)
        return np.array([self.data.oMi[int(j)].act(p) for j, p in zip(self.joints, self.local, strict=True)])

    def at(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return contact velocities J v, generalised forces Jᵀ λ and centres."""
        centres = self.centres(q)
        moved = (centres - self.start)[:, :2]
        frames = self.frames + np.einsum("ck,kcia->cia", moved, self.turns)
        points = centres - self.radii[:, None] * frames[:, :, 2]
        rows = []
        for c, joint in enumerate(self.joints):
            J = pin.getJointJacobian(self.model, self.data, int(joint), pin.ReferenceFrame.WORLD)
            cross = np.array([np.cross(J[3:, k], points[c]) for k in range(self.model.nv)]).T
            rows.append(frames[c].T @ (J[:3] + cross))
        J = np.concatenate(rows)
        return J @ self.v, J.T @ self.impulses.ravel(), centres

    def arguments(self) -> tuple[np.ndarray, ...]:
        points = self.centres(self.q) - self.radii[:, None] * self.frames[:, :, 2]
        nv = self.model.nv
        first = np.empty(nv, dtype=np.int64)
        for joint in self.model.joints[1:]:
            first[joint.idx_v : joint.idx_v + joint.nv] = joint.idx_v
        support = np.zeros((POINTS, nv), dtype=np.bool_)
        for c, joint in enumerate(self.joints):
            for above in list(self.model.supports[int(joint)])[1:]:
                begin = self.model.joints[above].idx_v
                support[c, begin : begin + self.model.joints[above].nv] = True
        twists = np.ascontiguousarray(self.data.J.T)
        return twists, first, support, points, self.radii, self.frames, self.turns


@pytest.mark.parametrize(("robot", "seed"), [("go2", 0), ("go2", 1), ("g1", 2)])
def test_rates_are_those_of_pinocchios_jacobians(robot: str, seed: int) -> None:
    pin.seed(seed)
    scene = Scene(robot, seed)
    arguments = scene.arguments()
    nv = scene.model.nv
    ahead = [scene.at(pin.integrate(scene.model, scene.q, H * e)) for e in np.eye(nv)]
    behind = [scene.at(pin.integrate(scene.model, scene.q, -H * e)) for e in np.eye(nv)]
    wanted = [
        np.stack([(a[i] - b[i]) / (2.0 * H) for a, b in zip(ahead, behind, strict=True)], axis=-1)
        for i in range(3)
    ]
    twists, first, support, points, radii, frames, turns = arguments
    moved = velocity_rates(twists, first, support, points, radii, frames, turns, scene.v)
    turned = force_rates(twists, first, support, points, radii, frames, turns, scene.impulses)
    np.testing.assert_allclose(moved, wanted[0], atol=1e-7 * np.abs(wanted[0]).max())
    np.testing.assert_allclose(turned, wanted[1], atol=1e-7 * np.abs(wanted[1]).max())
    np.testing.assert_allclose(centre_rates(twists, support, points, radii, frames), wanted[2], atol=1e-8)
