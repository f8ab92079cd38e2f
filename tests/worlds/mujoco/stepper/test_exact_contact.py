"""Loops that nobody edits: what is taken over, counted and put back."""

from __future__ import annotations

import threading

import mujoco
import numpy as np
import pytest
from mujoco import mj_step

import surefoot as sf

from .scenes import box, scene


def test_a_loop_of_mj_step_and_the_pair_are_the_steppers() -> None:
    """mj_step with nstep, held by its own name, and mj_step1 with mj_step2 give what the stepper gives."""
    model = scene(box())
    data = [mujoco.MjData(model) for _ in range(3)]
    for one in data:
        one.qvel[0] = 2.0
    stepper = sf.MujocoStepper(model)
    for _ in range(40):
        stepper.step(data[0])
    with sf.exact_contact() as used:
        mj_step(model, data[1], nstep=40)
        for _ in range(40):
            mujoco.mj_step1(model, data[2])
            mujoco.mj_step2(model, data[2])
    assert (used.steps, used.unsolved) == (80, 0)
    for one in data[1:]:
        np.testing.assert_allclose(one.qpos, data[0].qpos, atol=1e-9)
    assert mujoco.mj_step is mj_step


def test_forward_fills_exact_forces() -> None:
    """mj_forward of a box at rest carries its weight without moving it."""
    model = scene(box())
    data = mujoco.MjData(model)
    with sf.exact_contact():
        mujoco.mj_forward(model, data)
        assert np.abs(data.qacc).max() < 1e-7
        mujoco.mj_step(model, data)


def test_functions_are_put_back_after_an_exception_and_no_step_is_an_error() -> None:
    """Whatever happens inside, MuJoCo is itself again."""
    original = mujoco.mj_step, mujoco.mj_step1, mujoco.mj_step2, mujoco.mj_forward
    with pytest.raises(ValueError, match="of the loop"), sf.exact_contact():
        raise ValueError("of the loop")
    with pytest.raises(sf.SurefootError, match="took over no step"), sf.exact_contact():
        pass
    assert (mujoco.mj_step, mujoco.mj_step1, mujoco.mj_step2, mujoco.mj_forward) == original


def test_other_threads_keep_mujocos_step() -> None:
    """A thread that did not enter steps softly, and is not counted."""
    model = scene(box())
    data, soft = mujoco.MjData(model), mujoco.MjData(model)
    twin = mujoco.MjData(model)
    with sf.exact_contact() as used:
        mujoco.mj_step(model, data)
        other = threading.Thread(target=lambda: mujoco.mj_step(model, soft, nstep=50))
        other.start()
        other.join()
    mujoco.mj_step(model, twin, nstep=50)
    assert used.steps == 1
    np.testing.assert_array_equal(soft.qpos, twin.qpos)


def test_a_recording_sees_the_exact_forces() -> None:
    """``record`` inside the context logs the forces of the exact step."""
    model = scene('<body pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="2"/></body>')
    data = mujoco.MjData(model)
    with sf.exact_contact(), sf.record(model, data) as log:
        for _ in range(20):
            mujoco.mj_step(model, data)
    assert log.arrays["forces"][-1][..., 2].sum() == pytest.approx(2.0 * 9.81, rel=1e-6)
