"""Contact problems in Warp: one thread per problem, the same source on the CPU and on CUDA.

`solve` runs Newton's method on the central path in every thread (`batch.warp_path`); `vjp` is a second kernel
that solves the active system by its singular values (`batch.warp_verdict`). Inside, both count in double
precision; float32 arrays are read and rounded (about 1e-7), not computed with. Up to eight contacts.
"""

# ruff: noqa: RUF046, UP018 (Warp reads int(0) as a variable, 0 as a constant)
# mypy: disable-error-code="untyped-decorator, valid-type, no-untyped-def"
# kernels that are made for a scalar type need their annotations evaluated: no __future__ import here

from functools import cache
from typing import Any, NamedTuple

from surefoot.batch.answers import Forces, check_law, check_shapes
from surefoot.batch.warp_path import HUGE, descend, prepare
from surefoot.batch.warp_runtime import Real, wp
from surefoot.batch.warp_verdict import (
    assemble,
    error_of,
    mode_of,
    move,
    rotate,
    snap,
    solve_transposed,
    worst_rest,
)
from surefoot.errors import ProblemError

MOST_CONTACTS = 8


class Gradients(NamedTuple):
    """What `vjp` returns: (B, 3n, 3n) symmetric, (B, 3n) and (B, n) arrays of the problems' dtype."""

    G: Any
    g: Any
    mu: Any


@wp.func
def read(G: Any, g: Any, mu: Any, mask: Any, t: int, A: Any, b: Any, c: Any, on: Any) -> int:
    """Copy problem t into local memory, G made symmetric; return whether it is a problem."""
    good = int(1)
    for i in range(b.shape[0]):
        b[i] = Real(g[t, i])
        if not wp.isfinite(b[i]):
            good = int(0)
        for j in range(b.shape[0]):
            A[i, j] = Real(0.5) * Real(G[t, i, j]) + Real(0.5) * Real(G[t, j, i])
            if not wp.isfinite(A[i, j]):
                good = int(0)
    for k in range(c.shape[0]):
        c[k] = Real(mu[t, k])
        on[k] = wp.int32(1)
        if mask.shape[0] > 0:
            on[k] = wp.int32(mask[t, k])
        if not (wp.isfinite(c[k]) and c[k] >= Real(0.0)):
            good = int(0)
    return good


@cache
def _solver(n: int, real: Any) -> Any:
    """Return the kernel that solves problems of n contacts with arrays of a scalar type."""
    m = 3 * n

    @wp.kernel(enable_backward=False, module="unique")
    def solve_kernel(
        G: wp.array3d(dtype=real), g: wp.array2d(dtype=real), mu: wp.array2d(dtype=real),
        mask: wp.array2d(dtype=wp.bool), convex: int, tol: Real,
        forces: wp.array3d(dtype=real), velocities: wp.array3d(dtype=real), status: wp.array(dtype=wp.int32),
        residual: wp.array(dtype=real), modes: wp.array2d(dtype=wp.int32), kinks: wp.array2d(dtype=wp.bool),
    ):  # fmt: skip
        t = wp.tid()
        A, H, M = wp.zeros((m, m), Real), wp.zeros((m, m), Real), wp.zeros((m, m), Real)
        b, f, turn, y = wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real)
        best, F, trial = wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real)
        c, w, s, tilt = wp.zeros(n, Real), wp.zeros(n, Real), wp.zeros(n, Real), wp.zeros(n, Real)
        on, reach = wp.zeros(n, wp.int32), wp.zeros(n, wp.int32)
        good = read(G, g, mu, mask, t, A, b, c, on)
        if good != 0:
            unit = prepare(A, b, c, on, w, s, reach, H, f, turn, tilt)
            descend(H, f, on, tilt, w, s, convex, unit, y, best, F, trial, M)
            for i in range(m):
                best[i] = best[i] * turn[i]
                if not wp.isfinite(best[i]):
                    good = int(2)
        if good != 1:
            for i in range(m):
                best[i] = Real(0.0)
        if good != 0:
            move(A, b, best, F)
            snap(best, F, c, on, w, s, convex)
            move(A, b, best, F)
        error = Real(0.0)
        rest = Real(0.0)
        for k in range(n):
            mode = wp.vec4d(Real(0.0), Real(1.0), Real(0.0), Real(0.0))
            if good != 0:
                mode = mode_of(best, F, c, on, w, s, convex, k)
                if on[k] != 0:
                    error = wp.max(error, error_of(best, F, c, w, s, convex, k))
            modes[t, k] = wp.int32(mode[0])
            kinks[t, k] = mode[3] >= Real(4.0)
            for a in range(3):
                forces[t, k, a] = real(best[3 * k + a])
                velocities[t, k, a] = real(F[3 * k + a])
        if good != 0:
            rest = worst_rest(A, best, F, on, w, s, reach, convex)
        code = int(2)
        if rest <= tol and error <= Real(1000.0) * tol:
            code = int(1)
        if rest <= tol and error <= tol:
            code = int(0)
        if good == 0:
            code = int(6)
            error = HUGE
        status[t] = wp.int32(code)
        residual[t] = real(error)

    return solve_kernel


