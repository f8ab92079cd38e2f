"""MujocoStepper against closed forms, and against mj_step where that is exact, too."""

from __future__ import annotations

import copy
import warnings
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf

from .scenes import arm, box, row_velocities, scene

INTEGRATORS = ("Euler", "RK4", "implicit", "implicitfast")
STEP = 'cone="elliptic" timestep="0.002"'


def _run(stepper: Any, data: Any, steps: int) -> None:
    for _ in range(steps):
        stepper.step(data)
        assert stepper.certificate.velocity_error <= 1e-8
    assert stepper.unsolved == 0


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_free_motion_is_mujocos(integrator: str) -> None:
    """Without active constraints both steps agree to rounding, motors, damping and a flying body included."""
    motors = '<actuator><position joint="first" kp="40" kv="3"/><motor joint="second" gear="2"/></actuator>'
    flying = box(pos="0 0 5", size="0.1 0.2 0.3")
    sensors = '<sensor><accelerometer site="tip"/><touch site="tip"/></sensor>'
    model = scene(
        arm("-170 170", '<site name="tip" pos="0.4 0 0"/>', damping=0.3), flying,
        option=f'{STEP} integrator="{integrator}"', extra=motors + sensors,
    )  # fmt: skip
    one, two = mujoco.MjData(model), mujoco.MjData(model)
    for data in (one, two):
        data.qvel[:] = np.linspace(-2.0, 3.0, model.nv)
    stepper = sf.MujocoStepper(model)
    for k in range(200):
        for data in (one, two):
            data.ctrl[:] = np.sin(0.05 * k), np.cos(0.07 * k)
        stepper.step(one)
        mujoco.mj_step(model, two)
    assert one.nefc == 0
    for name in ("qpos", "qvel", "qacc", "sensordata", "time"):
        np.testing.assert_allclose(getattr(one, name), getattr(two, name), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("angle", [0.0, 45.0])
def test_sliding_block_stops_where_the_closed_form_says(integrator: str, angle: float) -> None:
    """A block of v0 on mu slides v0²/(2 mu g) - h v0/2, whichever way it faces, and stays upright."""
    model = scene(box(), option=f'{STEP} integrator="{integrator}"')
    data, speed, h = mujoco.MjData(model), 6.0, model.opt.timestep
    way = np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    data.qvel[:2] = speed * way
    _run(sf.MujocoStepper(model), data, 800)
    closed = speed**2 / (2.0 * 0.5 * 9.81) - h * speed / 2.0
    # RK4 moves with the mean velocity of a step, half a step's more than Euler's
    if integrator == "RK4":
        closed += h * speed / 2.0
    assert abs(data.qpos[:2] @ way - closed) < 1e-3 * closed
    assert abs(data.qpos[2] - 0.1) < 1e-8
    assert np.abs(data.qvel).max() < 1e-9


def test_a_slope_holds_without_creep_up_to_the_friction_angle() -> None:
    """On tan(a) < mu nothing moves; on tan(a) > mu the block slides at g (sin a - mu cos a)."""
    for tangent, held in ((0.49, True), (0.51, False)):
        a = np.arctan(tangent)
        model = scene(box(), option=f'{STEP} gravity="{9.81 * np.sin(a)} 0 {-9.81 * np.cos(a)}"')
        data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
        _run(stepper, data, 500)
        if held:
            assert abs(data.qpos[0]) < 1e-12
        else:
            assert data.qvel[0] == pytest.approx(9.81 * (np.sin(a) - 0.5 * np.cos(a)), rel=1e-6)


def test_forces_and_sensors_are_the_exact_ones() -> None:
    """Standing: efc_force sums to the weight, the accelerometer reads g, touch the weight, cfrc_ext, too."""
    touch = '<body pos="0 0 0.1"><freejoint/><geom name="box" type="box" size="0.1 0.1 0.1" mass="2"/>'
    touch += '<site name="sole" type="box" size="0.11 0.11 0.12"/></body>'
    model = scene(touch, extra='<sensor><touch site="sole"/><accelerometer site="sole"/></sensor>')
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    _run(stepper, data, 100)
    weight = 2.0 * 9.81
    force = np.zeros(6)
    total = 0.0
    for k in range(data.ncon):
        mujoco.mj_contactForce(stepper.model, data, k, force)
        total += force[0]
    assert total == pytest.approx(weight, rel=1e-9)
    np.testing.assert_allclose(data.sensordata, [weight, 0.0, 0.0, 9.81], atol=1e-7)
    assert np.abs(data.qacc).max() < 1e-7
    np.testing.assert_allclose(data.qfrc_constraint[:3], [0.0, 0.0, weight], atol=1e-8)
    mujoco.mj_rnePostConstraint(stepper.model, data)
    np.testing.assert_allclose(data.cfrc_ext[1, 3:], [0.0, 0.0, weight], atol=1e-8)
    assert (data.contact.includemargin == 0.0).all()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_limits_equalities_and_dry_joints_hold(integrator: str) -> None:
    """A limit stops a joint, a loop stays closed, a dry joint stays where its torque is too small."""
    loop = '<equality><connect body1="two" body2="rod" anchor="0.4 0 0"/></equality>'
    rod = '<body name="rod" pos="0.9 0 3"><freejoint/><geom size="0.05" contype="0" conaffinity="0"/></body>'
    model = scene(
        arm("-20 20", damping=0.05, dry=0.02), rod, option=f'{STEP} integrator="{integrator}"', extra=loop
    )
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    for _ in range(600):
        stepper.step(data)
        rows = np.array(data.efc_J).reshape(-1, model.nv)[: data.ne]
        if integrator != "RK4":  # there the rows are those of the last stage
            assert np.abs(row_velocities(model, data, rows)).max() < 1e-6 * max(1.0, np.abs(data.qvel).max())
    assert stepper.unsolved == 0
    assert data.qpos[0] < np.deg2rad(20.0) + 1e-6
    # in motion: what one step's curvature makes, over the share that is undone
    mujoco.mj_forward(model, data)
    bend = (model.opt.timestep * np.abs(data.qvel[:2]).sum()) ** 2 * 0.9
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-6 + bend / 0.2


def test_dry_friction_is_a_bound() -> None:
    """A hinge at rest takes what its load asks for, up to the limit, and no more."""
    for load, held in ((0.9, True), (1.1, False)):
        model = scene(arm("-170 170", dry=1.0), option='gravity="0 0 0" cone="elliptic"')
        data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
        data.qfrc_applied[1] = load
        _run(stepper, data, 100)
        assert (abs(data.qvel[1]) < 1e-12) == held
        if held:
            assert data.qfrc_constraint[1] == pytest.approx(-load, abs=1e-9)


def test_what_stays_soft_is_mujocos() -> None:
    """With one contact kept soft the step is mj_step's, at its solver's limit of accuracy."""
    ball = '<body pos="0 0 0.0999"><freejoint/><geom name="rubber_ball" size="0.1" mass="2"/></body>'
    option = 'cone="elliptic" jacobian="dense" tolerance="0" iterations="200" ls_tolerance="1e-12"'
    model = scene(ball, option=option)
    one, two = mujoco.MjData(model), mujoco.MjData(model)
    for data in (one, two):
        data.qvel[:] = [1.0, 0.5, -0.3, 0.0, 2.0, 1.0]
    stepper = sf.MujocoStepper(model, soft="rubber_*")
    for _ in range(300):
        stepper.step(one)
        mujoco.mj_step(model, two)
    np.testing.assert_allclose(one.qvel, two.qvel, atol=1e-9)
    np.testing.assert_allclose(one.qpos, two.qpos, atol=1e-9)


def test_a_soft_contact_beside_a_hard_one_is_mujocos_still() -> None:
    """The soft ball's motion does not change where a box, apart from it, is solved exactly."""
    ball = '<body pos="2 0 0.0999"><freejoint/><geom name="rubber_ball" size="0.1" mass="2"/></body>'
    option = 'cone="elliptic" jacobian="dense" tolerance="0" iterations="200" ls_tolerance="1e-12"'
    model, alone = scene(box(), ball, option=option), scene(ball, option=option)
    one, two = mujoco.MjData(model), mujoco.MjData(alone)
    one.qvel[6:] = two.qvel[:] = [1.0, 0.5, -0.3, 0.0, 2.0, 1.0]
    stepper = sf.MujocoStepper(model, soft="rubber_*")
    for _ in range(200):
        stepper.step(one)
        mujoco.mj_step(alone, two)
    np.testing.assert_allclose(one.qvel[6:], two.qvel, atol=1e-9)
    assert abs(one.qpos[2] - 0.1) < 1e-9


def test_a_spinning_disc_is_stopped_by_its_spin_friction() -> None:
    """A ball that spins on condim 4 loses mu_spin m g / I per second."""
    ball = (
        '<body pos="0 0 0.1"><freejoint/><geom size="0.1" mass="1" condim="4" friction="1 0.005 0"/></body>'
    )
    model = scene(ball, mu=1.0)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    data.qvel[5] = 10.0
    _run(stepper, data, 100)
    inertia = 0.4 * 0.1**2
    assert data.qvel[5] == pytest.approx(10.0 - 0.005 * 9.81 / inertia * data.time, rel=1e-9)


def test_two_coefficients_are_an_ellipse() -> None:
    """A pair with friction 0.8 along x and 0.2 along y brakes each by its own."""
    friction = "0.8 0.2 0.005 0.0001 0.0001"
    pair = f'<contact><pair geom1="floor" geom2="box" friction="{friction}" condim="3"/></contact>'
    for axis in (0, 1):
        model = scene(box(), extra=pair)
        data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
        data.qvel[axis] = 1.0
        _run(stepper, data, 10)
        first = data.contact.frame[0].reshape(3, 3)[1]
        mu = 0.8 if abs(first[axis]) > 0.9 else 0.2
        assert data.qvel[axis] == pytest.approx(1.0 - mu * 9.81 * data.time, rel=1e-6)


def test_restitution_bounces_and_without_it_nothing_does() -> None:
    """A ball that is dropped leaves with the share of its speed, and a dead one stays."""
    ball = '<body pos="0 0 0.6"><freejoint/><geom size="0.1" mass="1"/></body>'
    for share in (0.0, 0.7):
        model = scene(ball)
        data, stepper = mujoco.MjData(model), sf.MujocoStepper(model, restitution=share)
        fastest = up = 0.0
        for _ in range(250):
            stepper.step(data)
            fastest, up = min(fastest, data.qvel[2]), max(up, data.qvel[2])
        assert up == pytest.approx(-share * fastest, rel=0.02, abs=-stepper.tol * fastest)


def test_a_penetration_goes_without_giving_speed() -> None:
    """A box 5 mm in the ground is out by its share a step, and never moves upwards by itself."""
    model = scene(box(pos="0 0 0.095"))
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model, share=0.2)
    depth = 0.005
    for _ in range(30):
        stepper.step(data)
        depth *= 0.8
        assert data.qpos[2] == pytest.approx(0.1 - depth, abs=1e-9)
        assert abs(data.qvel[2]) < stepper.tol * 9.81 * model.opt.timestep


