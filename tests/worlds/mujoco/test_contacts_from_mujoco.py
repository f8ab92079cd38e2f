"""The contact problem of somebody's MuJoCo data, against closed forms and MuJoCo's own step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import surefoot as sf

mujoco = pytest.importorskip("mujoco")
H, MU = 0.002, 0.5
CRATE = """<mujoco><option timestep="0.002" jacobian="{jacobian}"/><worldbody>
  <geom type="{floor}" friction="0.5"/>
  <body pos="0 0 0.1"><freejoint/><geom type="box" size=".2 .2 .1" mass="5" friction="0.5" margin="1e-3"/>
    <body pos="0 0 0.2"><joint name="arm" axis="0 1 0" damping="0.3" limited="true" range="-5 5"/>
      <geom type="capsule" size="0.02 0.1" pos="0 0 0.1" mass="0.3" contype="0" conaffinity="0"/></body>
  </body></worldbody></mujoco>"""
PLANE, BOX = 'plane" size="5 5 1', 'box" size="5 5 1" pos="0 0 -1'


def model_of(floor: str = PLANE, jacobian: str = "dense") -> tuple[Any, Any]:
    model = mujoco.MjModel.from_xml_string(CRATE.format(floor=floor, jacobian=jacobian))
    return model, mujoco.MjData(model)


def step(model: Any, data: Any) -> Any:
    mujoco.mj_forward(model, data)
    contacts = sf.contacts_from_mujoco(model, data)
    found = sf.solve(contacts.problem)
    found.raise_if_failed()
    data.qvel[:] = contacts.velocity(found.forces)
    mujoco.mj_integratePos(model, data.qpos, data.qvel, H)
    return contacts


@pytest.mark.parametrize("floor", [PLANE, BOX])
@pytest.mark.parametrize("jacobian", ["dense", "sparse"])
def test_a_sliding_crate_loses_mu_g_h_in_every_step_and_stops(floor: str, jacobian: str) -> None:
    """A box for a floor is MuJoCo's second geom: the normal still points out of the ground."""
    model, data = model_of(floor, jacobian)
    model.dof_damping[6], model.jnt_limited[0] = 1e6, False  # one rigid body
    data.qvel[0] = 0.3
    for k in range(40):
        contacts = step(model, data)
        wanted = max(0.3 - (k + 1) * MU * 9.81 * H, 0.0)
        assert data.qvel[0] == pytest.approx(wanted, abs=1e-6)
        assert contacts.frames[:, :, 2] == pytest.approx(np.tile([0.0, 0.0, 1.0], (4, 1)), abs=1e-9)
        assert np.linalg.det(contacts.frames) == pytest.approx(1.0)
    assert abs(data.qpos[2] - 0.1) < 1e-9  # nothing sinks


def test_without_contacts_the_step_is_mujocos_own() -> None:
    model, data = model_of()
    data.qpos[2], data.qpos[7] = 1.0, np.radians(5.2)  # in the air, the arm beyond its limit
    data.qvel[:] = np.random.default_rng(0).normal(size=7)
    mujoco.mj_forward(model, data)
    assert data.nefc == 1
    contacts = sf.contacts_from_mujoco(model, data)
    mujoco.mj_step(model, data)
    assert contacts.problem.contacts == 0
    assert contacts.velocity(np.zeros((0, 3))) == pytest.approx(data.qvel, abs=1e-12)


def test_g_is_how_the_contact_points_move_and_G_what_impulses_change() -> None:
    model, data = model_of()
    data.qvel[:] = np.random.default_rng(1).normal(size=7)
    mujoco.mj_forward(model, data)
    contacts = sf.contacts_from_mujoco(model, data)
    before = contacts.positions - data.qpos[:3]
    for k, (frame, arm) in enumerate(zip(contacts.frames, before, strict=True)):
        turn = data.xmat[1].reshape(3, 3) @ data.qvel[3:6]
        wanted = frame.T @ (data.qvel[:3] + np.cross(turn, arm))
        assert contacts.jacobian[3 * k : 3 * k + 3] @ data.qvel == pytest.approx(wanted, abs=1e-9)
    push = np.random.default_rng(2).normal(size=(4, 3))
    change = contacts.velocity(push) - contacts.free
    assert contacts.jacobian @ change == pytest.approx(contacts.problem.G @ push.ravel(), abs=1e-9)


