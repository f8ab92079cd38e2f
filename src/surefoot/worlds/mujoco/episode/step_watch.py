"""Steps of many MuJoCo data at once, each told to the recorder of its data; of others nobody takes note.

Functions of the module ``mujoco`` are replaced once for all of a process's recorders, as `record_hooks` does
for one: to look for the modules that hold them takes longer than a step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any

from surefoot.worlds.mujoco.episode.contact_recorder import ContactRecorder
from surefoot.worlds.mujoco.replaced_functions import ReplacedFunctions, Replacement

PARTS = ("mj_step2", "mj_Euler", "mj_implicit", "mj_RungeKutta")
"""Functions that end a step whose first part was made before."""


class StepWatch:
    """The recorders of a process by the number of their data, and the functions that tell them."""

    def __init__(self) -> None:
        self._recorders: dict[int, ContactRecorder] = {}
        self._functions: ReplacedFunctions | None = None

    def add(self, recorder: ContactRecorder) -> None:
        """Tell a recorder of the steps of its data from now on."""
        self._recorders[id(recorder.data)] = recorder
        if self._functions is None:
            self._functions = ReplacedFunctions(recorder.mujoco)
            made: dict[str, Replacement] = {"mj_step": self._step}
            self._functions.install(made | dict.fromkeys(PARTS, self._part))

    def remove(self, recorder: ContactRecorder) -> None:
        """Tell a recorder no more; with the last one the functions are put back."""
        if self._recorders.get(id(recorder.data)) is recorder:
            del self._recorders[id(recorder.data)]
        if not self._recorders and self._functions is not None:
            self._functions.remove()
            self._functions = None

    def _step(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        recorders = self._recorders

        @wraps(original)
        def mj_step(m: Any, d: Any, nstep: int = 1) -> None:
            recorder = recorders.get(id(d))
            if recorder is None or recorder.paused or recorder.model is not m:
                original(m, d, nstep)
                return
            for _ in range(nstep):
                original(m, d)
                recorder.take()

        return mj_step

    def _part(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        recorders = self._recorders

        @wraps(original)
        def part(m: Any, d: Any, *more: Any, **named: Any) -> None:
            original(m, d, *more, **named)
            recorder = recorders.get(id(d))
            if recorder is not None and not recorder.paused and recorder.model is m:
                recorder.take()

        return part


WATCH = StepWatch()
"""Of this process."""
