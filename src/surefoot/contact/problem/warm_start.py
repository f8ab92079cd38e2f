"""Warm starts across a change of contacts: carry what persisted, start the rest at zero."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, array_of, finite_array
from surefoot.base.errors import ProblemError, shown


def carry_over(forces: ArrayLike, kept: ArrayLike) -> FloatArray:
    """Return the forces to start from after contacts came or went.

    Parameters
    ----------
    forces
        (n, 3) forces of the last solution [N or N s].
    kept
        (m,) whole numbers: which contact each new one was, -1 for none [-].

    Returns
    -------
    FloatArray
        (m, 3) in the unit of `forces`; a contact that is new starts at zero, one that is gone leaves nothing.

    Raises
    ------
    ProblemError
        If a number is out of range.

    Examples
    --------
    >>> carry_over([[0.0, 0.0, 5.0], [1.0, 0.0, 7.0]], [1, -1]).tolist()
    [[1.0, 0.0, 7.0], [0.0, 0.0, 0.0]]
    """
    old = finite_array("forces", forces, (None, 3))
    which = array_of("kept", kept, "iufO", "a list of whole numbers", np.float64)
    if which.ndim != 1 or (which != np.floor(which)).any():
        raise ProblemError(f"kept must be a list of whole numbers, got {shown(kept)}")
    if which.size and (which.min() < -1 or which.max() >= len(old)):
        raise ProblemError(f"kept must be -1 to {len(old) - 1}, got {which.min():g} to {which.max():g}")
    which = which.astype(np.int64)
    start = np.zeros((which.size, 3))
    there = which >= 0
    start[there] = old[which[there]]
    return start
