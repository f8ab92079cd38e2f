"""The double description method: in compiled floating point, and in exact rationals.

T. S. Motzkin et al. (1953); K. Fukuda, A. Prodon, "Double description method revisited" (1996). The
half-spaces of cone(V) are the extreme rays of its polar {h : V h <= 0}; these are kept up to date while
the rows of V are inserted one by one. Two rays are adjacent if no third one is tight wherever both are.

Limits: the number of rays in between can exceed that at the end; the floating-point version decides
what is tight with a tolerance and wants well-scaled rows of full rank (see `representation`).

Both by hand though cddlib exists. Its wheel is missing for several Pythons, so it cannot be what
`wrench_cone` rests on; the compiled version takes 1.9 ms where cddlib takes 5.2 and Qhull 5.0 (four feet,
eight rays each; with 64 rays Qhull is the fastest). The exact one has no counterpart there: that wheel
counts in floating point only.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from surefoot.arrays import FloatArray, IntArray
from surefoot.kernels import COMPILING, inline_kernel, kernel
from surefoot.numerics.vectors import dot

_TIGHT = 1e-10


_Words: TypeAlias = NDArray[np.uint64]
_M1, _M2, _M4 = np.uint64(0x5555555555555555), np.uint64(0x3333333333333333), np.uint64(0x0F0F0F0F0F0F0F0F)
_SUM, _ONE = np.uint64(0x0101010101010101), np.uint64(1)
_TWO, _FOUR, _TOP = np.uint64(2), np.uint64(4), np.uint64(56)


@inline_kernel
def _compiled_ones(word: np.uint64) -> int:
    """Return the number of bits set in a 64-bit word, in the form that LLVM knows for one instruction."""
    a = word - ((word >> _ONE) & _M1)
    b = (a & _M2) + ((a >> _TWO) & _M2)
    c = (b + (b >> _FOUR)) & _M4
    return np.int64((c * _SUM) >> _TOP)  # type: ignore[return-value]


def _plain_ones(word: np.uint64) -> int:
    return int(word).bit_count()


_ones = _compiled_ones if COMPILING else _plain_ones  # NumPy warns of the product, which wraps around


@kernel
def polar_rays(V: FloatArray, first: FloatArray, order: IntArray) -> tuple[int, FloatArray]:
    """Return the extreme rays of {h : V h <= 0}, V with rows of length one and full column rank.

    Parameters
    ----------
    V
        (n, d).
    first
        (d, d) rays of the first d inequalities: V[order[:d]] @ first.T = -identity.
    order
        (n,) in which the rows of V are inserted.

    Returns
    -------
    tuple[int, FloatArray]
        Their number and the rays (number, d) of length one.
    """
    n, d = V.shape
    words, room = (n + 63) // 64, 256
    rays, bits = np.empty((room, d)), np.zeros((room, words), dtype=np.uint64)
    slack = np.empty(room)
    count = d
    for k in range(d):
        rays[k] = first[k] / np.sqrt(dot(first[k], first[k]))
        for j in range(d):
            if j != k:
                # ray k is tight on all of the first d inequalities but its own
                bits[k, j >> 6] |= _ONE << np.uint64(j & 63)
    both = np.zeros(words, dtype=np.uint64)
    for step in range(d, n):
        v = V[order[step]]
        mark = _ONE << np.uint64(step & 63)
        outside = 0
        # which side of the new half-space each ray is on
        for k in range(count):
            slack[k] = dot(v, rays[k])
            if slack[k] > _TIGHT:
                outside += 1
            elif slack[k] >= -_TIGHT:
                slack[k] = 0.0
                bits[k, step >> 6] |= mark
        if outside == 0:
            continue
        old = count
        # a pair on both sides gives a new ray where it spans a face (Fukuda and Prodon 1996)
        for p in range(old):
            if slack[p] <= 0.0:
                continue
            for m in range(old):
                if slack[m] >= 0.0 or not _adjacent(bits, old, p, m, d, both):
                    continue
                if count == room:
                    room *= 2
                    rays = np.concatenate((rays, np.empty_like(rays)))
                    bits = np.concatenate((bits, np.zeros_like(bits)))
                    slack = np.concatenate((slack, np.empty_like(slack)))
                for q in range(d):  # where the edge between the two crosses the new half-space's border
                    rays[count, q] = slack[p] * rays[m, q] - slack[m] * rays[p, q]
                size = 1.0 / np.sqrt(dot(rays[count], rays[count]))
                for q in range(d):
                    rays[count, q] *= size
                bits[count] = both
                bits[count, step >> 6] |= mark
                slack[count] = 0.0
                count += 1
        # rays outside are cut off
        kept = 0
        for k in range(count):
            if slack[k] <= 0.0:
                rays[kept] = rays[k]
                bits[kept] = bits[k]
                kept += 1
        bits[kept:count] = np.uint64(0)
        count = kept
    return count, rays[:count]


@inline_kernel
def _adjacent(bits: _Words, count: int, p: int, m: int, d: int, both: _Words) -> bool:
    """Tell whether rays p and m span a face; `both` receives what they are both tight on."""
    words = both.size
    common = 0
    for w in range(words):
        both[w] = bits[p, w] & bits[m, w]
        common += _ones(both[w])
    # a face of dimension two lies on at least d - 2 borders ...
    if common < d - 2:
        return False
    # ... and no third ray lies on all of them (the combinatorial test)
    for k in range(count):
        holds = k != p and k != m
        for w in range(words if holds else 0):
            if (bits[k, w] & both[w]) != both[w]:
                holds = False
                break
        if holds:
            return False
    return True


def polar_rays_exact(V: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lines and extreme rays of {h : V h <= 0} in exact rational arithmetic, as floats.

    Slow (pure Python) and without tolerances: every float of V is taken at its exact value, so rows
    that ought to be parallel but are not by one rounding count as different.

    Parameters
    ----------
    V
        (n, d), of any rank and any shape of cone.

    Returns
    -------
    tuple[FloatArray, FloatArray]
        Lines (l, d), directions that belong both ways, and rays (r, d); scaled to a largest entry of 1.

    Examples
    --------
    >>> polar_rays_exact(np.array([[1.0, 0.0]]))
    (array([[0., 1.]]), array([[-1.,  0.]]))
    """
    n, d = V.shape
    rows = [[Fraction(float(x)) for x in row] for row in V]
    lines = [[Fraction(int(i == j)) for j in range(d)] for i in range(d)]
    rays: list[tuple[list[Fraction], set[int]]] = []
    for step in range(n):
        v = rows[step]
        at = next((k for k, line in enumerate(lines) if _dot(v, line) != 0), None)
        if at is not None:
            lines, rays = _turn_line(lines, rays, at, v, step)
        else:
            rays = _cut(rays, v, step, d - len(lines))
    return _as_floats(lines, d), _as_floats([ray for ray, _ in rays], d)


