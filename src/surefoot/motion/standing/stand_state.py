"""All that lasts of a stand from one step to the next, as one value."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Arrays, Memory, alike, read_state, write_down


@dataclass(frozen=True, slots=True, eq=False)
class StandState:
    """All that lasts from one step to the next.

    Attributes
    ----------
    integral
        (6,) wrench about the centre of mass that the integral term has taken up [N, N m].
    parts
        Memories of the parts of the controller by name, see `Remembering`; None in the state that a
        controller works on itself.

    Examples
    --------
    >>> import numpy as np
    >>> state = StandState(np.zeros(6))
    >>> StandState.from_arrays(*state.to_arrays()) == state
    True
    """

    integral: FloatArray
    parts: Memory | None = None

    def __eq__(self, other: object) -> bool:
        """Return whether another state is the same to the last bit."""
        return isinstance(other, StandState) and alike(self, other)

    def __hash__(self) -> int:
        """Refuse: a state holds arrays."""
        raise TypeError("a StandState has no hash")

    def to_arrays(self) -> tuple[Arrays, Any]:
        """Return the state as plain arrays by path, and facts that JSON can hold."""
        return write_down(self, KINDS)

    @staticmethod
    def from_arrays(arrays: Arrays, facts: Any) -> StandState:
        """Return the state that `to_arrays` has written down.

        Raises
        ------
        ProblemError
            For arrays and facts that are no such state.
        """
        return read_state(StandState, "a stand", arrays, facts, KINDS)


KINDS: dict[str, type] = {"StandState": StandState}
"""Classes of what a state consists of, by the names that they are written down with."""
