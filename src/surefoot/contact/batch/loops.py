"""Compiled loops over ranges of problems: each runs without the interpreter's lock, on one thread."""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.kernels import borrowed, keep, releasing_kernel
from surefoot.contact.batch.active import FREE, HELD, SLIDE, STICK, read_modes
from surefoot.contact.batch.kernel import slope_memory, solve_within_memory, solving_memory, vjp_within
from surefoot.contact.solvers.compiled import FIRST, WARM


@releasing_kernel
def solve_range(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, asymmetry: float, tol: float, most: int,
    warm: bool, buffers: FloatArray, done: IntArray, start: int, stop: int,
) -> None:  # fmt: skip
    """Solve problems start to stop - 1; see `solve_contacts` for buffers (B, 2n + 3, 3) and done (B,)."""
    memory = np.empty(solving_memory(3 * laws.shape[2]))
    mode = FIRST | WARM if warm else FIRST
    for b in range(start, stop):
        own = borrowed(laws)[b if laws.shape[0] > 1 else 0]
        done[b] = solve_within_memory(
            borrowed(G)[b], borrowed(g)[b], own, convex, asymmetry, tol, most, mode, borrowed(buffers)[b],
            memory,
        )  # fmt: skip
    keep(memory)


@releasing_kernel
def derive_range(
    G: FloatArray, laws: FloatArray, convex: bool, buffers: FloatArray, valid: BoolArray,
    weights: FloatArray, out: FloatArray, regular: BoolArray, start: int, stop: int,
) -> None:  # fmt: skip
    """Fill the vjp (B, 2n, 3) of problems start to stop - 1; zero where not valid."""
    memory = np.empty(slope_memory(laws.shape[2]))
    for b in range(start, stop):
        # what is not solved has no modes that mean anything
        if not valid[b]:
            out[b, :, :] = 0.0
            continue
        own = borrowed(laws)[b if laws.shape[0] > 1 else 0]
        regular[b] = vjp_within(
            borrowed(G)[b], own, convex, borrowed(buffers)[b], borrowed(weights)[b], borrowed(out)[b], memory
        )
    keep(memory)


@releasing_kernel
def measure_range(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, buffers: FloatArray, distance: FloatArray,
    start: int, stop: int,
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
            i, mu, low, high = 3 * k, own[0, k], own[1, k], own[2, k]
            speed = max(speed, np.sqrt(g[b, i] ** 2 + g[b, i + 1] ** 2 + g[b, i + 2] ** 2))
            normal, tangent, slip, z = mode[k, 0], mode[k, 1], mode[k, 6], mode[k, 7]
            if normal == HELD:
                continue
            if normal == FREE:
                # closed: how far the normal force is from its bounds, as the velocity that it makes
                least = min(least, min(z - low, high - z) * G[b, i + 2, i + 2])
            else:
                # at a bound: how fast it would leave it, under the convex law less its own separation
                least = min(least, abs(buffers[b, n + k, 2] - (mu * slip if convex else 0.0)))
            x, y = buffers[b, k, 0], buffers[b, k, 1]
            if tangent == STICK:
                # sticking: the room in its disc; below, sliding: the speed at which it might stop
                weight = max(G[b, i, i], G[b, i + 1, i + 1])
                least = min(least, (mu * z - np.sqrt(x * x + y * y)) * weight)
            if tangent == SLIDE:
                least = min(least, slip)
        distance[b] = max(least, 0.0) / speed if speed > 0.0 else 0.0
