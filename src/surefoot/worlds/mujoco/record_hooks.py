"""Every step of time that Python asks MuJoCo for, seen while a recording is open.

Functions of the module ``mujoco`` are replaced, also where other modules hold them by their names (``from
mujoco import mj_step``). What C or C++ steps by itself (a viewer's thread, ``mujoco.rollout``) is not seen.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Protocol

from surefoot.worlds.mujoco.record_capture import Scheme
from surefoot.worlds.mujoco.replaced_functions import ReplacedFunctions, Replacement

RESETS = ("mj_resetData", "mj_resetDataKeyframe", "mj_resetDataDebug")
"""Functions that end an episode."""
LOOKS = ("mj_step1", "mj_forward", "mj_forwardSkip")
"""Functions that move no time: what moved before them was not seen."""


class StepWatcher(Protocol):
    """Takes note of what happens to a data."""

    def begin_step(self) -> None:
        """Keep the state that a step of time starts from."""

    def end_step(self, scheme: Scheme | None) -> None:
        """Record a step of time that was made by a scheme, None for the model's own."""

    def look(self) -> None:
        """Compare the clock with what it was after the last step."""

    def end_episode(self) -> None:
        """End the episode: the state was reset."""


class StepHooks:
    """Functions of MuJoCo that tell a watcher what they do to one data."""

    def __init__(self, mujoco: Any, model: Any, data: Any, watcher: StepWatcher) -> None:
        self._mujoco, self._model, self._data, self._watcher = mujoco, model, data, watcher
        self._functions = ReplacedFunctions(mujoco)

    def install(self) -> None:
        """Replace the functions, wherever a module holds them by their names."""
        made: dict[str, Replacement] = {"mj_step": self._step}
        made |= dict.fromkeys(("mj_step2", "mj_Euler", "mj_implicit", "mj_RungeKutta"), self._part)
        made |= dict.fromkeys(LOOKS, self._look) | dict.fromkeys(RESETS, self._reset)
        self._functions.install(made)

    def remove(self) -> None:
        """Put the functions back."""
        self._functions.remove()

    def _step(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        mine, begin, end = self._data, self._watcher.begin_step, self._watcher.end_step

        @wraps(original)
        def mj_step(m: Any, d: Any, nstep: int = 1) -> None:
            if d is not mine:
                original(m, d, nstep)
                return
            for _ in range(nstep):
                begin()
                original(m, d)
                end(None)

        return mj_step

    def _part(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that ends a step whose first part was made before."""
        mine, watcher, kinds = self._data, self._watcher, self._mujoco.mjtIntegrator
        implicit = (int(kinds.mjINT_IMPLICIT), int(kinds.mjINT_IMPLICITFAST))

        def scheme(m: Any) -> Scheme:
            if name == "mj_RungeKutta":
                return Scheme.RK4
            halves = name == "mj_step2" and m.opt.integrator in implicit  # else mj_step2 takes Euler's
            return Scheme.IMPLICIT if name == "mj_implicit" or halves else Scheme.EULER

        @wraps(original)
        def part(m: Any, d: Any, *more: Any, **named: Any) -> None:
            if d is not mine:
                original(m, d, *more, **named)
                return
            watcher.begin_step()
            original(m, d, *more, **named)
            watcher.end_step(scheme(m))

        return part

    def _look(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        mine, watcher = self._data, self._watcher

        @wraps(original)
        def look(m: Any, d: Any, *more: Any, **named: Any) -> None:
            if d is mine:
                watcher.look()
            original(m, d, *more, **named)

        return look

    def _reset(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        mine, watcher = self._data, self._watcher

        @wraps(original)
        def reset(m: Any, d: Any, *more: Any, **named: Any) -> Any:
            out = original(m, d, *more, **named)
            if d is mine:
                watcher.end_episode()
            return out

        return reset
