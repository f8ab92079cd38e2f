"""Contact problems and friction cones in JAX: jitted, batched, on any device, with exact gradients.

`solve` is written in JAX throughout: Newton's method on the central path (`batch.path`), followed to its end
or, with `smoothing`, to a point on it; where a fast descent fails, slower ones follow. Its gradient is
that of the active system, or of the path's point (`batch.modes`). `solve_on_host` hands the same problems to
`surefoot.solve_batch` on the CPU, and has the same gradients.

Limits: normal bounds 0 and infinity (a mask switches contacts off). In double precision, which needs
`jax.config.update("jax_enable_x64", True)`, errors are 1e-8 and below; in single precision, JAX's default,
about 1e-5 of the largest velocity.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from surefoot.batch import cones
from surefoot.batch.answers import INVALID, Forces, check_dtype, check_law, check_shapes
from surefoot.batch.certificate import lawful, scales
from surefoot.batch.host import solve_on_host as host_forces
from surefoot.batch.modes import active, certified, finite, gradients, snapped
from surefoot.batch.path import jacobian, misses, path_gradients, path_of
from surefoot.errors import MissingExtra, ProblemError

try:
    import jax
    import jax.numpy as jnp
except ImportError as error:
    raise MissingExtra("jax", "jax") from error

STAGES = ((0.05, 1e-3, 12, 1e-3), (0.3, 0.0, 40, 1e-3), (0.6, 0.0, 100, 1e-2))
"""Descents, tried one after another: the factor of sqrt(κ) in a step, the κ from which the next step goes to
the end, at most so many steps, and the proximal term in units of sqrt(κ)."""
HALVINGS = 6
"""Lengths tried in a step's line search."""
ENOUGH = 1e-12, 2e-6
"""Error of the scaled equations at which a problem is left, in double and in single precision."""
PROXIMAL = 1e-9, 3e-6
"""The least proximal term: redundant contacts leave the path's end singular."""
TOLERANCE = 1e-8, 1e-4
"""Velocity error that counts as solved, in double and in single precision."""


def solve(
    G: Any,
    g: Any,
    mu: Any,
    *,
    law: str = "coulomb",
    mask: Any = None,
    smoothing: float = 0.0,
    tol: float | None = None,
) -> Forces:
    """Solve a batch of contact problems; differentiable in G, g and mu.

    May be jitted, vmapped and differentiated (reverse mode).

    Parameters
    ----------
    G, g
        (..., 3n, 3n) Delassus operators and (..., 3n) free velocities, float32 or float64.
    mu
        Friction coefficient >= 0: a number, (n,) or (..., n).
    law
        "coulomb" or "convex".
    mask
        (n,) or (..., n) which contacts are there; all by default.
    smoothing
        Normal force times normal velocity [W] on the central path, the same for every contact; 0 for the
        law itself. The residual is then that of the path's equations.
    tol
        Residual that counts as solved; 1e-8 in double, 1e-4 in single precision by default.

    Returns
    -------
    Forces
        Look at its `status`. Gradients at a problem that is not solved are those of the modes it shows.

    Raises
    ------
    ProblemError
        If a shape, dtype, law or number is wrong; never for what the entries are (see the status INVALID).
    """
    prepared = _prepare(G, g, mu, mask)
    single = prepared[0].dtype == jnp.float32
    wanted = TOLERANCE[single] if tol is None else float(tol)
    if not 0.0 <= float(smoothing) < np.inf:
        raise ProblemError(f"smoothing must be >= 0 and finite, got {smoothing}")
    found: Forces = _solve((check_law(law), float(smoothing), wanted, False), *prepared)
    return found


def solve_on_host(
    G: Any, g: Any, mu: Any, *, law: str = "coulomb", mask: Any = None, tol: float = 1e-8
) -> Forces:
    """Solve as `solve` does, on the CPU in double precision by `jax.pure_callback`, with the same gradients.

    Faster than `solve` on a CPU; from an accelerator every call waits for the copies.
    """
    found: Forces = _solve((check_law(law), 0.0, float(tol), True), *_prepare(G, g, mu, mask))
    return found


