from __future__ import annotations

import numpy as np
import pinocchio
import pytest

from benchmarks.problems.chains import chain
from surefoot.robot import ccrba, centroidal


def relative(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300))


@pytest.mark.parametrize("name", ["go2", "anymal", "g1", "panda"])
@pytest.mark.parametrize("seed", range(3))
def test_three_opinions_agree(make, name, seed):
    robot, rng = make.robot(name), np.random.default_rng(seed)
    q, _ = make.state(robot, rng)
    A, inertia, com = ccrba.composite_momentum_matrix(robot.model, q)
    theirs = centroidal.momentum_matrix(robot, q)
    assert relative(A, theirs) < 1e-9
    assert relative(ccrba.summed_momentum_matrix(robot.model, q), theirs) < 1e-9
    assert relative(inertia, centroidal.centroidal_inertia(robot, q)) < 1e-9
    assert relative(com, centroidal.momentum(robot, q, np.zeros(robot.model.nv)).com) < 1e-9


@pytest.mark.parametrize("links", [1, 10, 60])
def test_chain(links):
    model = chain(links)
    data, rng = model.createData(), np.random.default_rng(0)
    q = pinocchio.integrate(model, pinocchio.neutral(model), rng.normal(size=model.nv))
    theirs = pinocchio.computeCentroidalMap(model, data, q)
    assert relative(ccrba.composite_momentum_matrix(model, q)[0], theirs) < 1e-9
    assert relative(ccrba.summed_momentum_matrix(model, q), theirs) < 1e-9


def test_link_inertia_is_symmetric_and_moves_a_point_mass():
    centre = np.array([1.0, 2.0, 3.0])
    about_origin = ccrba.link_inertia(2.0, centre, np.eye(3), np.zeros((3, 3)))
    assert np.array_equal(about_origin, about_origin.T)
    spin = np.array([0.1, -0.2, 0.3])
    speed = np.cross(spin, centre)
    h = about_origin @ np.concatenate([np.zeros(3), spin])
    assert np.allclose(h, np.concatenate([2.0 * speed, np.cross(centre, 2.0 * speed)]), rtol=1e-12)