def test_redundant_and_contradicting_rows() -> None:
    """Two welds that say the same share their load; two positions that contradict are told."""
    twice = '<equality><weld body1="box"/><weld body1="box"/></equality>'
    body = '<body name="box" pos="0 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>'
    model = scene(body, extra=twice)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    _run(stepper, data, 50)
    assert np.abs(data.qpos[:3] - [0.0, 0.0, 1.0]).max() < 1e-9
    # a slide that an equality holds at 1 and a limit at most at 0: positions contradict, velocities do not
    rail = '<joint name="rail" type="slide" axis="1 0 0" range="-1 0"/>'
    joint = f'<body pos="0 0 1">{rail}<geom size="0.1"/></body>'
    held = '<equality><joint joint1="rail" polycoef="1 0 0 0 0"/></equality>'
    model = scene(joint, extra=held)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    for _ in range(100):
        stepper.step(data)
    assert np.isfinite(data.qpos).all()
    assert np.abs(data.qvel).max() < 1e-6
    assert stepper.certificate.violation > 0.1


def test_a_lost_state_is_mujocos_to_handle() -> None:
    """NaN in the state resets the data with MuJoCo's own warning, and the stepper goes on."""
    model = scene(box())
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    stepper.step(data)
    data.qvel[0] = np.nan
    stepper.step(data)
    assert data.warning[mujoco.mjtWarning.mjWARN_BADQVEL].number == 1
    _run(stepper, data, 10)


