"""The grasp map from raw arrays, for one stance or many."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray, finite_array
from surefoot.errors import ProblemError
from surefoot.spatial import skew


def grasp_map(
    points: ArrayLike, about: ArrayLike = (0.0, 0.0, 0.0), rotations: ArrayLike | None = None
) -> FloatArray:
    """Return the map from forces at points to the wrench about a point; see `Stance.grasp_map`.

    Parameters
    ----------
    points
        (..., n, 3) where the forces act, world axes [m].
    about
        (3,) or (..., 3) point that moments refer to, usually the centre of mass, world axes [m].
    rotations
        (..., n, 3, 3) rotation_world_contact of each force's frame; None for forces in world axes.

    Returns
    -------
    FloatArray
        (..., 6, 3 n): [force; moment about the point] in world axes = map @ stacked forces.

    Raises
    ------
    ProblemError
        For shapes that do not fit or values that are not finite.

    Examples
    --------
    >>> G = grasp_map([[0.2, 0.1, 0.0], [-0.2, -0.1, 0.0]], about=[0.0, 0.0, 0.3])
    >>> G @ [0.0, 0.0, 10.0, 0.0, 0.0, 20.0]  # the heavier foot is behind and to the right
    array([ 0.,  0., 30., -1.,  2.,  0.])
    """
    p, c = finite_array("points", points), finite_array("about", about)
    if p.ndim < 2 or p.shape[-1] != 3:
        raise ProblemError(f"points must have shape (..., n, 3), got {p.shape}")
    if c.shape[-1:] != (3,) or c.shape[:-1] not in ((), p.shape[:-2]):
        raise ProblemError(f"about must have shape (3,) or {(*p.shape[:-2], 3)}, got {c.shape}")
    n = p.shape[-2]
    blocks = np.empty((*p.shape[:-1], 6, 3))  # (..., n, 6, 3)
    blocks[..., :3, :] = np.eye(3)
    blocks[..., 3:, :] = skew(p - c[..., None, :])
    if rotations is not None:
        R = finite_array("rotations", rotations)
        if R.shape != (*p.shape, 3):
            raise ProblemError(f"rotations must have shape {(*p.shape, 3)}, got {R.shape}")
        blocks = blocks @ R
    return np.ascontiguousarray(np.moveaxis(blocks, -3, -2).reshape(*p.shape[:-2], 6, 3 * n))
