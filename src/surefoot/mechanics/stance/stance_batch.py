"""Many stances at once, as arrays: candidates of a planner, samples of a study."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_array
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import rotation_from_normal
from surefoot.mechanics.stance.contact import PointContact
from surefoot.mechanics.stance.stance import Stance

_UPRIGHT = 1e-5
"""Share of x that must lie in a surface for it to give the contact frame's heading."""


class StanceBatch:
    """B stances of up to n point contacts each, without bounds on the normal forces.

    Parameters
    ----------
    positions
        (B, n, 3) in world axes [m].
    normals
        (3,) or (B, n, 3) unit normals out of the ground; x of each contact frame is the world's, projected
        into the surface, as in `PointContact`.
    mu
        Friction coefficients [-], a number or broadcastable to (B, n).
    counts
        (B,) how many of the n contacts each stance has [-], from the first one on; all of them unless given.

    Raises
    ------
    ProblemError
        For shapes that do not fit, values that are not finite, normals that are not unit, mu < 0.

    Examples
    --------
    >>> feet = np.array([[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]])
    >>> batch = StanceBatch(feet + np.linspace(0.0, 0.1, 5)[:, None, None], mu=0.6)
    >>> len(batch), batch[0].grasp_map().shape
    (5, (6, 12))
    """

    def __init__(
        self,
        positions: ArrayLike,
        normals: ArrayLike = (0.0, 0.0, 1.0),
        mu: ArrayLike = 0.6,
        counts: ArrayLike | None = None,
    ) -> None:
        self.positions = finite_array("positions", positions, (None, None, 3))
        shape = self.positions.shape[:2]
        given = finite_array("normals", normals)
        if given.shape not in ((3,), (*shape, 3)):
            raise ProblemError(f"normals must have shape (3,) or {(*shape, 3)}, got {given.shape}")
        frames = _frames(given.reshape(-1, 3)).reshape(*given.shape, 3)
        self.rotations: FloatArray = np.ascontiguousarray(np.broadcast_to(frames, (*shape, 3, 3)))
        self.mu = _friction(mu, shape)
        self.counts = _counts(counts, shape)

    def __len__(self) -> int:
        return len(self.positions)

    def __getitem__(self, k: int) -> Stance:
        """Return one stance as an object."""
        own = slice(self.counts[k])
        feet = zip(self.positions[k, own], self.rotations[k, own], self.mu[k, own], strict=True)
        return Stance([PointContact(p, R[:, 2], float(m), heading=R[:, 0]) for p, R, m in feet])

    def groups(self) -> Iterator[tuple[IntArray, int]]:
        """Yield the indices (k,) of the stances with equally many contacts, and that number."""
        for count in np.unique(self.counts):
            yield np.flatnonzero(self.counts == count), int(count)

    @classmethod
    def of(cls, stances: Sequence[Stance]) -> StanceBatch:
        """Return the points of stances (corners for soles) as arrays; bounds are left out."""
        points = [s.points() for s in stances]
        most = max((len(p) for p in points), default=0)
        batch = cls(np.zeros((len(points), most, 3)), mu=0.0, counts=[len(p) for p in points])
        for k, p in enumerate(points):
            if len(p):
                batch.positions[k, : len(p)] = p.positions
                batch.rotations[k, : len(p)] = p.rotations
                batch.mu[k, : len(p)] = p.mu
        return batch


def _friction(mu: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
    """Return (B, n) friction coefficients."""
    given = finite_array("mu", mu)
    try:
        out = np.array(np.broadcast_to(given, shape))
    except ValueError as error:
        raise ProblemError(f"mu must be a number or broadcast to {shape}, got {given.shape}") from error
    if (out < 0.0).any():
        raise ProblemError(f"mu must be >= 0, got {out.min():g}")
    return out


def _counts(counts: ArrayLike | None, shape: tuple[int, ...]) -> IntArray:
    """Return (B,) numbers of contacts."""
    if counts is None:
        return np.full(shape[0], shape[1], dtype=np.int64)
    given = real_array("counts", counts, (shape[0],))
    out = given.astype(np.int64)
    if (out != given).any() or (out < 0).any() or (out > shape[1]).any():
        raise ProblemError(f"counts must be whole numbers from 0 to {shape[1]}")
    return out


def _frames(normals: FloatArray) -> FloatArray:
    """Return (k, 3, 3) contact frames, by the arithmetic of `PointContact`."""
    size = np.sqrt(normals[:, 0] ** 2 + normals[:, 1] ** 2 + normals[:, 2] ** 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = normals / size[:, None]
        x = np.array([1.0, 0.0, 0.0]) - z[:, :1] * z
        length = np.sqrt(x[:, 0] * x[:, 0] + x[:, 1] * x[:, 1] + x[:, 2] * x[:, 2])
        x = x / length[:, None]
    out = np.stack([x, np.cross(z, x), z], axis=-1) + 0.0  # + 0.0 turns -0.0 into 0.0
    for k in np.flatnonzero(~(np.abs(size - 1.0) <= 1e-6) | ~(length >= _UPRIGHT)):
        out[k] = rotation_from_normal(normals[k])  # x lies across the surface, or the normal is none
    return out
