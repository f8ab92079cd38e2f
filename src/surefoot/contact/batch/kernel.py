"""One contact problem and its gradient as compiled functions, for loops over many and for a caller's own.

`solve_contacts` and `contact_vjp` may be called from any function under `numba.njit`; they hold no state,
allocate their own scratch, and release nothing. On exact cones, with dense factors: for up to hundreds of
contacts.

The derivative is that of `derivative.solution_derivative`, at the forces as they are solved (not
polished): its error is that of the solution times the condition. At a kink it belongs to the mode that the
natural map is on.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import borrowed, inline_kernel, keep, kernel, window
from surefoot.base.numerics.elimination import lu_solve, lu_solve_many
from surefoot.contact.batch.active import (
    AT_HIGH,
    AT_LOW,
    COLUMN,
    FIRST,
    FREE,
    HELD,
    ROW,
    STICK,
    add_product,
    fill,
    gather,
    least_squares,
    list_unknowns,
    read_modes,
    regular_pivots,
    scatter,
    unscale,
)
from surefoot.contact.solvers.compiled import (
    CONVEX_CALL,
    UNBOUNDED,
    UNSOLVED,
    WARM,
    WORK,
    read_system,
    solve_within,
)


@kernel
def solve_contacts(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, asymmetry: float, tol: float, most: int,
    warm: bool, buffer: FloatArray,
) -> int:  # fmt: skip
    """Solve one contact problem; return the iterations, bit by bit turned (negative) if it is not solved.

    `compiled.NOT_NUMBERS` and `DOUBTFUL` stand for a G or g that is not finite, and for a G that is not
    symmetric positive semidefinite as far as it looks.

    Parameters
    ----------
    G, g
        (3n, 3n) Delassus operator with its compliance, and (3n,) free velocity, C-contiguous.
    laws
        (3, n): mu, normal_min (-inf for a bilateral contact) and normal_max.
    convex
        Whether the law is convex; else Coulomb's.
    asymmetry
        Largest |G - Gᵀ| over largest |G| that is taken for rounding (1e-8; 1e-5 for single precision).
    tol, most
        Wanted velocity error, and the bound on iterations (-1 for the methods' own).
    warm
        Whether the buffer holds forces to start from.
    buffer
        (2n + 3, 3) to be filled: forces, velocities, and the seven numbers of `Residuals`.
    """
    memory = np.empty(solving_memory(g.size))
    done = solve_within_memory(
        borrowed(G), borrowed(g), borrowed(laws), convex, asymmetry, tol, most, WARM if warm else 0,
        borrowed(buffer), memory,
    )  # fmt: skip
    keep(memory)
    return done


@inline_kernel
def solving_memory(m: int) -> int:
    """Return how many numbers of memory a problem with m unknowns takes."""
    return m * (m + 2) + WORK * (m // 3)


@inline_kernel
def solve_within_memory(
    G: FloatArray, g: FloatArray, laws: FloatArray, convex: bool, asymmetry: float, tol: float, most: int,
    mode: int, buffer: FloatArray, memory: FloatArray,
) -> int:  # fmt: skip
    """Do as `solve_contacts`, see there for the shapes, with borrowed arrays in memory that is there.

    The mode is that of `compiled` but for the law.
    """
    m = g.size
    matrix, vectors = window(memory, 0, m, m), window(memory, m * m, 2, m)
    refused = read_system(G, g, asymmetry, matrix, vectors)
    if refused != 0:
        return refused
    for a in range(3):
        for k in range(m // 3):
            vectors[1, a * (m // 3) + k] = laws[a, k]
    if convex:
        mode |= CONVEX_CALL
    bound = most if most >= 0 else UNBOUNDED
    done = solve_within(matrix, vectors, tol, bound, mode, buffer, memory, m * (m + 2))
    # one number says both: iterations, their bits turned where it is not solved (0 has no negative)
    return ~(done - UNSOLVED) if done >= UNSOLVED else done


@kernel
def contact_vjp(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, weights: FloatArray, out: FloatArray
) -> bool:
    """Fill the gradient of a number whose gradient with respect to forces and velocities is given.

    Parameters
    ----------
    G, laws, convex, buffer
        As `solve_contacts` took and filled them.
    weights
        (2n, 3): of the forces, then of the velocities.
    out
        (2n, 3) to be filled: rows 0 to n - 1 with respect to g; row n + k with respect to contact k's mu,
        normal_min and normal_max. That with respect to G is the symmetric part of out_g λᵀ, and with respect
        to a compliance out_g λ, entry by entry.

    Returns
    -------
    bool
        Whether the active system is regular; for redundant contacts the gradient is along perturbations
        that they can follow.
    """
    memory = np.empty(slope_memory(laws.shape[1]))
    regular = vjp_within(
        borrowed(G), borrowed(laws), convex, borrowed(buffer), borrowed(weights), borrowed(out), memory
    )
    keep(memory)
    return regular


@inline_kernel
def slope_memory(n: int) -> int:
    """Return how many numbers of memory the gradient of a problem takes."""
    return (3 * n + 5) * 3 * n + 30 * n + 9


@inline_kernel
def vjp_within(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, weights: FloatArray, out: FloatArray,
    memory: FloatArray,
) -> bool:  # fmt: skip
    """Do as `contact_vjp`, see there for the shapes, with borrowed arrays in memory that is there."""
    n = laws.shape[1]
    m = 3 * n
    work, mode = window(memory, 0, m + 5, m), window(memory, (m + 5) * m, n + 1, 9)
    unknown = window(memory, (m + 5) * m + 9 * (n + 1), m, 7)
    p, b, back, spare = work[m], work[m + 1], work[m + 2], work[m + 3]
    read_modes(G, laws, convex, buffer, mode)
    size = list_unknowns(laws, mode, convex, unknown)
    # what reaches the forces: their own weights and, by u = G λ + g, those of the velocities
    for k in range(n):
        for a in range(3):
            p[3 * k + a], back[3 * k + a] = weights[k, a], weights[n + k, a]
    add_product(G, back, 1.0, p)
    # Aᵀ z = Cᵀ p: the adjoint of the active system
    fill(G, mode, unknown, COLUMN, ROW, spare, work)
    gather(mode, unknown, COLUMN, p, b)
    regular = size == 0 or (lu_solve(work, b, size) and regular_pivots(work, size))
    # redundant contacts: least squares, and what A misses stays with the velocities
    if not regular:
        extra = work[m + 4]
        fill(G, mode, unknown, COLUMN, ROW, spare, work)
        gather(mode, unknown, COLUMN, p, b)
        gather(mode, unknown, ROW, back, extra)
        # Sᵀ ū with R S = 1: what the singular A misses of a right side stays with the velocities (see
        # `contact.derivative.active_system`), whose weights pull here
        unscale(unknown, size, extra)
        least_squares(work, b, size, extra)
    # the gradient in g is v̄ - Rᵀ z, that of a force that jumps with its bound is p - G Rᵀ z
    scatter(mode, unknown, ROW, b, back)
    add_product(G, back, -1.0, p)
    for k in range(n):
        h = 3 * k
        out[k, 0], out[k, 1] = weights[n + k, 0] - back[h], weights[n + k, 1] - back[h + 1]
        out[k, 2] = weights[n + k, 2] - back[h + 2]
        normal, tangent, e_p = mode[k, 0], mode[k, 1], mode[k, 2] * p[h] + mode[k, 3] * p[h + 1]
        # a sliding or bare force is mu λ_n e: ∂/∂mu = λ_n e
        own = mode[k, 7] * e_p if normal != HELD else 0.0
        # the convex law has mu ||u_t|| in its normal equation
        if convex and normal == FREE and tangent != STICK:
            own += mode[k, 6] * b[int(mode[k, FIRST])]
        along = p[h + 2] + laws[0, k] * e_p
        out[n + k, 0] = own
        out[n + k, 1], out[n + k, 2] = along if normal == AT_LOW else 0.0, along if normal == AT_HIGH else 0.0
    return regular


@kernel
def contact_blocks(
    G: FloatArray, laws: FloatArray, convex: bool, buffer: FloatArray, out: FloatArray
) -> bool:
    """Fill out (3n, 4n) with the derivatives of the forces (3n,) by g (3n,) and by every contact's mu (n,).

    G, laws, convex and buffer are as `solve_contacts` took and filled them. False, and out is of no use,
    where the active system is singular: redundant contacts.
    """
    n = laws.shape[1]
    m = 3 * n
    mode, unknown = np.empty((n + 1, 9)), np.empty((m, 7))
    work, right, x = np.empty((m, m)), np.empty((m, 4 * n)), np.empty(m)
    read_modes(G, laws, convex, buffer, mode)
    size = list_unknowns(laws, mode, convex, unknown)
    fill(G, mode, unknown, ROW, COLUMN, x, work)
    # right sides, negative: unit rates of g, then G times each contact's jump with mu
    for j in range(4 * n):
        x[:] = 0.0
        if j < m:
            x[j] = -1.0
        elif mode[j - m, 0] != HELD:
            k = j - m
            for i in range(m):  # G times the jump of the force
                x[i] = -mode[k, 7] * (G[i, 3 * k] * mode[k, 2] + G[i, 3 * k + 1] * mode[k, 3])
        gather(mode, unknown, ROW, x, right[:, j])
    for k in range(n):
        if convex and mode[k, 0] == FREE and mode[k, 1] != STICK:
            right[int(mode[k, FIRST]), m + k] += mode[k, 6]
    if not (size == 0 or (lu_solve_many(work, right, size) and regular_pivots(work, size))):
        return False
    for j in range(4 * n):
        scatter(mode, unknown, COLUMN, right[:, j], out[:, j])
    for k in range(n):
        # the jump itself
        if mode[k, 0] != HELD:
            out[3 * k, m + k] += mode[k, 7] * mode[k, 2]
            out[3 * k + 1, m + k] += mode[k, 7] * mode[k, 3]
    return True
