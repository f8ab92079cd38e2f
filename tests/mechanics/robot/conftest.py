"""Robots, random states and stances that several tests share, behind the fixture `make`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from tests.robots import robot_of

HANDS = {"g1": "left_rubber_hand", "panda": "panda_hand_tcp", "go2": "radar", "anymal": "base"}


def random_state(robot: sf.Robot, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a random (q, v): any base pose, joints within one radian of nominal."""
    tangent = rng.uniform(-1.0, 1.0, robot.model.nv)
    if robot.floating:
        tangent[3:6] *= 3.0
    q = pinocchio.integrate(robot.model, robot.nominal, tangent)
    return q, rng.normal(size=robot.model.nv)


def random_unit(rng: np.random.Generator) -> np.ndarray:
    n = rng.normal(size=3)
    return n / np.linalg.norm(n)


def random_stance(robot: sf.Robot, q: np.ndarray, rng: np.random.Generator) -> sf.Stance:
    """Return contacts at every foot and at a hand (or what serves as one), each with a normal of its own."""
    data = robot.model.createData()
    pinocchio.framesForwardKinematics(robot.model, data, q)
    contacts: list[sf.PointContact | sf.SoleContact] = []
    for foot in robot.feet:
        place = data.oMf[foot.frame].act(foot.centre)
        normal, heading = random_unit(rng), random_unit(rng)
        if foot.flat:
            contacts.append(
                sf.SoleContact(place, sf.Sole(*foot.size), normal, name=foot.name, heading=heading)
            )
        else:
            point = place - foot.radius * normal
            contacts.append(sf.PointContact(point, normal, name=foot.name, heading=heading))
    hand = HANDS[robot.name]
    place = data.oMf[robot.model.getFrameId(hand)].act(0.05 * random_unit(rng))
    contacts.append(sf.PointContact(place, random_unit(rng), name=hand))
    return sf.Stance(contacts)


@pytest.fixture(params=[(name, seed) for name in HANDS for seed in range(5)], ids=lambda p: f"{p[0]}-{p[1]}")
def case(request: pytest.FixtureRequest) -> tuple[Any, ...]:
    """Return a robot, a state, a stance and a generator that goes on from there."""
    name, seed = request.param
    robot, rng = robot_of(name), np.random.default_rng(100 + seed)
    q, v = random_state(robot, rng)
    return robot, q, v, random_stance(robot, q, rng), rng


@pytest.fixture(scope="session")
def make() -> SimpleNamespace:
    return SimpleNamespace(robot=robot_of, state=random_state, stance=random_stance)
