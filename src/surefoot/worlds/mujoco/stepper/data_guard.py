"""What is looked at before compiled code reads a data by its address: whose it is, who else is at work."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import update_wrapper
from typing import Any, Concatenate, ParamSpec, TypeVar

from surefoot.base.errors import ProblemError

P = ParamSpec("P")
Stepper = TypeVar("Stepper", bound=Any)
Result = TypeVar("Result")


class DataGuard:
    """Lets a stepper read data of its model alone, and one thread at a time.

    Attributes
    ----------
    data, address
        The one that was looked at last, and where its struct lies.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._kind, self._model = mujoco.MjData, model
        self._layout = self._layout_of(mujoco.MjData(model))
        self._lock = threading.Lock()
        self.data: Any = None
        self.address, self._signature = 0, 0

    @staticmethod
    def _layout_of(data: Any) -> tuple[int, ...]:
        """Return what two data have in common that are laid out alike."""
        arrays = (
            data.qpos, data.qvel, data.act, data.ctrl, data.M, data.sensordata, data.xpos, data.geom_xpos,
            data.site_xpos, data.ten_length, data.mocap_pos, data.eq_active, data.userdata, data.qDeriv,
        )  # fmt: skip
        return (data.nbuffer, *(array.size for array in arrays))

    def is_new(self, data: Any) -> bool:
        """Return whether a data is not the one looked at last; look at it then.

        Raises
        ------
        ProblemError
            For what is no MjData of the model.
        """
        if not isinstance(data, self._kind):
            raise ProblemError(f"the stepper takes an MjData, got {type(data).__name__}")
        if data is self.data and data._address == self.address and data.signature == self._signature:
            return False
        # a data that was unpickled has no signature
        known = data.signature in (self._model.signature, 0)
        if not known or self._layout_of(data) != self._layout:
            raise ProblemError("the stepper takes an MjData of its own model, got one of another")
        self.data, self.address, self._signature = data, data._address, data.signature
        return True

    def take_turn(self) -> None:
        """Begin a call, which `end_turn` ends.

        Raises
        ------
        ProblemError
            While another call is at work: of another thread, or of a callback.
        """
        if not self._lock.acquire(blocking=False):
            raise ProblemError(
                "this MujocoStepper is at work already, in another thread or in the step that has called "
                "this callback: make one for each"
            )

    def end_turn(self) -> None:
        """End a call."""
        self._lock.release()


def foreign_rows() -> ProblemError:
    """Return what is raised where constraints are not those that the stepper's model makes."""
    return ProblemError(
        "the data's constraints are not those of the stepper's model: a callback, or another thread, has "
        "made them anew with another model in the midst of the step"
    )


def in_turn(
    method: Callable[Concatenate[Stepper, Any, P], Result],
) -> Callable[Concatenate[Stepper, Any, P], Result]:
    """Return a stepper's method of a data that looks at it first, and refuses a second caller at once."""

    def look_first(self: Stepper, data: Any, /, *args: P.args, **kwargs: P.kwargs) -> Result:
        guard: DataGuard = self._guard
        guard.take_turn()
        try:
            if guard.is_new(data):
                self._bind(data)
            return method(self, data, *args, **kwargs)
        finally:
            guard.end_turn()

    update_wrapper(look_first, method)
    return look_first