@cache
def _gradient(n: int, real: Any) -> Any:
    """Return the kernel that takes weights on forces and velocities to gradients in G, g and mu."""
    m = 3 * n

    @wp.kernel(enable_backward=False, module="unique")
    def gradient_kernel(
        G: wp.array3d(dtype=real), g: wp.array2d(dtype=real), mu: wp.array2d(dtype=real),
        mask: wp.array2d(dtype=wp.bool), convex: int, forces: wp.array3d(dtype=real),
        on_forces: wp.array3d(dtype=real), on_velocities: wp.array3d(dtype=real),
        out_G: wp.array3d(dtype=real), out_g: wp.array2d(dtype=real), out_mu: wp.array2d(dtype=real),
    ):  # fmt: skip
        t = wp.tid()
        A, M, V = wp.zeros((m, m), Real), wp.zeros((m, m), Real), wp.zeros((m, m), Real)
        C, R, lean = wp.zeros((m, 3), Real), wp.zeros((m, 3), Real), wp.zeros((n, 2), Real)
        b, x, u, W = wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real)
        p, q, du, back = wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real), wp.zeros(m, Real)
        target, c, w, s = wp.zeros(m, Real), wp.zeros(n, Real), wp.zeros(n, Real), wp.zeros(n, Real)
        on, reach = wp.zeros(n, wp.int32), wp.zeros(n, wp.int32)
        good = read(G, g, mu, mask, t, A, b, c, on)
        if good != 0:
            for k in range(n):
                for a in range(3):
                    x[3 * k + a] = Real(forces[t, k, a])
                    du[3 * k + a] = Real(on_velocities[t, k, a])
            move(A, b, x, u)
            prepare(A, b, c, on, w, s, reach, M, p, q, W)
            assemble(A, x, u, c, on, w, s, convex, C, R, W, target, lean, M)
            rotate(M, V)
            for i in range(m):
                p[i] = Real(on_forces[t, i // 3, i % 3])
                for j in range(m):
                    p[i] = p[i] + A[i, j] * du[j]
            solve_transposed(M, V, C, R, p, du, q)
            for i in range(m):
                back[i] = Real(0.0)
                for j in range(3):
                    back[i] = back[i] + R[3 * (i // 3) + j, i % 3] * q[3 * (i // 3) + j]
            for i in range(m):
                b[i] = du[i] - back[i]
                W[i] = p[i]
                for j in range(m):
                    W[i] = W[i] - A[i, j] * back[j]
            for k in range(n):
                rate = lean[k, 0] * W[3 * k] + lean[k, 1] * W[3 * k + 1] + target[3 * k + 2] * q[3 * k + 2]
                if not wp.isfinite(rate):
                    good = int(0)
                c[k] = rate
            for i in range(m):
                if not wp.isfinite(b[i] * x[i]):
                    good = int(0)
        for i in range(m):
            for j in range(m):
                value = Real(0.0)
                if good != 0:
                    value = Real(0.5) * (b[i] * x[j] + b[j] * x[i])
                out_G[t, i, j] = real(value)
            if good == 0:
                b[i] = Real(0.0)
            out_g[t, i] = real(b[i])
        for k in range(n):
            if good == 0:
                c[k] = Real(0.0)
            out_mu[t, k] = real(c[k])

    return gradient_kernel


def solve(
    G: Any, g: Any, mu: Any, *, law: str = "coulomb", mask: Any = None, tol: float = 1e-8, tape: Any = None,
    out: Forces | None = None,
) -> Forces:  # fmt: skip
    """Solve a batch of contact problems on the device of its arrays.

    Parameters
    ----------
    G, g, mu
        Warp arrays (B, 3n, 3n), (B, 3n) and (B, n) of one scalar type, float32 or float64; n <= 8.
    law
        "coulomb" or "convex".
    mask
        (B, n) array of booleans: which contacts are there; all by default.
    tol
        Velocity error that counts as solved.
    tape
        A `warp.Tape`: its backward pass then adds the gradients to those of G, g and mu.
    out
        What an earlier call returned, to be filled again (for loops and captured graphs).

    Returns
    -------
    Forces
        Warp arrays on the same device.

    Raises
    ------
    ProblemError
        If a type, shape, device or law is wrong; never for what the entries are (see the status INVALID).
    """
    convex = int(check_law(law))
    real, mask = _check(G, g, mu, mask)
    batch, n = mu.shape
    if out is None:
        shape, grad = (batch, n, 3), tape is not None
        out = Forces(
            wp.empty(shape, real, device=G.device, requires_grad=grad),
            wp.empty(shape, real, device=G.device, requires_grad=grad),
            wp.empty(batch, wp.int32, device=G.device),
            wp.empty(batch, real, device=G.device),
            wp.empty((batch, n), wp.int32, device=G.device),
            wp.empty((batch, n), wp.bool, device=G.device),
        )
    given = [G, g, mu, mask, convex, Real(tol)]
    wp.launch(
        _solver(n, real), dim=batch, inputs=given, outputs=list(out), device=G.device, record_tape=False
    )
    if tape is not None:
        answer = out

        def backward() -> None:
            found = vjp(G, g, mu, answer, forces=answer.forces.grad, velocities=answer.velocities.grad,
                        law=law, mask=mask)  # fmt: skip
            for array, more in zip((G, g, mu), found, strict=True):
                if array.requires_grad:
                    _add(array.grad, more)

        tape.record_func(backward, [G, g, mu, out.forces, out.velocities])
    return out


def vjp(
    G: Any, g: Any, mu: Any, solution: Forces, *, forces: Any = None, velocities: Any = None,
    law: str = "coulomb", mask: Any = None,
) -> Gradients:  # fmt: skip
    """Return the gradients of Σ forces·f + Σ velocities·u, for (B, n, 3) weights.

    Each problem's are those of the modes it shows; zero where it is INVALID. The rest as for `solve`.

    Raises
    ------
    ProblemError
        As `solve`, and if the weights do not have the forces' shape and type.
    """
    convex = int(check_law(law))
    real, mask = _check(G, g, mu, mask)
    batch, n = mu.shape
    weights = []
    for name, value in (("forces", forces), ("velocities", velocities)):
        weights.append(wp.zeros((batch, n, 3), real, device=G.device) if value is None else value)
        if tuple(weights[-1].shape) != (batch, n, 3) or weights[-1].dtype is not real:
            raise ProblemError(f"{name} must be {real.__name__} {(batch, n, 3)}, got {weights[-1].shape}")
    out = Gradients(*(wp.empty(v.shape, real, device=G.device) for v in (G, g, mu)))
    given = [G, g, mu, mask, convex, solution.forces, *weights]
    kernel = _gradient(n, real)
    wp.launch(kernel, dim=batch, inputs=given, outputs=list(out), device=G.device, record_tape=False)
    return out


def _check(G: Any, g: Any, mu: Any, mask: Any) -> tuple[Any, Any]:
    """Return the scalar type, and the mask (an empty one for all contacts)."""
    for name, value, dims in (("G", G, 3), ("g", g, 2), ("mu", mu, 2)):
        if not isinstance(value, wp.array):
            raise ProblemError(f"{name} must be a Warp array, got {type(value).__name__}")
        if value.dtype not in (wp.float32, wp.float64) or value.dtype is not G.dtype:
            raise ProblemError(f"{name} must be float32 or float64, as G, got {value.dtype.__name__}")
        if value.ndim != dims or value.device != G.device:
            raise ProblemError(
                f"{name} must have {dims} dimensions on {G.device}, got {value.ndim} on {value.device}"
            )
    given = mask if mask is not None and mask.size else None
    n = check_shapes(G, g, mu, given)
    if n > MOST_CONTACTS:
        raise ProblemError(f"a thread takes at most {MOST_CONTACTS} contacts, got {n}")
    if given is None:
        mask = wp.empty((0, 0), wp.bool, device=G.device)
    return G.dtype, mask


@wp.kernel(enable_backward=False)
def _accumulate(total: wp.array(dtype=Any), more: wp.array(dtype=Any)):
    t = wp.tid()
    total[t] = total[t] + more[t]


def _add(total: Any, more: Any) -> None:
    """Add one array to another of its shape."""
    wp.launch(_accumulate, dim=total.size, inputs=[total.flatten(), more.flatten()], device=total.device,
              record_tape=False)  # fmt: skip