def _prepare(G: Any, g: Any, mu: Any, mask: Any) -> tuple[Any, Any, Any, Any]:
    """Return G, g, mu (..., n) and the mask (..., n) as arrays of one dtype."""
    G, g, mu = jnp.asarray(G), jnp.asarray(g), jnp.asarray(mu)
    mask = None if mask is None else jnp.asarray(mask)
    n = check_shapes(G, g, mu, mask)
    check_dtype("G", G.dtype)
    check_dtype("g", g.dtype)
    dtype = jnp.result_type(G, g)
    shape = (*g.shape[:-1], n)
    on = jnp.ones(shape, bool) if mask is None else jnp.broadcast_to(mask.astype(bool), shape)
    return G.astype(dtype), g.astype(dtype), jnp.broadcast_to(mu.astype(dtype), shape), on


def _descend(path: Any, target: Any) -> tuple[Any, Any]:
    """Follow the path down to κ = target (...,); return the best y (..., 3n) and its error (...,)."""
    single = path.g.dtype == jnp.float32
    enough, least = ENOUGH[single], PROXIMAL[single]
    factor, jump, limit, share = (jnp.asarray(v, path.g.dtype) for v in zip(*STAGES, strict=True))
    floor = jnp.maximum(target, enough**2)
    start = jnp.where(jnp.arange(path.g.shape[-1]) % 3 == 2, 1.0, 0.0) + jnp.zeros_like(path.g)
    start = start.astype(path.g.dtype)
    zero = jnp.zeros_like(target)
    eye = jnp.eye(path.g.shape[-1], dtype=path.g.dtype)
    lengths = 0.5 ** np.arange(HALVINGS)

    def size(y: Any, kappa: Any) -> Any:
        return jnp.sqrt((misses(jnp, path, y, kappa) ** 2).sum(-1))

    def unfinished(state: Any) -> Any:
        _, _, _, error, stage, _ = state
        return ((error > enough) & (stage < len(STAGES))).any()

    def step(state: Any) -> Any:
        y, kappa, best, error, stage, count = state
        busy = (error > enough) & (stage < len(STAGES))
        at = jnp.minimum(stage, len(STAGES) - 1)
        root = jnp.sqrt(kappa)
        F = misses(jnp, path, y, kappa)
        proximal = jnp.maximum(share[at] * root, least)
        M, _ = jacobian(jnp, path, y, kappa, zero)
        move = -jnp.linalg.solve(M + proximal[..., None, None] * eye, F[..., None])[..., 0]
        move = jnp.where(jnp.isfinite(move).all(-1)[..., None], move, 0.0)
        before = jnp.sqrt((F * F).sum(-1))
        after = jax.vmap(lambda t: size(y + t * move, kappa))(jnp.asarray(lengths, y.dtype))
        column = (slice(None),) + (None,) * before.ndim
        fine = after <= (1.0 - 0.1 * lengths[column]) * before
        pick = jnp.where(fine.any(0), fine.argmax(0), after.argmin(0))
        t = jnp.asarray(lengths, y.dtype)[pick]
        y = jnp.where(busy[..., None], y + t[..., None] * move, y)
        reached = jnp.take_along_axis(after, pick[None], 0)[0]
        down = jnp.where(t == 1.0, factor[at] ** 2, factor[at])
        lower = jnp.where(kappa * down < jump[at], floor, jnp.maximum(kappa * down, floor))
        kappa = jnp.where(busy & (reached <= root), lower, kappa)
        now = size(y, target)
        better = busy & (now < error)
        best, error = jnp.where(better[..., None], y, best), jnp.where(better, now, error)
        count = count + 1
        fresh = busy & (error > enough) & (count >= limit[at])
        stage, count = jnp.where(fresh, stage + 1, stage), jnp.where(fresh, 0, count)
        y = jnp.where(fresh[..., None], start, y)
        kappa = jnp.where(fresh, jnp.maximum(1.0, target), kappa)
        return y, kappa, best, error, stage, count

    whole = jnp.zeros(target.shape, jnp.int32)
    first = (start, jnp.maximum(jnp.ones_like(target), target), start, size(start, target), whole, whole)
    _, _, best, error, _, _ = jax.lax.while_loop(unfinished, step, first)
    return best, error


Told = tuple[bool, float, float, bool]
"""Whether the law is convex, the smoothing, the tolerance, and whether the CPU solves."""


