"""Arrays that follow along: Pinocchio's results without copies, and parts of a memory that kernels fill.

What Pinocchio's algorithms left in a `Data` need not be copied: its matrices are views already. Its lists
(one placement, one momentum a joint) hand out one element at a time, two microseconds each; but parts of an
element are views as well, and the elements of a C++ vector lie at equal distances. Such arrays are valid as
long as the `Data` lives: keep it beside them.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError
from surefoot.base.memory import Memory, Remembering


def live_parts(elements: Any, part: str | None = None) -> FloatArray:
    """Return one part of all elements of a list of Pinocchio's `Data`, (count, ...), as it is at any time.

    Parameters
    ----------
    elements
        Such as ``data.oMi`` or ``data.h``, with at least two elements.
    part
        Name of an array that each has, such as ``"rotation"``; None for elements that are arrays themselves.

    Raises
    ------
    ModelError
        If the parts do not lie at equal distances: they are copies then.

    Examples
    --------
    >>> import pinocchio
    >>> from surefoot.mechanics.robot import load_robot
    >>> model = load_robot("go2").model
    >>> data = model.createData()
    >>> places = live_parts(data.oMi, "translation")
    >>> pinocchio.forwardKinematics(model, data, pinocchio.neutral(model))
    >>> bool((places[2] == data.oMi[2].translation).all()), places.shape
    (True, (14, 3))
    """
    views = [np.asarray(one if part is None else getattr(one, part)) for one in elements]
    at = np.array([view.__array_interface__["data"][0] for view in views])
    apart = np.diff(at)
    if len(views) < 2 or (apart != apart[0]).any() or any(view.flags.owndata for view in views):
        raise ModelError(f"Pinocchio's {part or 'elements'} cannot be read in place")
    first = views[0]
    shape, strides = (len(views), *first.shape), (int(apart[0]), *first.strides)
    return np.lib.stride_tricks.as_strided(first, shape, strides, writeable=False)


class Bound(Remembering):
    """What has parts of one memory as attributes, views that `_bind` finds.

    Those of a copy are its own, and so are those of one that goes on from a memory.
    """

    def _bind(self) -> None:
        """Find the parts of the memory."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Become a copy."""
        self.__dict__.update(state)
        self._bind()

    def resume(self, memory: Memory) -> None:
        """See `Remembering`."""
        super().resume(memory)
        self._bind()
