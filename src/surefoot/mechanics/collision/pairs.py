"""Which solids are near each other, and where they touch: broad phase by boxes, narrow phase by coal.

Balls do not need coal: the point of a box nearest to one is closed form, inside the box too.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import inline_kernel, kernel
from surefoot.mechanics.collision.contact_rates import contact_rates
from surefoot.mechanics.collision.manifold import manifolds
from surefoot.mechanics.collision.rounded_shapes import Shape, coal
from surefoot.mechanics.collision.solids import Geometry

FAR = 1e3
"""Gap of a contact whose solids are not near each other [m]."""
PRECISION = 1e-10
"""Of coal's distances [m]."""
VAGUE = 1e-6
"""Distance of two sharp shapes below which its direction is not to be trusted [m]."""
INSET = 1e-5
"""By how much smaller shapes tell it then [m]."""
FEW = 64
"""Solids up to which every pair has its slots from the start, so that contacts have numbers for good."""


class PairSearch:
    """Finds the contacts of a geometry's pairs; every pair has slots of its own for them, near or not.

    One per thread: it keeps its work arrays. Of many solids a pair gets its slots when it first comes near,
    behind all others, and keeps them.

    Parameters
    ----------
    geometry
        The solids.
    reach
        Distance of two solids' bounding boxes up to which they are looked at [m].

    Attributes
    ----------
    pairs
        (m, 2) the two solids of every pair, see `Geometry.pairs`.
    pair
        (p,) index into `pairs` of every slot.
    first, second
        (p,) joints that carry its two solids.
    gaps, points, normals, on
        (p,), (p, 3), (p, 3), (p,) as of the last `update`: distance [m], place halfway between the surfaces,
        the normal from the first to the second, and whether there is a contact.
    """

    def __init__(self, geometry: Geometry, reach: float) -> None:
        library = coal()
        solids = geometry.solids
        self._geometry, self._reach = geometry, reach
        self._joints = np.array([s.joint for s in solids], dtype=np.int64)
        self._core = np.array([s.shape.core for s in solids]).reshape(-1, 3)
        self._radius = np.array([s.shape.radius for s in solids], dtype=np.float64)
        self._turn = np.array([s.rotation for s in solids]).reshape(-1, 3, 3)
        self._place = np.array([s.position for s in solids]).reshape(-1, 3)
        self.pairs, self._start = np.zeros((0, 2), dtype=np.int64), np.zeros(1, dtype=np.int64)
        self._all = len(solids) <= FEW
        self._add(geometry.pairs(None if self._all else self.pairs))
        self._solids = [s.shape.solid() for s in solids]
        self._inner = [None if s.shape.radius > 0.0 else s.shape.inset(INSET).solid() for s in solids]
        self._carriers, self._carrier = np.unique(self._joints, return_inverse=True)
        count = len(self._carriers)
        self._turns, self._places = np.zeros((count, 3, 3)), np.zeros((count, 3))
        self._rotation, self._centre = np.zeros(self._turn.shape), np.zeros(self._place.shape)
        self._poses = [library.Transform3s() for _ in solids]
        self._distance, self._result = library.distance, library.DistanceResult()
        self._request = library.DistanceRequest()
        self._request.gjk_tolerance = self._request.epa_tolerance = PRECISION

    def _add(self, pairs: IntArray) -> None:
        """Give slots to more pairs (k, 2)."""
        solids = self._geometry.solids
        self.pairs = np.concatenate([self.pairs, pairs])
        counts = [slots(solids[a].shape, solids[b].shape) for a, b in pairs.tolist()]
        ends = self._start[-1] + np.cumsum(counts, dtype=np.int64)
        self._start = np.concatenate([self._start, ends])
        self.pair = np.repeat(np.arange(len(self.pairs)), np.diff(self._start))
        self.first, self.second = self._joints[self.pairs[self.pair]].T.copy()
        keys = self.pairs[:, 0] * len(solids) + self.pairs[:, 1]
        self._order = np.argsort(keys)
        self._keys = keys[self._order]
        p = len(self.pair)
        self.gaps, self.points, self.normals = np.full(p, FAR), np.zeros((p, 3)), np.zeros((p, 3))
        self.normals[:, 2] = 1.0
        self.on = np.zeros(p, dtype=np.bool_)

    def update(self, placements: Any) -> None:
        """Look where solids touch, with their joints at `placements`, Pinocchio's `data.oMi`."""
        if len(self.pairs):
            for k, joint in enumerate(self._carriers.tolist()):
                at = placements[joint]
                self._turns[k], self._places[k] = at.rotation, at.translation
        self._search()

    def update_free(self, turns: FloatArray, places: FloatArray) -> None:
        """Look where solids touch, with their joints at (joints, 3, 3) `turns` and (joints, 3) `places`."""
        self._turns[:], self._places[:] = turns[self._carriers], places[self._carriers]
        self._search()

    def rates(self, slots: IntArray) -> FloatArray:
        """Return how slots (k,) in use move with both bodies: (k, 7, 12), see `contact_rates`."""
        both = self.pairs[self.pair[slots]]
        return contact_rates(
            self._rotation[both], self._centre[both], self._core[both], self._radius[both],
            self.points[slots], self.normals[slots], self.gaps[slots],
        )  # fmt: skip

    def _search(self) -> None:
        """Look where solids touch, with their carriers where they are."""
        self.gaps.fill(FAR)
        self.on.fill(False)
        if self._all and not len(self.pairs):
            return
        rotation, centre = self._rotation, self._centre
        near, extent = place_solids(
            self._turns, self._places, self._carrier, self._turn, self._place, self._core, self._radius,
            self.pairs if self._all else self.pairs[:0], self._reach, rotation, centre,
        )  # fmt: skip
        # of many solids only near pairs are ever listed: all of them grow with the square of the solids
        if not self._all:
            close = sweep_boxes(centre, extent, self._reach)
            near = self._find_slots(self._geometry.pairs(close)) if len(close) else near
        if not near.size:
            return
        pairs = self.pairs[near]
        seen, balls = look_at_balls(pairs, self._core, self._radius, rotation, centre)
        for s in set(pairs[~balls].ravel().tolist()):
            self._poses[s].setRotation(rotation[s])
            self._poses[s].setTranslation(centre[s])
        for k in np.flatnonzero(~balls).tolist():
            self._look(int(pairs[k, 0]), int(pairs[k, 1]), seen[k], centre)
        manifolds(
            pairs, self._start[near], self._core, self._radius, rotation, centre, seen,
            self.gaps, self.points, self.normals,
        )  # fmt: skip
        np.less(self.gaps, FAR, out=self.on)

    def _find_slots(self, pairs: IntArray) -> IntArray:
        """Return where pairs (k, 2) are among all, with slots for those that had none."""
        keys = pairs[:, 0] * len(self._solids) + pairs[:, 1]
        # a pair near for the first time gets slots behind all others, and keeps
        # them: numbers of contacts never change
        at = np.searchsorted(self._keys, keys)
        fresh = np.append(self._keys, -1)[at] != keys
        if fresh.any():
            self._add(pairs[fresh])
            at = np.searchsorted(self._keys, keys)
        return np.asarray(self._order[at])

    def _look(self, a: int, b: int, row: FloatArray, centre: FloatArray) -> None:
        """Write normal, distance and nearest points of two solids into row (10,)."""
        result, poses = self._result, self._poses
        result.clear()
        row[3] = self._distance(self._solids[a], poses[a], self._solids[b], poses[b], self._request, result)
        row[:3], row[4:7], row[7:] = result.normal, result.getNearestPoint1(), result.getNearestPoint2()
        # the direction of a vanishing distance is rounding; of the shapes made smaller by INSET it is not
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
) -> tuple[IntArray, FloatArray]:  # fmt: skip
    """Write `rotation` (s, 3, 3), `centre` (s, 3) of solids in the world; return near pairs, extents (s, 3).

    `turns` (j, 3, 3) and `places` (j, 3) are the joints', `carrier` (s,) each solid's among them, `turn` and
    `place` its own in it; `half` (s, 3) and `radius` (s,) its core. Near (k,) are those of `pairs` (m, 2)
    whose bounding boxes along the world's axes are closer than `reach`; the extents are half of those.
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
                # half the bounding box of a turned box: |R| half
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
    return near[:count], extent


@kernel
def sweep_boxes(centre: FloatArray, extent: FloatArray, reach: float) -> IntArray:
    """Return the pairs (k, 2), smaller index first, of boxes closer than `reach` [m], in order.

    Sweep and prune along x: of boxes (s, 3) `centre`, `extent` sorted by their lower ends each is compared
    with those that begin before it ends.
    """
    low = centre[:, 0] - extent[:, 0]
    order, n = np.argsort(low), low.size
    found = []
    for i in range(n):
        one = order[i]
        end = centre[one, 0] + extent[one, 0] + reach
        for j in range(i + 1, n):
            two = order[j]
            if low[two] >= end:
                break
            y = abs(centre[one, 1] - centre[two, 1]) - extent[one, 1] - extent[two, 1]
            z = abs(centre[one, 2] - centre[two, 2]) - extent[one, 2] - extent[two, 2]
            if y < reach and z < reach:
                # one number per pair sorts them at once, by the smaller index first
                found.append(min(one, two) * n + max(one, two))
    keys = np.sort(np.array(found, dtype=np.int64))
    out = np.empty((keys.size, 2), dtype=np.int64)
    for k in range(keys.size):
        out[k, 0], out[k, 1] = keys[k] // n, keys[k] % n
    return out


@kernel
def look_at_balls(
    pairs: IntArray, half: FloatArray, radius: FloatArray, rotation: FloatArray, centre: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Return what coal would see (k, 10) of those pairs (k, 2) with a ball, and which ones are (k,).

    `half` (s, 3), `radius` (s,), `rotation` (s, 3, 3) and `centre` (s, 3) are the shapes' [m]. A ball's core
    is a point: what it is nearest to in another core, a box along its own axes, is that point cut to it.
    """
    seen, balls = np.empty((pairs.shape[0], 10)), np.zeros(pairs.shape[0], dtype=np.bool_)
    n, q = np.empty(3), np.empty(3)
    for i in range(pairs.shape[0]):
        a, b = pairs[i, 0], pairs[i, 1]
        ball, other, sign = b, a, 1.0
        if half[b].any():
            if half[a].any():
                continue
            ball, other, sign = a, b, -1.0
        balls[i] = True
        apart = nearest_of_core(centre[ball], half[other], rotation[other], centre[other], n, q)
        seen[i, 3] = apart - radius[a] - radius[b]
        one, two = (7, 4) if sign < 0.0 else (4, 7)
        for k in range(3):
            seen[i, k] = sign * n[k]
            seen[i, one + k] = q[k] + radius[other] * n[k]
            seen[i, two + k] = centre[ball, k] - radius[ball] * n[k]
    return seen, balls


