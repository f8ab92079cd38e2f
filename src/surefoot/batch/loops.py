"""Compiled loops over ranges of problems: each runs without the interpreter's lock, on one thread.

A problem's contacts that are masked out are taken out of its matrix first, so mixed numbers of contacts cost
no more than their own.
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray, IntArray
from surefoot.batch.active import FREE, HELD, SLIDE, STICK, read_modes
from surefoot.batch.kernel import (
    jvp_within,
    slope_memory,
    solve_within_memory,
    solving_memory,
    vjp_within,
)
from surefoot.kernels import borrowed, inline_kernel, keep, releasing_kernel, window


@inline_kernel
def _count(mask: BoolArray, b: int, n: int) -> int:
    """Return the number of contacts that are there; an empty mask has them all."""
    if mask.shape[0] == 0:
        return n
    count = 0
    for k in range(n):
        count += 1 if mask[b, k] else 0
    return count


@inline_kernel
def _contract(
    G: FloatArray, g: FloatArray, laws: FloatArray, mask: BoolArray, b: int, A: FloatArray, a: FloatArray,
    own: FloatArray,
) -> None:  # fmt: skip
    """Fill A, a and own with the parts of G, g and laws of the contacts that are there."""
    n, i = laws.shape[1], 0
    for k in range(n):
        if not mask[b, k]:
            continue
        j = 0
        for h in range(n):
            if mask[b, h]:
                for x in range(3):
                    for y in range(3):
                        A[3 * i + x, 3 * j + y] = G[3 * k + x, 3 * h + y]
                j += 1
        for x in range(3):
            a[3 * i + x], own[x, i] = g[3 * k + x], laws[x, k]
        i += 1


@inline_kernel
def _pick(mask: BoolArray, b: int, n: int, rows: int, full: FloatArray, part: FloatArray) -> None:
    """Copy the contacts that are there from `rows` blocks of n rows of three to blocks of fewer."""
    few = part.shape[0] // rows
    for r in range(rows):
        i = 0
        for k in range(n):
            if mask[b, k]:
                for x in range(3):
                    part[r * few + i, x] = full[r * n + k, x]
                i += 1


@inline_kernel
def _put(mask: BoolArray, b: int, n: int, rows: int, few: int, part: FloatArray, full: FloatArray) -> None:
    """Copy them back; contacts that are not there get zero."""
    for r in range(rows):
        i = 0
        for k in range(n):
            for x in range(3):
                full[r * n + k, x] = part[r * few + i, x] if mask[b, k] else 0.0
            i += 1 if mask[b, k] else 0


@inline_kernel
def _room(n: int) -> int:
    """Return how many numbers of memory `_reduced` takes for problems of up to n contacts."""
    return 9 * n * n + 30 * n + 9


@inline_kernel
def _reduced(memory: FloatArray, few: int) -> tuple[FloatArray, ...]:
    """Return memory of a problem of few contacts: G, g, laws, buffer, and both ends of a derivative."""
    m, at = 3 * few, 9 * few * few
    return (
        window(memory, 0, m, m),
        window(memory, at, 1, m)[0],
        window(memory, at + m, 3, few),
        window(memory, at + 2 * m, 2 * few + 3, 3),
        window(memory, at + 4 * m + 9, 2 * few, 3),
        window(memory, at + 6 * m + 9, 2 * few, 3),
    )


@releasing_kernel
def solve_range(
    G: FloatArray, g: FloatArray, laws: FloatArray, mask: BoolArray, convex: bool, asymmetry: float,
    tol: float, most: int, warm: bool, buffers: FloatArray, done: IntArray, start: int, stop: int,
) -> None:  # fmt: skip
    """Solve problems start to stop - 1; see `solve_contacts` for buffers (B, 2n + 3, 3) and done (B,)."""
    n = laws.shape[2]
    memory, room = np.empty(solving_memory(3 * n)), np.empty(_room(n))
    for b in range(start, stop):
        A, a, buffer = borrowed(G)[b], borrowed(g)[b], borrowed(buffers)[b]
        own = borrowed(laws)[b if laws.shape[0] > 1 else 0]
        few = _count(mask, b, n)
        if few == 0:
            buffers[b, :, :] = 0.0
            done[b] = 0
            continue
        if few < n:
            small = _reduced(room, few)
            _contract(A, a, own, mask, b, small[0], small[1], small[2])
            _pick(mask, b, n, 1, buffer, small[3][:few])
            A, a, own, buffer = small[0], small[1], small[2], small[3]
        done[b] = solve_within_memory(A, a, own, convex, asymmetry, tol, most, warm, buffer, memory)
        if few < n:
            _put(mask, b, n, 2, few, buffer, borrowed(buffers)[b])
            for r in range(3):
                for x in range(3):
                    buffers[b, 2 * n + r, x] = buffer[2 * few + r, x]
    keep(memory)
    keep(room)


@releasing_kernel
def derive_range(
    G: FloatArray, laws: FloatArray, mask: BoolArray, convex: bool, buffers: FloatArray, forward: bool,
    valid: BoolArray, given: FloatArray, out: FloatArray, regular: BoolArray, start: int, stop: int,
) -> None:  # fmt: skip
    """Fill the jvp (forward) or vjp (B, 2n, 3) of problems start to stop - 1; zero where not valid."""
    n = laws.shape[2]
    memory, room = np.empty(slope_memory(n)), np.empty(_room(n))
    for b in range(start, stop):
        few = _count(mask, b, n) if valid[b] else 0
        if few == 0:
            out[b, :, :] = 0.0
            continue
        A, buffer, ends, found = borrowed(G)[b], borrowed(buffers)[b], borrowed(given)[b], borrowed(out)[b]
        own = borrowed(laws)[b if laws.shape[0] > 1 else 0]
        if few < n:
            small = _reduced(room, few)
            _contract(A, A[0], own, mask, b, small[0], small[1], small[2])
            _pick(mask, b, n, 2, buffer, small[3][: 2 * few])
            _pick(mask, b, n, 2, ends, small[4])
            A, _, own, buffer, ends, found = small
        if forward:
            regular[b] = jvp_within(A, own, convex, buffer, ends, found, memory)
        else:
            regular[b] = vjp_within(A, own, convex, buffer, ends, found, memory)
        if few < n:
            _put(mask, b, n, 2, few, found, borrowed(out)[b])
    keep(memory)
    keep(room)


@releasing_kernel
def measure_range(
    G: FloatArray, g: FloatArray, laws: FloatArray, mask: BoolArray, convex: bool, buffers: FloatArray,
    distance: FloatArray, start: int, stop: int,
) -> None:  # fmt: skip
    """Fill the distance (B,) of problems start to stop - 1 to the nearest change of a mode, over their speed.

    Velocities, or forces times their w_k = G_kk [m/s], over the largest ||g_k||: no unit left. Shapes as for
    `solve_range`.
    """
    n = laws.shape[2]
    mode = np.empty((n, 9))
    for b in range(start, stop):
        own = laws[b if laws.shape[0] > 1 else 0]
        read_modes(G[b], own, convex, buffers[b], mode)
        least, speed = np.inf, 0.0
        for k in range(n):
            if mask.shape[0] > 0 and not mask[b, k]:
                continue
            i, mu, low, high = 3 * k, own[0, k], own[1, k], own[2, k]
            speed = max(speed, np.sqrt(g[b, i] ** 2 + g[b, i + 1] ** 2 + g[b, i + 2] ** 2))
            normal, tangent, slip, z = mode[k, 0], mode[k, 1], mode[k, 6], mode[k, 7]
            if normal == HELD:
                continue
            if normal == FREE:
                least = min(least, min(z - low, high - z) * G[b, i + 2, i + 2])
            else:
                least = min(least, abs(buffers[b, n + k, 2] - (mu * slip if convex else 0.0)))
            x, y = buffers[b, k, 0], buffers[b, k, 1]
            if tangent == STICK:
                weight = max(G[b, i, i], G[b, i + 1, i + 1])
                least = min(least, (mu * z - np.sqrt(x * x + y * y)) * weight)
            if tangent == SLIDE:
                least = min(least, slip)
        distance[b] = max(least, 0.0) / speed if speed > 0.0 else 0.0
