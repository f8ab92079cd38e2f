"""What the stepper reads by address: wrong input is one line, and nothing reads stale memory."""

from __future__ import annotations

import copy
import gc
import pickle
import threading
from typing import Any

import mujoco
import numpy as np
import pytest

import surefoot as sf

from .scenes import arm, box, scene


def _heap(count: int) -> Any:
    return scene(*(box(f"{0.3 * (k % 4)} {0.3 * (k // 4)} 0.1", name=f"box{k}") for k in range(count)))


def _same(stepper: sf.MujocoStepper, data: Any, model: Any, steps: int = 5) -> None:
    """Step a data, and one that starts from its state by a stepper of its own: both go the same way."""
    twin, other = mujoco.MjData(model), sf.MujocoStepper(model)
    twin.qpos[:], twin.qvel[:] = data.qpos, data.qvel
    stepper.reset()
    for _ in range(steps):
        stepper.step(data)
        other.step(twin)
    np.testing.assert_array_equal(data.qpos, twin.qpos)
    np.testing.assert_array_equal(data.efc_force, twin.efc_force)


@pytest.mark.parametrize("wrong", [None, "data.bin", 3, object()])
@pytest.mark.parametrize("call", ["step", "step_first", "step_second", "forward"])
def test_what_is_no_data_is_one_line(wrong: object, call: str) -> None:
    """Each call names what it takes and what it got."""
    stepper = sf.MujocoStepper(scene(box()))
    with pytest.raises(sf.SurefootError, match=f"takes an MjData, got {type(wrong).__name__}"):
        getattr(stepper, call)(wrong)


def test_data_of_another_model_are_refused() -> None:
    """More bodies; as many positions and velocities over other trees; other sensors: never read."""
    model = scene(box())
    stepper = sf.MujocoStepper(model)
    chain = '<body pos="0 0 2">{}<geom size="0.1"/></body>'
    slides = '<joint type="slide" axis="1 0 0"/>' * 3 + '<joint type="ball"/>'
    others = [
        _heap(2), scene(box(), '<body pos="1 0 1"><geom size="0.1"/></body>'), scene(chain.format(slides)),
        scene(box(), extra='<sensor><clock/></sensor>'), scene(arm()),
    ]  # fmt: skip
    assert (others[2].nq, others[2].nv) == (model.nq, model.nv)
    for other in others:
        for call in (stepper.step, stepper.step_second, stepper.forward):
            with pytest.raises(sf.SurefootError, match="of its own model"):
                call(mujoco.MjData(other))
    _same(stepper, mujoco.MjData(model), model)


def test_data_are_reset_copied_and_thrown_away_between_steps() -> None:
    """mj_resetData, mj_copyData, copies and pickles of a data, and data that are freed in between."""
    model = _heap(4)
    stepper, data = sf.MujocoStepper(model), mujoco.MjData(model)
    for turn in range(30):
        data.qvel[:] = np.random.default_rng(turn).normal(size=model.nv)
        for _ in range(3):
            stepper.step(data)
        if turn % 5 == 0:
            mujoco.mj_resetData(model, data)
        elif turn % 5 == 1:
            mujoco.mj_copyData(data, model, copy.copy(data))
        elif turn % 5 == 2:
            data = copy.copy(data)
        elif turn % 5 == 3:
            data = pickle.loads(pickle.dumps(data))
        else:
            data = copy.deepcopy(data)
        gc.collect(1)  # what is new: all that other tests have left takes seconds each time
        _same(stepper, data, model)


def test_a_reset_in_the_midst_of_a_step_and_others_constraints_are_harmless() -> None:
    """What is between the halves: a reset, a copy, the user's own forward call with sparse pyramids."""
    model = _heap(3)
    model.opt.cone, model.opt.jacobian = mujoco.mjtCone.mjCONE_PYRAMIDAL, mujoco.mjtJacobian.mjJAC_SPARSE
    with pytest.warns(UserWarning, match="elliptic"):
        stepper = sf.MujocoStepper(model)
    data = mujoco.MjData(model)
    data.qpos.reshape(3, 7)[:, 2] = 0.0999
    mujoco.mj_forward(model, data)
    assert data.nJ != data.nefc * model.nv
    stepper.step_second(data)  # no first half of ours: done then
    assert stepper.certificate.status.value == "solved"
    stepper.step_first(data)
    mujoco.mj_resetData(model, data)
    stepper.step_second(data)
    data.qpos.reshape(3, 7)[:, 2] = 0.0999
    stepper.step_first(data)
    mujoco.mj_forward(model, data)
    with pytest.raises(sf.SurefootError, match="not those of the stepper's model"):
        stepper.step_second(data)
    # dense pyramids look like rows of ours, but for their kind
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    stepper.step_first(data)
    mujoco.mj_forward(model, data)
    with pytest.raises(sf.SurefootError, match="not those of the stepper's model"):
        stepper.step_second(data)
    for _ in range(60):
        stepper.step(data)
    assert abs(data.qpos[2] - 0.1) < 1e-9


