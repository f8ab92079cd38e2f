"""Many exact rollouts on threads, a stepper each: what `mujoco.rollout` is for soft contacts."""

from __future__ import annotations

import warnings
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, whole_number
from surefoot.base.errors import ProblemError
from surefoot.worlds.mujoco.spec import import_mujoco


class ExactRollouts(NamedTuple):
    """What n rollouts of T steps came to; from a step on in which MuJoCo lost the state, it is NaN.

    Attributes
    ----------
    states
        (n, T, nstate) after each step, MuJoCo's mjSTATE_FULLPHYSICS.
    sensordata
        (n, T, nsensordata) of each step.
    unsolved
        (n,) steps whose constraints MuJoCo solved softly.
    """

    states: FloatArray
    sensordata: FloatArray
    unsolved: IntArray


class RolloutStepper:
    """What can be stepped on many threads: a base of `MujocoStepper`."""

    model: Any
    unsolved: int
    _made_of: tuple[Any, dict[str, Any]]

    def reset(self) -> None:
        """Forget the last impulses."""
        raise NotImplementedError

    def step(self, data: Any) -> None:
        """Advance the data by a time step."""
        raise NotImplementedError

    def twin(self, **changes: Any) -> Any:
        """Return another stepper of the same model and options, but for changes of these.

        For another thread, or another data.
        """
        model, options = self._made_of
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of pyramids: it was said
            return type(self)(model, **{**options, **changes})  # type: ignore[call-arg]

    def rollout(
        self, states: ArrayLike, controls: ArrayLike | None = None, *, nstep: int | None = None,
        threads: int = 1,
    ) -> ExactRollouts:  # fmt: skip
        """Step from many states under given controls, as ``mujoco.rollout.rollout`` does.

        Each rollout begins without impulses of a step before: it is, to the last bit and with any number of
        threads, what `step` makes of a new data in that state after `reset`.

        Parameters
        ----------
        states
            (n, nstate) or (nstate,) MuJoCo's mjSTATE_FULLPHYSICS: time, qpos, qvel, act, ...
        controls
            (n, T, nu), (T, nu) of all, or None for none.
        nstep
            T; None for as many as there are controls.
        threads
            Steppers that work side by side.

        Raises
        ------
        ProblemError
            For arrays of other shapes, or that are not finite.
        """
        mujoco, model = import_mujoco(), self.model
        size = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
        first = finite_array("states", np.atleast_2d(np.asarray(states, dtype=np.float64)), (None, size))
        given, length = _controls(controls, len(first), int(model.nu), nstep)
        count = min(whole_number("threads", threads, low=1), max(len(first), 1))
        out = ExactRollouts(
            np.full((len(first), length, size), np.nan),
            np.full((len(first), length, int(model.nsensordata)), np.nan), np.zeros(len(first), np.int64),
        )  # fmt: skip
        workers = [_Worker(self.twin(), mujoco) for _ in range(count)]

        def work(k: int) -> None:
            for i in range(k, len(first), count):
                workers[k].roll(first[i], given[i if len(given) > 1 else 0], i, out)

        if count == 1:
            work(0)
        else:
            with ThreadPoolExecutor(count) as pool:
                list(pool.map(work, range(count)))
        return out


class _Worker:
    """A stepper with its data, in one thread."""

    def __init__(self, stepper: RolloutStepper, mujoco: Any) -> None:
        self._stepper, self._mujoco = stepper, mujoco
        self._data = mujoco.MjData(stepper.model)

    def roll(self, state: FloatArray, controls: FloatArray, number: int, out: ExactRollouts) -> None:
        """Fill a rollout's part of the result."""
        mujoco, stepper, data, model = self._mujoco, self._stepper, self._data, self._stepper.model
        spec = mujoco.mjtState.mjSTATE_FULLPHYSICS
        mujoco.mj_resetData(model, data)
        mujoco.mj_setState(model, data, state, spec)
        stepper.reset()
        before = stepper.unsolved
        lost = [int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{what}")) for what in ("QPOS", "QVEL", "QACC")]
        for k in range(out.states.shape[1]):
            data.ctrl[:] = controls[k]
            stepper.step(data)
            if any(data.warning[w].number for w in lost):
                break
            mujoco.mj_getState(model, data, out.states[number, k], spec)
            out.sensordata[number, k] = data.sensordata
        out.unsolved[number] = stepper.unsolved - before


def _controls(controls: ArrayLike | None, count: int, size: int, nstep: int | None) -> tuple[FloatArray, int]:
    """Return controls (count or 1, T, size) and T."""
    length = None if nstep is None else whole_number("nstep", nstep, low=1)
    if controls is None:
        if length is None:
            raise ProblemError("a rollout without controls takes nstep")
        return np.zeros((1, length, size)), length
    given = np.asarray(controls, dtype=np.float64)
    given = finite_array("controls", given[None] if given.ndim == 2 else given, (None, length, size))
    if len(given) not in (1, count):
        raise ProblemError(f"there are controls of {len(given)} rollouts, and {count} states")
    return given, given.shape[1]
