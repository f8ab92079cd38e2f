"""Free bodies against Pinocchio's dynamics of the same bodies, each in a tree of its own."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from scipy.spatial.transform import Rotation

from surefoot.mechanics.dynamics.free_bodies import FreeFlight, accelerate


def bodies(seed: int, count: int = 2) -> tuple[pinocchio.Model, np.ndarray, np.ndarray, np.ndarray]:
    """Return a model of free bodies with centres of mass aside, their inertias, and a state."""
    rng, model = np.random.default_rng(seed), pinocchio.Model()
    for k in range(count):
        joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), f"b{k}")
        root = rng.normal(size=(3, 3))
        inertia = pinocchio.Inertia(
            rng.uniform(1.0, 3.0), 0.3 * rng.normal(size=3), root @ root.T + np.eye(3)
        )
        model.appendBodyToJoint(joint, inertia, pinocchio.SE3.Identity())
    turns = Rotation.random(count, rng=rng).as_quat()
    q = np.hstack([rng.normal(size=(count, 3)), turns]).ravel()
    masses = np.array([inertia.matrix() for inertia in list(model.inertias)[1:]])
    return model, masses, q, rng.normal(size=6 * count)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("gravity", [9.81, 0.0])
def test_free_bodies_accelerate_by_newton_and_euler(seed: int, gravity: float) -> None:
    model, masses, q, v = bodies(seed)
    model.gravity.linear = np.array([0.0, 0.0, -gravity])
    effort = np.random.default_rng(seed + 10).normal(size=v.size)
    expected = pinocchio.aba(model, model.createData(), q, v, effort)
    light = np.linalg.inv(masses)
    np.testing.assert_allclose(accelerate(q, v, effort, masses, light, gravity), expected, atol=1e-10)
    flight = FreeFlight(model, masses, gravity)
    np.testing.assert_allclose(flight.light, light)
    np.testing.assert_allclose(flight.acceleration(q, v, effort), expected, atol=1e-10)
    coasting = pinocchio.aba(model, model.createData(), q, v, np.zeros(v.size))
    np.testing.assert_allclose(flight.acceleration(q, v), coasting, atol=1e-10)
