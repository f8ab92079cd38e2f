"""Anybody's MuJoCo loop with exact contacts, without an edit: ``with sf.exact_contact() as used:``."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import wraps
from types import TracebackType
from typing import Any, Unpack

from surefoot.base.errors import ProblemError
from surefoot.worlds.mujoco.replaced_functions import ReplacedFunctions
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.mujoco.stepper.certificate import StepperOptions
from surefoot.worlds.mujoco.stepper.stepper import MujocoStepper


class ExactContact:
    """MuJoCo's steps of this thread taken over by steppers; made by `exact_contact`.

    Attributes
    ----------
    steps, unsolved
        Steps that were taken over, and those of them whose constraints MuJoCo solved softly.
    steppers
        One for every model that was stepped.
    """

    def __init__(self, options: StepperOptions) -> None:
        self._mujoco, self._options = import_mujoco(), options
        self._functions = ReplacedFunctions(self._mujoco)
        self._thread, self._inside = 0, False
        self._steppers: dict[int, tuple[Any, MujocoStepper]] = {}

    @property
    def steppers(self) -> list[MujocoStepper]:
        """The steppers so far."""
        return [stepper for _, stepper in self._steppers.values()]

    @property
    def steps(self) -> int:
        """Steps that were taken over."""
        return sum(stepper.steps for stepper in self.steppers)

    @property
    def unsolved(self) -> int:
        """Those whose constraints MuJoCo solved softly."""
        return sum(stepper.unsolved for stepper in self.steppers)

    def __enter__(self) -> ExactContact:
        self._thread = threading.get_ident()
        self._functions.install(
            {
                "mj_step": self._step,
                "mj_step1": self._take_over(MujocoStepper.step_first),
                "mj_step2": self._take_over(MujocoStepper.step_half),
                "mj_forward": self._take_over(MujocoStepper.forward),
            }
        )
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._functions.remove()
        if kind is None and self.steps == 0:
            raise ProblemError(
                "exact_contact took over no step: it sees mujoco.mj_step, mj_step1 and mj_step2 called from "
                "Python in its own thread; loops in C++ (mujoco.rollout, the viewer's own) are out "
                "of its reach"
            )

    def _of(self, model: Any) -> MujocoStepper:
        """Return the stepper of a model."""
        found = self._steppers.get(id(model))
        if found is None:
            # the model is kept, so that no other one gets its number
            found = self._steppers[id(model)] = model, MujocoStepper(model, **self._options)
        return found[1]

    def _theirs(self) -> bool:
        """Return whether a call is not ours to take over: another thread's, or the stepper's own."""
        return self._inside or threading.get_ident() != self._thread

    def _take_over(
        self, method: Callable[[MujocoStepper, Any], None]
    ) -> Callable[[str, Callable[..., Any]], Callable[..., Any]]:
        """Return what replaces a function of a model and a data by a stepper's method."""

        def replace(name: str, original: Callable[..., Any]) -> Callable[..., Any]:
            @wraps(original)
            def function(m: Any, d: Any) -> None:
                if self._theirs():
                    original(m, d)
                    return
                self._inside = True
                try:
                    method(self._of(m), d)
                finally:
                    self._inside = False

            return function

        return replace

    def _step(self, name: str, original: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(original)
        def mj_step(m: Any, d: Any, nstep: int = 1) -> None:
            if self._theirs():
                original(m, d, nstep)
                return
            self._inside = True
            try:
                stepper = self._of(m)
                for _ in range(nstep):
                    stepper.step(d)
            finally:
                self._inside = False

        return mj_step


def exact_contact(**options: Unpack[StepperOptions]) -> ExactContact:
    """Return a context in which MuJoCo's steps from Python have exact contacts.

    ``mujoco.mj_step`` (with `nstep`), the pair ``mj_step1`` and ``mj_step2``, and ``mj_forward`` are taken
    over by a
    `MujocoStepper` for each model, in the thread that enters; what C++ steps by itself (``mujoco.rollout``,
    the
    viewer's thread) is out of reach. On leaving they are put back, after an exception, too.

    Parameters
    ----------
    **options
        restitution, share, soft and tol of `MujocoStepper`.

    Raises
    ------
    ProblemError
        On leaving, where no step was taken over.

    Examples
    --------
    >>> import mujoco
    >>> body = '<body pos="0 0 0.1"><freejoint/><geom type="box" size="0.1 0.1 0.1"/></body>'
    >>> world = f'<worldbody><geom type="plane" size="9 9 1"/>{body}</worldbody>'
    >>> text = f'<mujoco><option cone="elliptic"/>{world}</mujoco>'
    >>> model = mujoco.MjModel.from_xml_string(text)
    >>> data = mujoco.MjData(model)
    >>> with exact_contact() as used:
    ...     mujoco.mj_step(model, data, nstep=100)
    >>> used.steps, used.unsolved, round(float(data.qpos[2]), 9)
    (100, 0, 0.1)
    """
    return ExactContact(options)
