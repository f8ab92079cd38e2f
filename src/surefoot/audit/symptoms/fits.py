"""Models of how a logged force may differ from the true one."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray


def rotation_between(true: FloatArray, logged: FloatArray) -> FloatArray:
    """Return the rotation R that makes R true come closest to logged: (3, 3), of (m, 3) rows (Kabsch)."""
    known = np.isfinite(true).all(axis=1)
    U, _, V = np.linalg.svd(logged[known].T @ true[known])
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(U @ V))])
    return np.asarray(U @ turn @ V)


def best_shift(true: FloatArray, logged: FloatArray, most: int, core: slice) -> tuple[float, int]:
    """Return the share of the mismatch explained by the best shift in time, and its rows (late: positive).

    Parameters
    ----------
    true, logged
        (T, 3) with the surroundings of the episode.
    most
        Largest shift that is tried.
    core
        The episode.
    """
    known = np.nan_to_num(true)
    amiss = float(((logged - known)[core] ** 2).sum())
    if amiss <= 0.0:
        return 0.0, 0
    best = (0.0, 0)
    for shift in range(-most, most + 1):
        start, stop = core.start - shift, core.stop - shift
        if start < 0 or stop > len(known):
            continue
        share = 1.0 - float(((logged[core] - known[start:stop]) ** 2).sum()) / amiss
        best = max(best, (share, shift))
    return best