@partial(jax.jit, static_argnums=0)
def _answer(told: Told, G: Any, g: Any, mu: Any, on: Any) -> tuple[Forces, Any]:
    """Return the answer and the path's y, g where there is no path."""
    convex, smoothing, tol, hosted = told
    G, g, mu, good = lawful(jnp, G, g, mu)
    s = scales(jnp, G, g, on)
    if hosted:
        forces = _ask_host(convex, tol, G, g, mu, on)
        return certified(jnp, G, g, mu, on, s, forces, good, convex, tol), g
    path = path_of(jnp, G, g, mu, on, s, convex)
    target = smoothing / path.unit
    y, error = _descend(path, target)
    forces = jnp.reshape(path.turn * y, (*on.shape, 3))
    forces = jnp.where(on[..., None], forces, 0.0)
    if smoothing == 0.0:
        forces = snapped(jnp, G, g, mu, on, s, forces, convex)
    forces = jnp.where(jnp.isfinite(forces).all((-2, -1))[..., None, None], forces, 0.0)
    out = certified(jnp, G, g, mu, on, s, forces, good, convex, tol)
    if smoothing > 0.0:
        met = jnp.where(error <= tol, 0, jnp.where(error <= 1e3 * tol, 1, 2))
        status = jnp.where(good, met, INVALID)
        out = out._replace(status=status.astype(jnp.int32), residual=jnp.where(good, error, jnp.inf))
    return out, y


def _ask_host(convex: bool, tol: float, *arrays: Any) -> Any:
    """Return the forces (..., n, 3) of lawful G, g, mu and mask, from the CPU."""
    shape = jax.ShapeDtypeStruct((*arrays[-1].shape, 3), arrays[0].dtype)

    def ask(*given: Any) -> Any:
        matrices, free, frictions, there = (np.asarray(a) for a in given)
        return host_forces(matrices, free, frictions, there, convex, tol).astype(shape.dtype)

    return jax.pure_callback(ask, shape, *arrays, vmap_method="expand_dims")


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _solve(told: Told, G: Any, g: Any, mu: Any, on: Any) -> Forces:
    found: Forces = _answer(told, G, g, mu, on)[0]
    return found


def _forward(told: Told, G: Any, g: Any, mu: Any, on: Any) -> Any:
    out, y = _answer(told, G, g, mu, on)
    return out, (G, g, mu, on, out.forces, out.velocities, y)


@partial(jax.jit, static_argnums=0)
def _pull_back(told: Told, kept: Any, weights: tuple[Any, Any]) -> Any:
    convex, smoothing, _, _ = told
    G, g, mu, on, forces, velocities, y = kept
    G, g, mu, good = lawful(jnp, G, g, mu)
    s = scales(jnp, G, g, on)
    if smoothing > 0.0:
        path = path_of(jnp, G, g, mu, on, s, convex)
        target = smoothing / path.unit
        found = path_gradients(jnp, path, y, target, G, g, mu, (forces, velocities), weights)
    else:
        modes = active(jnp, forces, velocities, mu, s.weight, s.speed, on, convex)
        found = gradients(jnp, G, forces, modes, weights)
    return finite(jnp, found, good)


def _backward(told: Told, kept: Any, cotangents: Forces) -> Any:
    return (*_pull_back(told, kept, (cotangents.forces, cotangents.velocities)), None)


_solve.defvjp(_forward, _backward)


def cone_margin(forces: Any, mu: Any) -> Any:
    """Return the signed distance of (..., 3) forces to the friction cone [N]: (...), positive inside."""
    return cones.margin(jnp, jax.lax.stop_gradient, jnp.asarray(forces), mu)


def cone_project(forces: Any, mu: Any) -> Any:
    """Return the nearest points of the friction cone to (..., 3) forces [N]."""
    return cones.project(jnp, jax.lax.stop_gradient, jnp.asarray(forces), mu)


def friction_needed(forces: Any, least_normal: float = cones.LEAST_NORMAL) -> Any:
    """Return the friction coefficient (...) that (..., 3) forces need; see `batch.cones.friction_needed`."""
    return cones.friction_needed(jnp, jax.lax.stop_gradient, jnp.asarray(forces), least_normal)
