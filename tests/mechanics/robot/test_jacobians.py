from __future__ import annotations

import numpy as np
import pinocchio
import pytest

import surefoot as sf
from surefoot.base.errors import ModelError
from surefoot.mechanics.robot.jacobians import (
    REFERENCES,
    Baumgarte,
    attach,
    contact_drift,
    contact_error,
    contact_jacobian,
)
from tests.mechanics.robot.constraints import relative

STEP = 1e-6
"""Finite differences are central with this step: error about STEP**2 + 1e-16 / STEP, relative 1e-9."""
FD = 2e-8


def moved(robot, q, v, dt):
    return pinocchio.integrate(robot.model, q, dt * v)


def point_velocity(robot, q, v, points):
    """The points' velocities in contact axes by finite differences of their positions."""
    return (
        contact_error(robot, moved(robot, q, v, STEP), points)
        - contact_error(robot, moved(robot, q, v, -STEP), points)
    ) / (2 * STEP)


def test_jacobian_is_the_derivative_of_the_contacts_place(case):
    robot, q, v, stance, _ = case
    points = attach(robot, q, stance)
    assert np.abs(contact_error(robot, q, points)).max() < 1e-12
    assert relative(contact_jacobian(robot, q, stance) @ v, point_velocity(robot, q, v, points)) < FD


@pytest.mark.parametrize("reference", ["local", "world", "local_world_aligned"])
def test_jacobian_of_a_frame_is_pinocchios(case, reference):
    robot, q, _, _, _ = case
    kind = getattr(pinocchio.ReferenceFrame, reference.upper())
    for frame in list(robot.model.frames)[2::7]:
        place = robot.model.createData()
        pinocchio.framesForwardKinematics(robot.model, place, q)
        index = robot.model.getFrameId(frame.name)
        contact = sf.SoleContact(place.oMf[index].translation, sf.Sole(0.1, 0.1), name=frame.name)
        ours = contact_jacobian(robot, q, sf.Stance([contact]), reference)
        theirs = pinocchio.computeFrameJacobian(robot.model, place, q, index, kind)
        if reference == "world":
            theirs = pinocchio.getFrameJacobian(robot.model, robot.data, index, kind)
        assert np.abs(ours - theirs).max() < 1e-12


@pytest.mark.parametrize("reference", REFERENCES)
def test_drift_against_finite_differences_of_the_contact_velocity(case, reference):
    robot, q, v, stance, _ = case
    points = attach(robot, q, stance)
    ahead = contact_jacobian(robot, moved(robot, q, v, STEP), points, reference) @ v
    behind = contact_jacobian(robot, moved(robot, q, v, -STEP), points, reference) @ v
    assert relative(contact_drift(robot, q, v, points, reference), (ahead - behind) / (2 * STEP)) < FD


def test_rolling_drift_follows_the_lowest_point_of_the_sphere(make):
    robot, rng = make.robot("go2"), np.random.default_rng(5)
    q, v = make.state(robot, rng)
    points = attach(robot, q, robot.stance(q))

    def lowest_point_velocity(dt):
        now = moved(robot, q, v, dt)
        return contact_jacobian(robot, now, robot.stance(now)) @ v

    numeric = (lowest_point_velocity(STEP) - lowest_point_velocity(-STEP)) / (2 * STEP)
    rolling = contact_drift(robot, q, v, points, rolling=True)
    assert relative(rolling, numeric) < FD
    assert relative(contact_drift(robot, q, v, points), numeric) > 1e-3


def test_rolling_is_refused_in_turning_axes(make):
    robot = make.robot("go2")
    with pytest.raises(sf.ProblemError, match="rolling needs reference"):
        contact_drift(robot, robot.nominal, np.zeros(18), robot.stance(), "local", rolling=True)


def test_baumgarte_pulls_the_error_back():
    wanted = Baumgarte(20.0, 0.5).acceleration(np.full(3, 2.0), np.full(3, 0.1))
    assert np.allclose(wanted, -20.0 * 2.0 - 400.0 * 0.1)
    with pytest.raises(sf.ProblemError, match="frequency"):
        Baumgarte(-1.0)


def test_corners_of_a_patch_belong_to_its_frame(make):
    robot = make.robot("g1")
    stance = robot.stance()
    J = contact_jacobian(robot, robot.nominal, stance.points())
    patch = contact_jacobian(robot, robot.nominal, stance)
    corner, centre = stance.points().contacts[0], stance.contacts[0]
    R = centre.rotation_world_contact
    arm = R.T @ (corner.position - centre.position)
    assert np.abs(J[:3] - (patch[:3] - np.cross(arm[:, None], patch[3:6], axis=0))).max() < 1e-12


def test_short_names_of_feet_are_understood(make):
    robot = make.robot("go2")
    short = sf.Stance([sf.PointContact(c.position, name=c.name.split("_")[0]) for c in robot.stance()])
    assert np.array_equal(
        contact_jacobian(robot, robot.nominal, short),
        contact_jacobian(robot, robot.nominal, robot.stance()),
    )


def test_unknown_names_are_told(make):
    robot = make.robot("go2")
    with pytest.raises(sf.ProblemError, match="unknown reference 'body'; valid names: contact, local"):
        contact_jacobian(robot, robot.nominal, robot.stance(), "body")
    with pytest.raises(ModelError, match="unknown frame of go2 'wheel'"):
        contact_jacobian(robot, robot.nominal, sf.Stance([sf.PointContact([0, 0, 0], name="wheel")]))
