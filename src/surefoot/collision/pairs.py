"""Which solids are near each other, and where they touch: broad phase by boxes, narrow phase by coal."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.arrays import FloatArray, IntArray
from surefoot.collision.manifold import manifolds
from surefoot.collision.shapes import Shape, coal
from surefoot.collision.solids import Geometry
from surefoot.kernels import kernel

FAR = 1e3
"""Gap of a contact whose solids are not near each other [m]."""
PRECISION = 1e-10
"""Of coal's distances [m]."""
VAGUE = 1e-6
"""Distance of two sharp shapes below which its direction is not to be trusted [m]."""
INSET = 1e-5
"""By how much smaller shapes tell it then [m]."""


class PairSearch:
    """Finds the contacts of a geometry's pairs; every pair has slots of its own for them, near or not.

    One per thread: it keeps its work arrays.

    Parameters
    ----------
    geometry
        The solids.
    reach
        Distance of two solids' bounding boxes up to which they are looked at [m].

    Attributes
    ----------
    pair
        (p,) index into `Geometry.pairs()` of every slot.
    first, second
        (p,) joints that carry its two solids.
    gaps, points, normals, on
        (p,), (p, 3), (p, 3), (p,) as of the last `update`: distance [m], place halfway between the surfaces,
        the normal from the first to the second, and whether there is a contact.
    """

    def __init__(self, geometry: Geometry, reach: float) -> None:
        library = coal()
        solids = geometry.solids
        self.pairs, self._reach = geometry.pairs(), reach
        self._joints = np.array([s.joint for s in solids], dtype=np.int64)
        self._core = np.array([s.shape.core for s in solids]).reshape(-1, 3)
        self._radius = np.array([s.shape.radius for s in solids], dtype=np.float64)
        self._turn = np.array([s.rotation for s in solids]).reshape(-1, 3, 3)
        self._place = np.array([s.position for s in solids]).reshape(-1, 3)
        counts = np.array(
            [slots(solids[a].shape, solids[b].shape) for a, b in self.pairs.tolist()], dtype=np.int64
        )
        self._start = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
        self.pair = np.repeat(np.arange(len(counts)), counts)
        self.first = self._joints[self.pairs[self.pair, 0]]
        self.second = self._joints[self.pairs[self.pair, 1]]
        p = len(self.pair)
        self.gaps, self.points, self.normals = np.full(p, FAR), np.zeros((p, 3)), np.zeros((p, 3))
        self.normals[:, 2] = 1.0
        self.on = np.zeros(p, dtype=np.bool_)
        self._solids = [s.shape.solid() for s in solids]
        self._inner = [None if s.shape.radius > 0.0 else s.shape.inset(INSET).solid() for s in solids]
        carriers, self._carrier = np.unique(self._joints, return_inverse=True)
        self._moving = list(enumerate(carriers.tolist()))
        self._turns, self._places = np.zeros((len(carriers), 3, 3)), np.zeros((len(carriers), 3))
        self._rotation, self._centre = np.zeros(self._turn.shape), np.zeros(self._place.shape)
        self._poses = [library.Transform3s() for _ in solids]
        self._distance, self._result = library.distance, library.DistanceResult()
        self._request = library.DistanceRequest()
        self._request.gjk_tolerance = self._request.epa_tolerance = PRECISION

    def update(self, placements: Any) -> None:
        """Look where solids touch, with their joints at `placements`, Pinocchio's `data.oMi`."""
        self.gaps.fill(FAR)
        self.on.fill(False)
        if not len(self.pairs):
            return
        for k, joint in self._moving:
            at = placements[joint]
            self._turns[k], self._places[k] = at.rotation, at.translation
        rotation, centre = self._rotation, self._centre
        near = place_solids(
            self._turns, self._places, self._carrier, self._turn, self._place, self._core, self._radius,
            self.pairs, self._reach, rotation, centre,
        )  # fmt: skip
        if not near.size:
            return
        pairs, seen = self.pairs[near], np.empty((near.size, 10))
        for s in set(pairs.ravel().tolist()):
            self._poses[s].setRotation(rotation[s])
            self._poses[s].setTranslation(centre[s])
        for row, (a, b) in zip(seen, pairs.tolist(), strict=True):
            self._look(a, b, row, centre)
        manifolds(
            pairs, self._start[near], self._core, self._radius, rotation, centre, seen,
            self.gaps, self.points, self.normals,
        )  # fmt: skip
        np.less(self.gaps, FAR, out=self.on)

    def _look(self, a: int, b: int, row: FloatArray, centre: FloatArray) -> None:
        """Write normal, distance and nearest points of two solids into row (10,)."""
        result, poses = self._result, self._poses
        result.clear()
        row[3] = self._distance(self._solids[a], poses[a], self._solids[b], poses[b], self._request, result)
        row[:3], row[4:7], row[7:] = result.normal, result.getNearestPoint1(), result.getNearestPoint2()
        inner = self._inner[a], self._inner[b]
        if abs(row[3]) < VAGUE and None not in inner:
            result.clear()
            self._distance(inner[0], poses[a], inner[1], poses[b], self._request, result)
            row[:3] = result.normal
        length = float(np.sqrt(row[:3] @ row[:3]))
        if 0.5 < length < 2.0:
            row[:3] /= length
            return
        # concentric shapes have no direction of their own
        way = centre[b] - centre[a]
        apart = float(np.sqrt(way @ way))
        row[:3] = way / apart if apart > 0.0 else (0.0, 0.0, 1.0)


@kernel
def place_solids(
    turns: FloatArray, places: FloatArray, carrier: IntArray, turn: FloatArray, place: FloatArray,
    half: FloatArray, radius: FloatArray, pairs: IntArray, reach: float, rotation: FloatArray,
    centre: FloatArray,
) -> IntArray:  # fmt: skip
    """Write `rotation` (s, 3, 3) and `centre` (s, 3) of solids in the world; return the near pairs (k,).

    `turns` (j, 3, 3) and `places` (j, 3) are the joints', `carrier` (s,) each solid's among them, `turn` and
    `place` its own in it; `half` (s, 3) and `radius` (s,) its core. Near are those of `pairs` (m, 2) whose
    bounding boxes along the world's axes are closer than `reach`.
    """
    extent = np.empty(centre.shape)
    for s in range(centre.shape[0]):
        j = carrier[s]
        for a in range(3):
            centre[s, a] = places[j, a]
            extent[s, a] = radius[s]
            for b in range(3):
                centre[s, a] += turns[j, a, b] * place[s, b]
                total = 0.0
                for c in range(3):
                    total += turns[j, a, c] * turn[s, c, b]
                rotation[s, a, b] = total
                extent[s, a] += abs(total) * half[s, b]
    near = np.empty(pairs.shape[0], dtype=np.int64)
    count = 0
    for i in range(pairs.shape[0]):
        one, two = pairs[i, 0], pairs[i, 1]
        close = True
        for a in range(3):
            close &= abs(centre[one, a] - centre[two, a]) - extent[one, a] - extent[two, a] < reach
        if close:
            near[count] = i
            count += 1
    return near[:count]


def slots(one: Shape, two: Shape) -> int:
    """Return how many contacts two shapes may have: eight of two boxes, three of lines, one of a ball."""
    sizes = [int(np.count_nonzero(shape.core)) for shape in (one, two)]
    return 1 if min(sizes) == 0 else 8 if min(sizes) == 3 else 3
