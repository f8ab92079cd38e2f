"""Rollouts on threads: to the last bit what one stepper makes of one state after the other."""

from __future__ import annotations

import warnings
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco import rollout

import surefoot as sf
from surefoot.base.errors import ProblemError

from .scenes import arm, box, scene

SPEC = mujoco.mjtState.mjSTATE_FULLPHYSICS
DRIVEN = '<actuator><motor joint="first" gear="4"/></actuator><sensor><jointvel joint="second"/></sensor>'


def pair() -> Any:
    """Return an arm over a floor with two boxes, driven and sensed."""
    return scene(box(), box("0.05 0 0.31", name="top"), arm("-60 60"), extra=DRIVEN)


def starts(model: Any, count: int) -> np.ndarray:
    """Return states with other velocities each."""
    data, rng, out = mujoco.MjData(model), np.random.default_rng(4), []
    for _ in range(count):
        data.qvel[:] = 0.5 * rng.normal(size=model.nv)
        out.append(np.zeros(mujoco.mj_stateSize(model, SPEC)))
        mujoco.mj_getState(model, data, out[-1], SPEC)
    return np.array(out)


@pytest.mark.parametrize("threads", [1, 3])
def test_rollouts_are_steps_to_the_last_bit(threads: int) -> None:
    model = pair()
    states, controls = starts(model, 7), np.random.default_rng(1).normal(size=(7, 60, 1))
    stepper = sf.MujocoStepper(model, share=0.1)
    found = stepper.rollout(states, controls, threads=threads)
    one, here = sf.MujocoStepper(model, share=0.1), np.zeros_like(states[0])
    for i in range(7):
        data = mujoco.MjData(model)
        mujoco.mj_setState(model, data, states[i], SPEC)
        one.reset()
        for k in range(60):
            data.ctrl[:] = controls[i, k]
            one.step(data)
            mujoco.mj_getState(model, data, here, SPEC)
            assert found.states[i, k].tobytes() == here.tobytes(), (i, k)
            assert found.sensordata[i, k].tobytes() == data.sensordata.tobytes()
    assert found.unsolved.sum() == one.unsolved
    assert stepper.steps == 0  # it was others that stepped


def test_without_contacts_it_is_mujocos_own_rollout() -> None:
    """An arm in the air, one control for all, against MuJoCo's compiled loop."""
    model = scene(arm("-60 60"), extra=DRIVEN)
    states, controls = starts(model, 3), 0.1 * np.ones((50, 1))
    found = sf.MujocoStepper(model).rollout(states, controls, threads=2)
    data = mujoco.MjData(model)
    expected, sensed = rollout.rollout(model, data, states, controls[None])
    np.testing.assert_allclose(found.states, expected, atol=1e-10)
    np.testing.assert_allclose(found.sensordata, sensed, atol=1e-9)
    assert found.unsolved.tolist() == [0, 0, 0]


def test_changes_of_the_model_are_in_the_rollouts_and_pyramids_are_said_once() -> None:
    model = scene(box(), option='cone="pyramidal"')
    with pytest.warns(UserWarning, match="pyramidal"):
        stepper = sf.MujocoStepper(model)
    states = starts(model, 2)
    model.opt.gravity[:] = (0.0, 0.0, -1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = stepper.rollout(states, nstep=2, threads=2)
    fell = found.states[:, :, 1 + 7 + 2] - states[:, None, 1 + 7 + 2]
    np.testing.assert_allclose(fell[states[:, 10] > 0.1, 0], -0.002, rtol=1e-6)


def test_a_state_that_is_lost_is_no_number_from_then_on() -> None:
    model = scene(box())
    states = starts(model, 2)
    states[1, 8] = 1e9  # m/s
    states[1, 9:14] = 1e12
    found = sf.MujocoStepper(model).rollout(states, nstep=5)
    assert np.isfinite(found.states[0]).all()
    assert np.isnan(found.states[1, -1]).all()


def test_other_shapes_are_refused() -> None:
    model = pair()
    stepper, states = sf.MujocoStepper(model), starts(model, 2)
    for arguments, told in (
        ((states[:, :-1], np.zeros((4, 1))), "states must have shape"),
        ((states, np.zeros((4, 2))), "controls must have shape"),
        ((states, np.zeros((3, 4, 1))), "controls of 3 rollouts, and 2 states"),
        ((states,), "takes nstep"),
        ((np.full_like(states, np.nan), np.zeros((4, 1))), "states"),
        ((states, np.full((4, 1), np.inf)), "controls"),
    ):
        with pytest.raises(ProblemError, match=told):
            stepper.rollout(*arguments)
    with pytest.raises(ProblemError, match="threads"):
        stepper.rollout(states, np.zeros((4, 1)), threads=0)