def crates(rows: int) -> tuple[Any, Any]:
    """Return crates on a floor, four contacts each, every third with an arm on a damped joint."""
    crate = (
        '<body pos="{} {} 0.0999"><freejoint/>'
        '<geom type="box" size=".1 .1 .1" mass="{}" friction="0.5"/>{}</body>'
    )
    arm = (
        '<body pos="0 0 .1"><joint axis="1 1 0" damping="0.7"/>'
        '<geom size=".05" pos="0 0 .1" mass="1"/></body>'
    )
    bodies = "".join(
        crate.format(0.3 * k, 0.3 * j, 1 + k + j, arm if (k + j) % 3 == 0 else "")
        for k in range(rows)
        for j in range(rows)
    )
    floor = '<geom type="plane" size="5 5 1" friction="0.5"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{floor}{bodies}</worldbody></mujoco>")
    return model, mujoco.MjData(model)


@pytest.mark.parametrize("rows", [3, 7])
@pytest.mark.sampled(1)
def test_few_and_many_contacts_agree_with_mujocos_own_matrices(rows: int) -> None:
    """Of many the matrices are sparse and the bodies known; MuJoCo's dense inertia tells the same."""
    model, data = crates(rows)
    data.qvel[:] = 0.1 * np.random.default_rng(3).normal(size=model.nv)
    mujoco.mj_forward(model, data)
    contacts = sf.contacts_from_mujoco(model, data)
    problem = contacts.problem
    assert problem.contacts == 4 * rows**2
    assert (problem.factor is not None) == (problem.contacts > 128)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, mass)
    mass += model.opt.timestep * np.diag(model.dof_damping)
    J = contacts.jacobian
    assert contacts.response == pytest.approx(np.linalg.solve(mass, J.T), abs=1e-10)
    assert pytest.approx(J @ np.linalg.solve(mass, J.T), abs=1e-9) == problem.G
    push = np.random.default_rng(4).normal(size=(problem.contacts, 3))
    assert contacts.velocity(push) == pytest.approx(contacts.free + contacts.response @ push.ravel())
    found = sf.solve(problem, tol=1e-8)
    assert found.solved
    if problem.factor is not None:
        assert (problem.factor @ problem.factor.T).toarray() == pytest.approx(problem.G, abs=1e-12)
        alone = sf.solve(sf.ContactProblem(problem.G, problem.g, problem.mu), tol=1e-8)
        assert contacts.velocity(found.forces) == pytest.approx(contacts.velocity(alone.forces), abs=1e-6)


@pytest.mark.parametrize("machines", [2, 140])
def test_a_contact_of_two_links_of_one_machine_moves_by_their_difference(machines: int) -> None:
    body = (
        '<body pos="{} 0 1"><freejoint/><geom size=".05" mass="1"/><body pos="0 0 .1"><joint axis="1 0 0"/>'
        '<geom size=".03" mass=".5"/><body pos=".02 0 .02"><joint axis="0 1 0"/>'
        '<geom size=".03" pos="0 0 -.06" mass=".4"/></body></body></body>'
    )
    bodies = "".join(body.format(0.5 * k) for k in range(machines))
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    contacts = sf.contacts_from_mujoco(model, data)
    assert contacts.problem.contacts == machines
    one, other = np.zeros((2, 3, model.nv))
    for k, geoms in enumerate(contacts.geoms):
        for jacobian, geom in zip((one, other), geoms, strict=True):
            mujoco.mj_jac(model, data, jacobian, None, contacts.positions[k], int(model.geom_bodyid[geom]))
        wanted = contacts.frames[k].T @ (other - one)
        assert contacts.jacobian[3 * k : 3 * k + 3] == pytest.approx(wanted, abs=1e-12)


def test_an_open_contact_may_use_its_gap_and_a_deep_one_is_pushed_out() -> None:
    model, data = model_of()
    for height, rate in ((0.1005, 0.0005 / H), (0.0995, -0.1 * 0.0005 / H)):
        data.qpos[2] = height
        mujoco.mj_forward(model, data)
        contacts = sf.contacts_from_mujoco(model, data)
        assert contacts.gaps == pytest.approx(height - 0.1, abs=1e-9)
        assert contacts.problem.g[2::3] == pytest.approx(contacts.free[2] + rate, abs=1e-9)
    still = sf.contacts_from_mujoco(model, data, pushed_out=0.0)
    assert still.problem.g[2::3] == pytest.approx(still.free[2], abs=1e-9)


def test_what_is_no_mujoco_data_is_refused() -> None:
    model, data = model_of()
    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    for bad in ((None, data), (model, None), (data, model), (other, data)):
        with pytest.raises(sf.ProblemError, match=r"MjModel and its MjData|another model"):
            sf.contacts_from_mujoco(*bad)
    bad_shares: list[Any] = [-0.1, 1.1, np.nan, "x"]
    for share in bad_shares:
        with pytest.raises(sf.ProblemError, match="pushed_out must be"):
            sf.contacts_from_mujoco(model, data, share)
    data.qvel[0] = np.nan
    with pytest.raises(sf.ProblemError, match=r"qvel\[0\] is NaN"):
        sf.contacts_from_mujoco(model, data)
