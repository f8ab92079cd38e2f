"""Forces on feet from torques and motion: those that torques were made of, with and without a hidden push."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import real_actuators
from surefoot.records.identification.walk_forces import WalkForces, foot_forces_of
from surefoot.records.identification.walk_motion import walk_rows

DT, ROWS = 0.002, 400


def held(name: str, push: float, noise: float = 0.0) -> tuple[WalkForces, np.ndarray]:
    """What is found of a robot that stands and is pushed for a fifth of the time, and (T, n, 3) truth."""
    robot, random = sf.load_robot(name), np.random.default_rng(3)
    model, data = robot.model, robot.model.createData()
    points, first = robot.contact_points, robot.base_dof
    q = np.tile(robot.nominal, (ROWS, 1))
    gravity = np.array(pinocchio.computeGeneralizedGravity(model, data, robot.nominal))
    rows = walk_rows(robot, q, np.zeros((ROWS, model.nv)), np.zeros((ROWS, robot.joints)), None, DT)
    levers = rows.levers[0].reshape(-1, model.nv)  # (3p, nv)
    change = np.sin(2.0 * np.pi * np.arange(ROWS - 1) / 200.0)[:, None]
    wanted = np.zeros((ROWS - 1, len(points), 3))
    share = robot.mass * GRAVITY / len(points)
    wanted[:, :, 2] = share * (1.0 + 0.2 * change * random.uniform(-1.0, 1.0, len(points)))
    wanted[:, :, :2] = 0.2 * share * random.uniform(-1.0, 1.0, (len(points), 2)) * change[:, :, None]
    # what the base needs besides is no matter of the feet: it is pushed so that it stands still
    torques = gravity[first:] - wanted.reshape(ROWS - 1, -1) @ levers[:, first:]
    torques += noise * random.normal(size=torques.shape)
    needed = np.tile(gravity, (ROWS - 1, 1))
    needed[:, :first] = wanted.reshape(ROWS - 1, -1) @ levers[:, :first]
    needed[100:180, :2] -= push
    rows = rows._replace(tau=torques, needed=needed)
    found = foot_forces_of(robot, rows, real_actuators(robot), np.zeros(13), DT)
    owner = np.asarray(points.foot)
    truth = [wanted[:, owner == k].sum(axis=1) for k in range(len(robot.feet))]
    return found, np.stack(truth, axis=1)


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_forces_are_those_that_torques_were_made_of(name: str) -> None:
    found, truth = held(name, 0.0)
    assert np.abs(found.forces - truth)[10:-10].max() < 0.05


@pytest.mark.parametrize("name", ["go2", "g1"])
def test_a_hidden_push_is_not_taken_for_friction(name: str) -> None:
    """80 N on the base for a fifth of the time leave the forces within what is said of them."""
    found, truth = held(name, 80.0, noise=0.05)
    error = np.abs(found.forces - truth)[10:-10]
    said = np.sqrt(np.diagonal(found.covariance, axis1=2, axis2=3))[10:-10]
    assert error.max() < 8.0
    assert np.mean(error < 3.0 * said) > 0.95