@inline_kernel
def nearest_of_core(
    point: FloatArray, half: FloatArray, rotation: FloatArray, centre: FloatArray, n: FloatArray,
    q: FloatArray,
) -> float:  # fmt: skip
    """Return the distance [m] of a point (3,) from a core; write the way there n (3,) and where from q (3,).

    The core is a box of half extents `half` (3,) with its `rotation` (3, 3) and `centre` (3,). Inside it
    the distance is negative, to the nearest face.
    """
    cut, out, least, axis, square = np.empty(3), np.empty(3), np.inf, 2, 0.0
    for k in range(3):
        own = 0.0
        for i in range(3):
            own += rotation[i, k] * (point[i] - centre[i])
        cut[k] = min(max(own, -half[k]), half[k])
        out[k] = own - cut[k]
        square += out[k] ** 2
        # on a tie the last: concentric balls touch above each other
        if half[k] - abs(own) <= least:
            least, axis = half[k] - abs(own), k
    apart = math.sqrt(square)
    if apart > 0.0:
        out /= apart
    else:
        side = -1.0 if cut[axis] < 0.0 else 1.0
        out[:] = 0.0
        out[axis], cut[axis], apart = side, side * half[axis], -least
    for i in range(3):
        n[i], q[i] = 0.0, centre[i]
        for k in range(3):
            n[i] += rotation[i, k] * out[k]
            q[i] += rotation[i, k] * cut[k]
    return apart


def slots(one: Shape, two: Shape) -> int:
    """Return how many contacts two shapes may have: eight of two boxes, three of lines, one of a ball."""
    sizes = [int(np.count_nonzero(shape.core)) for shape in (one, two)]
    return 1 if min(sizes) == 0 else 8 if min(sizes) == 3 else 3
