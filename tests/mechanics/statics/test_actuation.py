"""Standing under torque limits: the equations of motion at rest, an independent LP, and the limits named."""

import numpy as np
import pytest
from scipy.optimize import linprog

import surefoot as sf
from surefoot.base.errors import ProblemError

pin = pytest.importorskip("pinocchio")

from surefoot.base.spatial import GRAVITY  # noqa: E402
from surefoot.mechanics.robot import load_robot, place  # noqa: E402
from surefoot.mechanics.statics import actuation  # noqa: E402


def test_forces_and_torques_hold_the_robot_at_rest(go2):
    """Pinocchio's inverse dynamics with the contact forces as external forces gives the torques."""
    ground = sf.SlopeTerrain(15.0)
    q = place(go2, ground)
    stance = go2.stance(q, mu=0.7, terrain=ground)
    verdict = actuation.can_stand(go2, stance, q)
    assert verdict
    assert verdict.verify()
    model, data = go2.model, go2.model.createData()
    pin.forwardKinematics(model, data, q)
    pin.updateFramePlacements(model, data)
    pushes = [pin.Force.Zero() for _ in range(model.njoints)]
    for contact, force in zip(stance, verdict.by_contact(), strict=True):
        joint = model.frames[model.getFrameId(contact.name)].parentJoint
        world = contact.rotation_world_contact @ force
        at_origin = pin.Force(world, np.cross(contact.position, world))
        pushes[joint] += data.oMi[joint].actInv(at_origin)
    tau = pin.rnea(model, data, q, np.zeros(model.nv), np.zeros(model.nv), pin.StdVec_Force(pushes))
    np.testing.assert_allclose(tau[:6], 0.0, atol=1e-8)
    limits = actuation.torque_limits(go2, q, stance)
    left = (limits.bound - limits.rows @ verdict.stacked).reshape(2, -1)  # of the limits on either side
    np.testing.assert_allclose(left, go2.effort_limits - np.array([tau[6:], -tau[6:]]), atol=1e-8)


@pytest.mark.parametrize("share", [0.3, 0.14, 0.12, 0.1, 0.05])
def test_verdict_agrees_with_a_linear_program(go2, share):
    """Pyramids and torque limits, put to HiGHS with Pinocchio's own Jacobians."""
    stance = go2.stance(mu=0.6)
    verdict = actuation.can_stand(go2, stance, share=share, facets=8)
    exact = actuation.can_stand(go2, stance, share=share)
    assert verdict.verify()
    assert exact.verify()
    assert bool(verdict) <= bool(exact)
    q, model, data = go2.nominal, go2.model, go2.model.createData()
    pin.computeJointJacobians(model, data, q)
    pin.framesForwardKinematics(model, data, q)
    gravity = pin.computeGeneralizedGravity(model, data, q)
    angle = 2.0 * np.pi * np.arange(8) / 8
    rays = np.array([0.6 * np.cos(angle), 0.6 * np.sin(angle), np.ones(8)])
    columns = []
    for contact in stance:
        frame = model.getFrameId(contact.name)
        J = pin.getFrameJacobian(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
        arm = contact.position - data.oMf[frame].translation
        columns.append((J[:3] - pin.skew(arm) @ J[3:]).T @ rays)
    JT = np.hstack(columns)
    limit = share * go2.effort_limits
    truth = linprog(
        np.zeros(JT.shape[1]), A_ub=np.vstack([-JT[6:], JT[6:]]),
        b_ub=np.concatenate([limit - gravity[6:], limit + gravity[6:]]),
        A_eq=JT[:6], b_eq=gravity[:6], bounds=(0, None), method="highs",
    )  # fmt: skip
    assert bool(verdict) == (truth.status == 0)


def test_what_is_possible_for_the_ground_can_be_impossible_for_the_motors(go2):
    stance = go2.stance()
    assert sf.can_stand(stance, go2.com(), go2.mass)
    verdict = actuation.can_stand(go2, stance, share=0.05)
    assert not verdict
    assert any("calf" in name for name in verdict.limiting)
    assert verdict.multipliers.min() >= 0.0
    assert actuation.can_stand(go2, stance).limiting == ()


def test_region_under_torque_limits_is_inside_the_ground_region(go2):
    stance = go2.stance()
    ground = sf.com_region(stance, go2.mass)
    easy, hard, none = (
        sf.com_region(stance, go2.mass, limits=actuation.torque_limits(go2, None, stance, share))
        for share in (1.0, 0.2, 0.02)
    )
    assert easy.area == pytest.approx(ground.area, rel=1e-4)
    assert 0.0 < hard.area < 0.8 * ground.area
    assert max(ground.distance(corner) for corner in hard.inner) < 1e-3  # the tolerance of both
    assert none.empty


def test_flat_feet_carry_moments():
    g1 = load_robot("g1")
    verdict = actuation.can_stand(g1, g1.stance())
    assert verdict
    assert verdict.verify()
    limits = actuation.torque_limits(g1, None, g1.stance())
    assert np.all(limits.rows @ verdict.stacked <= limits.bound)


@pytest.mark.parametrize("name", ["g1", "go2"])
def test_contacts_cannot_pull_the_robot_down(name):
    """G1's program comes to rest beyond what its equations allow (345 N of 327 N); that proves nothing."""
    robot = load_robot(name)
    verdict = actuation.can_stand(robot, robot.stance(place(robot)))
    assert verdict.largest_disturbance([0, 0, 1, 0, 0, 0]) == pytest.approx(robot.mass * GRAVITY, rel=1e-7)


def test_bad_requests_are_named(go2):
    with pytest.raises(ProblemError, match="share"):
        actuation.can_stand(go2, go2.stance(), share=0.0)
