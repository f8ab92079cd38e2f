"""The symbolic rigid body is Pinocchio's, to round-off, with its derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.errors import ModelError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.robot.contact_points import ContactPoints, contact_points
from surefoot.mechanics.robot.foot import shaped_foot
from surefoot.motion.planning.symbolic.rigid_body import SymbolicBody

casadi = pytest.importorskip("casadi")
pin = pytest.importorskip("pinocchio")
ACCURACY = 1e-12
"""Relative to the largest entry; derivatives likewise."""
KINDS = ("RX", "RY", "RZ", "PX", "PY", "PZ", "RevoluteUnaligned", "PrismaticUnaligned")


def random_model(rng: np.random.Generator, free: bool, links: int = 6) -> tuple[pin.Model, ContactPoints]:
    """A tree of random joints and bodies with a contact sphere on its last body and on its first."""
    model = pin.Model()
    model.gravity.linear = rng.normal(size=3) * 9.81
    parent = 0
    if free:
        parent = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Random(), "base")
        model.appendBodyToJoint(parent, pin.Inertia.Random(), pin.SE3.Random())
    for k in range(links):
        kind = KINDS[int(rng.integers(len(KINDS)))]
        axis = rng.normal(size=3)
        made = getattr(pin, f"JointModel{kind}")
        joint = made(axis / np.linalg.norm(axis)) if kind.endswith("Unaligned") else made()
        # on the last body or on what carries it: depth first, or Pinocchio's derivatives are wrong
        carrier = model.parents[parent] if parent > 1 and rng.random() < 0.3 else parent
        joint = model.addJoint(carrier, joint, pin.SE3.Random(), f"joint{k}")
        model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Random())
        parent = joint
    for name, joint in (("tip", parent), ("root", 1)):
        model.addFrame(pin.Frame(name, joint, pin.SE3.Random(), pin.FrameType.OP_FRAME))
    feet = [shaped_foot(model, name, [tuple(rng.normal(size=3))], 0.03) for name in ("tip", "root")]
    return model, contact_points(model, feet)


def random_state(model: pin.Model, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    q = pin.integrate(model, pin.neutral(model), 0.8 * rng.normal(size=model.nv))
    return q, rng.normal(size=model.nv), rng.normal(size=model.nv)


def the_models() -> list[tuple[str, pin.Model, ContactPoints]]:
    go2, rng = load_robot("go2"), np.random.default_rng(7)
    pin.seed(7)
    made = [(f"random{k}", *random_model(rng, free=k % 2 == 0)) for k in range(6)]
    return [("go2", go2.model, go2.contact_points), *made]


MODELS = the_models()


def near(a: object, b: object) -> None:
    first, second = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    assert np.abs(first - second).max() <= ACCURACY * max(1.0, np.abs(second).max())


@pytest.mark.parametrize(("name", "model", "points"), MODELS, ids=[m[0] for m in MODELS])
def test_inverse_dynamics_and_its_derivatives(name, model, points) -> None:
    body = SymbolicBody(model, points)
    q, way, v, a = (casadi.SX.sym(s, n) for s, n in zip("qwva", (model.nq, *[model.nv] * 3), strict=True))
    effort = body.inverse_dynamics(body.integrate(q, way), v, a)
    rates = casadi.Function("f", [q, way, v, a], [effort, *(casadi.jacobian(effort, x) for x in (way, v, a))])
    rng, data = np.random.default_rng(1), model.createData()
    for _ in range(5):
        state = random_state(model, rng)
        ours = rates(state[0], np.zeros(model.nv), *state[1:])
        by_q, by_v, by_a = pin.computeRNEADerivatives(model, data, *state)
        near(ours[0], pin.rnea(model, data, *state)[:, None])
        near(ours[1], by_q)
        near(ours[2], by_v)
        near(ours[3], np.triu(by_a) + np.triu(by_a, 1).T)


@pytest.mark.parametrize(("name", "model", "points"), MODELS, ids=[m[0] for m in MODELS])
def test_steps_are_pinocchios(name, model, points) -> None:
    body = SymbolicBody(model, points)
    q, way = casadi.SX.sym("q", model.nq), casadi.SX.sym("w", model.nv)
    move = casadi.Function("f", [q, way], [body.integrate(q, way)])
    rng = np.random.default_rng(2)
    for size in (0.0, 1e-9, 1e-3, 0.3, 1.7):
        at, direction, _ = random_state(model, rng)
        step = size * direction / np.linalg.norm(direction)
        near(move(at, step), pin.integrate(model, at, step)[:, None])


@pytest.mark.parametrize(("name", "model", "points"), MODELS, ids=[m[0] for m in MODELS])
def test_points_their_velocities_and_forces(name, model, points) -> None:
    """What forces take off the joints is Jᵀ f, with the J that gives the points' velocities."""
    body, rng = SymbolicBody(model, points), np.random.default_rng(3)
    q, v = casadi.SX.sym("q", model.nq), casadi.SX.sym("v", model.nv)
    forces = casadi.SX.sym("f", 3, len(points))
    normal = rng.normal(size=3)
    normal /= np.linalg.norm(normal)
    seen = casadi.Function(
        "f", [q, v, forces],
        [body.sphere_centres(q), body.point_velocities(q, v, normal),
         body.inverse_dynamics(q, v, v, forces, normal)],
    )  # fmt: skip
    data = model.createData()
    for _ in range(4):
        at, speed, _ = random_state(model, rng)
        pushes = rng.normal(size=(3, len(points)))
        centres, velocities, effort = (np.array(x) for x in seen(at, speed, pushes))
        pin.forwardKinematics(model, data, at, speed)
        pin.computeJointJacobians(model, data, at)
        J = np.zeros((3 * len(points), model.nv))
        for k, (joint, place, radius) in enumerate(
            zip(points.joints, points.places, points.radii, strict=True)
        ):
            pose = data.oMi[int(joint)]
            arm = pose.rotation @ place
            near(centres[:, k], pose.translation + arm)
            full = pin.getJointJacobian(model, data, int(joint), pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            J[3 * k : 3 * k + 3] = full[:3] - pin.skew(arm - radius * normal) @ full[3:]
        near(velocities.T.ravel(), J @ speed)
        near(effort[:, 0], pin.rnea(model, data, at, speed, speed) - J.T @ pushes.T.ravel())


def test_other_joints_are_refused() -> None:
    model = pin.Model()
    model.addJoint(0, pin.JointModelSpherical(), pin.SE3.Identity(), "ball")
    with pytest.raises(ModelError, match="ball is a JointModelSpherical"):
        SymbolicBody(model, contact_points(model, []))
