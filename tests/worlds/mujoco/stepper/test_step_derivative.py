"""Derivatives of an exact step against central differences of whole steps."""

from __future__ import annotations

import copy
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray

from .scenes import arm, box, scene

DIFFERENCE = 1e-5
INTEGRATORS = ("Euler", "implicit", "implicitfast")


def _stepped(model: Any, data: Any, change: FloatArray, factor: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return positions and velocities after a step from a changed state (2 nv + na) and control."""
    nv, na, twin = model.nv, model.na, copy.copy(data)
    scaled = copy.copy(model)
    scaled.geom_friction[:] *= factor
    mujoco.mj_integratePos(model, twin.qpos, change[:nv], 1.0)
    twin.qvel[:] += change[nv : 2 * nv]
    twin.act[:] += change[2 * nv : 2 * nv + na]
    twin.ctrl[:] += change[2 * nv + na :]
    stepper = sf.MujocoStepper(scaled, tol=1e-12)
    stepper.step(twin)
    assert stepper.certificate.velocity_error < 1e-6
    return twin.qpos.copy(), np.concatenate([twin.qvel, twin.act])


def _difference(model: Any, data: Any, change: FloatArray, factor: float = 0.0) -> FloatArray:
    """Return the central difference of a step along a change of state and control, or of friction."""
    (q, v), (p, u) = (
        _stepped(model, data, sign * DIFFERENCE * change, 1.0 + sign * DIFFERENCE * factor)
        for sign in (1.0, -1.0)
    )
    way = np.zeros(model.nv)
    mujoco.mj_differentiatePos(model, way, 1.0, p, q)
    return np.concatenate([way, v - u]) / (2.0 * DIFFERENCE)


def _agrees(model: Any, data: Any, kinks: int = 0) -> None:
    """Compare all columns, over the size of the matrix they are in."""
    found = sf.MujocoStepper(model).derivative(data)
    assert found.kinks == kinks
    n, nu = 2 * model.nv + model.na, model.nu
    for name, first, count in (("A", 0, n), ("B", n, nu)):
        matrix = getattr(found, name)
        for i in range(count):
            change = np.zeros(n + nu)
            change[first + i] = 1.0
            error = np.abs(matrix[:, i] - _difference(model, data, change)).max()
            assert error < 1e-5 * max(1.0, np.abs(matrix).max()), (name, i)
    friction = _difference(model, data, np.zeros(n + nu), 1.0)
    np.testing.assert_allclose(found.friction, friction, atol=1e-5 * max(1.0, np.abs(friction).max()))


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("speed", [0.0, 2.0])
def test_a_box_that_sticks_or_slides(integrator: str, speed: float) -> None:
    """Sunk by different depths at its corners, pressed and pushed; sliding, too, by friction's factor."""
    model = scene(box(), option=f'cone="elliptic" integrator="{integrator}"')
    data = mujoco.MjData(model)
    data.qpos[2] -= 3e-4
    data.qvel[:2] = speed, 0.3 * speed
    data.xfrc_applied[1, :2] = 0.5, 0.2
    _agrees(model, data)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_an_arm_on_its_limit(integrator: str) -> None:
    """A limit that is passed, a motor and a filtered actuator, damping and dry friction that slips."""
    motors = (
        '<actuator><motor joint="first" gear="2"/><general joint="second" dyntype="filter" dynprm="0.05" '
        'gainprm="3"/></actuator>'
    )
    option = f'cone="elliptic" integrator="{integrator}"'
    model = scene(arm("-20 20", damping=0.3), option=option, extra=motors)
    model.dof_frictionloss[1] = 0.02
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (np.deg2rad(20.0) + 1e-3, -0.3), (0.4, -1.5)
    data.ctrl[:], data.act[:] = (0.7, -0.4), 0.2
    _agrees(model, data)


def test_a_standing_robot() -> None:
    """Go2 on its feet, sunk a little: position, velocity, torques and friction."""
    world = sf.MujocoWorld(sf.load_robot("go2"), mu=0.7)
    model, data = copy.copy(world.model), copy.copy(world.data)
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    for _ in range(3):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    lowest = data.contact.dist.min() if data.ncon else 0.0
    data.qpos[2] -= lowest + 2e-4
    data.qvel[:] = np.random.default_rng(3).normal(scale=0.05, size=model.nv)
    _agrees(model, data)


def test_at_rest_it_is_that_of_bodies_in_contact() -> None:
    """A kink is counted, and the side is said: a resting box neither falls nor lifts."""
    model = scene(box())
    data = mujoco.MjData(model)
    found = sf.MujocoStepper(model).derivative(data)
    assert found.kinks > 0
    assert np.abs(found.A[model.nv + 2]).max() < 1e-6
    before = data.qpos.copy()
    np.testing.assert_array_equal(data.qpos, before)


def test_free_motion_is_mujocos_own() -> None:
    """Without contacts A and B are those of mjd_transitionFD."""
    model = scene(arm("-170 170", damping=0.2), extra='<actuator><motor joint="first"/></actuator>')
    data = mujoco.MjData(model)
    data.qvel[:] = 1.0, -2.0
    found = sf.MujocoStepper(model).derivative(data)
    A, B = np.zeros((4, 4)), np.zeros((4, 1))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, A, B, None, None)
    np.testing.assert_allclose(found.A, A, atol=1e-7)
    np.testing.assert_allclose(found.B, B, atol=1e-7)


def test_what_has_no_derivative_says_so() -> None:
    """RK4 and soft contacts are refused by name."""
    model = scene(box(), option='cone="elliptic" integrator="RK4"')
    with pytest.raises(sf.SurefootError, match="RK4"):
        sf.MujocoStepper(model).derivative(mujoco.MjData(model))
    model = scene(box())
    with pytest.raises(sf.SurefootError, match="soft"):
        sf.MujocoStepper(model, soft="box").derivative(mujoco.MjData(model))
