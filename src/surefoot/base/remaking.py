"""Objects that are copied and sent to other processes as how they were made, and their state.

What an engine or a compiled function holds cannot be pickled; what it was made of can, and so can a state
that is a value. The copy is made anew and goes on from the state, to the last bit.
"""

from __future__ import annotations

from typing import Any

import numpy as np


class Remade:
    """Something that pickle, cloudpickle and deepcopy make anew and put into its state.

    The arguments that it was made with are kept, arrays as copies. A subclass has `state` and `resume`, or
    says by `_lasting` and `_go_on` what else lasts.
    """

    _made_with: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *arguments: Any, **options: Any) -> Any:
        """Keep what it is made with."""
        self = super().__new__(cls)
        self._made_with = tuple(map(_kept, arguments)), {name: _kept(one) for name, one in options.items()}
        return self

    def _lasting(self) -> Any:
        """Return all that lasts, as a value that can be pickled."""
        return self.state  # type: ignore[attr-defined]

    def _go_on(self, lasting: Any) -> None:
        """Go on from what `_lasting` gave."""
        self.resume(lasting)  # type: ignore[attr-defined]

    def __reduce__(self) -> tuple[Any, ...]:
        return remake, (type(self), *self._made_with), (self._lasting(),)

    def __setstate__(self, state: tuple[Any]) -> None:
        self._go_on(*state)


def remake(kind: type, arguments: tuple[Any, ...], options: dict[str, Any]) -> Any:
    """Return an object of a class, made with these arguments."""
    return kind(*arguments, **options)


def _kept(value: Any) -> Any:
    """Return an argument as it is now, whatever its owner writes into it later."""
    return value.copy() if isinstance(value, np.ndarray) else value