def test_changes_of_the_model_are_followed_and_it_is_not_touched() -> None:
    """Friction, masses, gravity and the time step may be changed between steps."""
    model = scene(box(mu=0.1), mu=0.1)
    before = copy.deepcopy(model)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    data.qvel[0] = 2.0
    _run(stepper, data, 10)
    np.testing.assert_array_equal(model.geom_margin, before.geom_margin)
    assert model.opt.jacobian == before.opt.jacobian
    start = data.qvel[0]
    model.geom_friction[:, 0] = 0.6
    model.opt.timestep, model.opt.gravity[2] = 0.001, -5.0
    _run(stepper, data, 10)
    assert data.qvel[0] == pytest.approx(start - 0.6 * 5.0 * 0.01, rel=1e-9)


def test_pyramids_are_said_once_and_refusals_name_what_is_asked() -> None:
    """The default cone warns; what is not known is refused at construction by its name."""
    with pytest.warns(UserWarning, match="elliptic"):
        sf.MujocoStepper(scene(box(), option=""))
    if hasattr(mujoco.mjtIntegrator, "mjINT_DISCRETE"):  # younger than the oldest MuJoCo that we know
        with pytest.raises(sf.SurefootError, match="discrete"):
            sf.MujocoStepper(scene(box(), option='cone="elliptic" integrator="discrete"'))
    sleeping = '<option cone="elliptic"><flag sleep="enable"/></option>'
    world = f"<mujoco>{sleeping}<worldbody>{box()}</worldbody></mujoco>"
    with pytest.raises(sf.SurefootError, match="sleeping"):
        sf.MujocoStepper(mujoco.MjModel.from_xml_string(world))
    with pytest.raises(sf.SurefootError, match="rubber"):
        sf.MujocoStepper(scene(box()), soft="rubber_*")
    with pytest.raises(sf.SurefootError, match="MjModel, got str"):
        sf.MujocoStepper("model.xml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.MujocoStepper(scene(box()))


def test_another_data_may_be_stepped_in_turn() -> None:
    """Two data of one model, stepped in turn, go as each alone."""
    model = scene(box())
    alone, one, two = (mujoco.MjData(model) for _ in range(3))
    alone.qvel[0] = one.qvel[0] = 3.0
    single, both = sf.MujocoStepper(model), sf.MujocoStepper(model)
    for _ in range(100):
        single.step(alone)
        both.step(one)
        both.step(two)
    np.testing.assert_allclose(one.qpos, alone.qpos, atol=1e-7)
    assert np.abs(two.qvel).max() < 1e-9