def test_forward_before_the_second_half_takes_nothing_twice() -> None:
    """After forward a second half begins the step anew: a box at rest stays to rounding."""
    model = scene(box())
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    for _ in range(10):
        stepper.forward(data)
        stepper.step_second(data)
    assert abs(data.qpos[2] - 0.1) < 1e-12
    assert np.abs(data.qvel).max() < 1e-12


def test_more_rows_than_room_and_a_full_arena() -> None:
    """Rows come and go by hundreds; where MuJoCo has no memory for them it warns and the step goes on."""
    model = _heap(16)
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    lifted = data.qpos.reshape(16, 7)
    lifted[:, 2] = 5.0
    stepper.step(data)
    lifted[:, 2] = 0.1
    for _ in range(3):
        stepper.step(data)
    assert data.nefc == 16 * 4 * 3
    assert stepper.unsolved == 0
    text = '<mujoco><size memory="{}"/><option cone="elliptic"/><worldbody><geom type="plane" size="9 9 1"/>'
    bodies = "".join(box(f"{0.3 * k} 0 0.0999", name=f"b{k}") for k in range(8))
    for memory in ("6K", "12K", "20K", "40K", "80K"):
        try:
            small = mujoco.MjModel.from_xml_string(text.format(memory) + bodies + "</worldbody></mujoco>")
            data = mujoco.MjData(small)
            stepper = sf.MujocoStepper(small)
            for _ in range(5):
                stepper.step(data)
        except mujoco.FatalError:
            continue  # MuJoCo's own stack is too small
        assert np.isfinite(data.qpos).all()


@pytest.mark.long
def test_models_recompiled_and_freed() -> None:
    """A spec is compiled anew: the old stepper keeps its model alive and refuses the new one's data."""
    floor = '<geom type="plane" size="9 9 1"/>'
    spec = mujoco.MjSpec.from_string(
        f'<mujoco><option cone="elliptic"/><worldbody>{floor}{box()}</worldbody></mujoco>'
    )
    model = spec.compile()
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    stepper.step(data)
    spec.worldbody.add_body(pos=[2, 0, 1]).add_geom(size=[0.1, 0.1, 0.1])
    fresh, moved = spec.recompile(model, data)
    with pytest.raises(sf.SurefootError, match="of its own model"):
        stepper.step(moved)
    kept, old = copy.copy(model), data
    del model, spec, data
    gc.collect()
    for _ in range(5):
        np.ones(10_000)
        stepper.step(old)
    _same(stepper, old, kept)
    sf.MujocoStepper(fresh).step(moved)


def test_a_second_thread_and_a_callback_are_refused() -> None:
    """While a step is at work another call of the same stepper is one line; afterwards it goes on."""
    model = scene(box())
    stepper, one, two = sf.MujocoStepper(model), mujoco.MjData(model), mujoco.MjData(model)
    found: list[str] = []

    def call() -> None:
        try:
            stepper.step(two)
        except sf.SurefootError as error:
            found.append(str(error))

    def control(_model: Any, _data: Any) -> None:
        call()
        other = threading.Thread(target=call)
        other.start()
        other.join()

    mujoco.set_mjcb_control(control)
    try:
        stepper.step(one)
    finally:
        mujoco.set_mjcb_control(None)
    assert len(found) == 2
    assert all("make one for each" in text for text in found)
    call()
    assert len(found) == 2


def test_steppers_of_their_own_run_in_threads() -> None:
    """Four threads, a stepper and a data each: as alone."""
    model = _heap(3)
    alone = mujoco.MjData(model)
    alone.qvel[0] = 2.0
    single = sf.MujocoStepper(model)
    for _ in range(100):
        single.step(alone)
    data = [mujoco.MjData(model) for _ in range(4)]

    def run(one: Any) -> None:
        own = sf.MujocoStepper(model)
        one.qvel[0] = 2.0
        for _ in range(100):
            own.step(one)

    threads = [threading.Thread(target=run, args=(one,)) for one in data]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one in data:
        np.testing.assert_array_equal(one.qpos, alone.qpos)


def test_a_flag_that_is_refused_stays_refused() -> None:
    """Sleeping switched on between steps is refused in every step until it is off again."""
    model = scene(box())
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    stepper.step(data)
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)
    for _ in range(3):
        with pytest.raises(sf.SurefootError, match="sleeping"):
            stepper.step(data)
    model.opt.enableflags = 0
    _same(stepper, data, model)


@pytest.mark.parametrize("step", [0.0, -0.001, float("nan"), float("inf")])
def test_a_time_step_that_is_none_ends_nothing(step: float) -> None:
    """Lost steps are MuJoCo's to handle, as without us: no crash, and no step counts as solved in secret."""
    model = scene(box())
    data, stepper = mujoco.MjData(model), sf.MujocoStepper(model)
    model.opt.timestep = step
    for _ in range(3):
        stepper.step(data)


def test_models_without_joints_and_of_nothing() -> None:
    """No degree of freedom, no constraint, no body."""
    for model in (scene(), scene('<body pos="0 0 0.05"><geom size="0.1"/></body>')):
        data = mujoco.MjData(model)
        stepper = sf.MujocoStepper(model)
        stepper.step(data)
        stepper.forward(data)
        assert data.time == pytest.approx(model.opt.timestep)
