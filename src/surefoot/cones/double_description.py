"""The double description method, in compiled floating point.

T. S. Motzkin et al. (1953); K. Fukuda, A. Prodon, "Double description method revisited" (1996). The
half-spaces of cone(V) are the extreme rays of its polar {h : V h <= 0}; these are kept up to date while
the rows of V are inserted one by one. Two rays are adjacent if no third one is tight wherever both are.

Limits: the number of rays in between can exceed that at the end; what is
tight is decided with a tolerance, and wants well-scaled rows of full rank (see `representation`).

By hand though cddlib exists. Its wheel is missing for several Pythons, so it cannot be what
`wrench_cone` rests on; the compiled version takes 1.9 ms where cddlib takes 5.2 and Qhull 5.0 (four feet,
eight rays each; with 64 rays Qhull is the fastest).
"""

from __future__ import annotations

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