_Rays: TypeAlias = list[tuple[list[Fraction], set[int]]]


def _turn_line(
    lines: list[list[Fraction]], rays: _Rays, at: int, v: list[Fraction], step: int
) -> tuple[list[list[Fraction]], _Rays]:
    """Make a line that crosses the new half-space a ray, and everything else tight on it."""
    pivot = lines[at] if _dot(v, lines[at]) < 0 else [-x for x in lines[at]]
    depth = _dot(v, pivot)

    def tight(x: list[Fraction]) -> list[Fraction]:
        share = _dot(v, x) / depth
        return [a - share * b for a, b in zip(x, pivot, strict=True)]

    others = [tight(line) for k, line in enumerate(lines) if k != at]
    moved = [(tight(ray), zeros | {step}) for ray, zeros in rays]
    return others, [*moved, (pivot, set(range(step)))]


def _cut(rays: _Rays, v: list[Fraction], step: int, rank: int) -> _Rays:
    """Cut the cone with one half-space: new rays where it crosses faces between adjacent rays."""
    slack = [_dot(v, ray) for ray, _ in rays]
    out: _Rays = []
    for (ray, zeros), s in zip(rays, slack, strict=True):
        if s <= 0:
            out.append((ray, zeros | {step} if s == 0 else zeros))
    for p, (ray_p, zeros_p) in enumerate(rays):
        if slack[p] <= 0:
            continue
        for m, (ray_m, zeros_m) in enumerate(rays):
            if slack[m] >= 0:
                continue
            common = zeros_p & zeros_m
            if len(common) < rank - 2:
                continue
            if any(common <= z for k, (_, z) in enumerate(rays) if k not in (p, m)):
                continue
            new = [slack[p] * a - slack[m] * b for a, b in zip(ray_m, ray_p, strict=True)]
            size = max(abs(x) for x in new)
            out.append(([x / size for x in new], common | {step}))
    return out


def _dot(a: list[Fraction], b: list[Fraction]) -> Fraction:
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def _as_floats(rows: list[list[Fraction]], d: int) -> FloatArray:
    scaled = [[float(x / max(abs(y) for y in row)) for x in row] for row in rows]
    return np.array(scaled, dtype=np.float64).reshape(-1, d)
