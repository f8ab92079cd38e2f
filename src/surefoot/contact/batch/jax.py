"""Contact problems in JAX: jitted, batched, on any device, with exact gradients.

`solve` is the array form of the law (`batch.array_form`) in JAX throughout. `solve_on_host` hands the same
problems to `surefoot.solve_batch` on the CPU, and has the same gradients.

Limits: normal bounds 0 and infinity (a mask switches contacts off). In double precision, which needs
`jax.config.update("jax_enable_x64", True)`, errors are 1e-8 and below; in single precision, JAX's default,
about 1e-5 of the largest velocity.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from surefoot.base.errors import needs
from surefoot.contact.batch.answers import Forces, check_dtype, check_shapes
from surefoot.contact.batch.array_form import BatchRequest, answer, pull_back, request
from surefoot.contact.batch.cpu_fallback import solve_on_host as host_forces
from surefoot.contact.batch.frameworks import Framework

with needs("jax", "jax"):
    import jax
    import jax.numpy as jnp


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
    given = _prepare(G, g, mu, mask)
    found: Forces = _solve(request(JAX, given[1], law, smoothing, tol, False), *given)
    return found


def solve_on_host(
    G: Any, g: Any, mu: Any, *, law: str = "coulomb", mask: Any = None, tol: float = 1e-8
) -> Forces:
    """Solve as `solve` does, on the CPU in double precision by `jax.pure_callback`, with the same gradients.

    Faster than `solve` on a CPU; from an accelerator every call waits for the copies.
    """
    given = _prepare(G, g, mu, mask)
    found: Forces = _solve(request(JAX, given[1], law, 0.0, tol, True), *given)
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


def _ask_host(convex: bool, tol: float, *arrays: Any) -> Any:
    """Return the forces (..., n, 3) of lawful G, g, mu and mask, from the CPU."""
    shape = jax.ShapeDtypeStruct((*arrays[-1].shape, 3), arrays[0].dtype)

    def ask(*given: Any) -> Any:
        return host_forces(convex, tol, *(np.asarray(a) for a in given)).astype(shape.dtype)

    return jax.pure_callback(ask, shape, *arrays, vmap_method="expand_dims")


JAX = Framework(
    jnp,
    eye=lambda n, like: jnp.eye(n, dtype=like.dtype),
    integers=lambda v: v.astype(jnp.int32),
    solve=jnp.linalg.solve,
    loop=jax.lax.while_loop,
    ask_host=_ask_host,
)


@partial(jax.jit, static_argnums=0)
def _answer(asked: BatchRequest, *given: Any) -> tuple[Forces, Any]:
    return answer(JAX, asked, *given)


@partial(jax.custom_vjp, nondiff_argnums=(0,))
def _solve(asked: BatchRequest, G: Any, g: Any, mu: Any, on: Any) -> Forces:
    found: Forces = _answer(asked, G, g, mu, on)[0]
    return found


def _forward(asked: BatchRequest, *given: Any) -> Any:
    out, y = _answer(asked, *given)
    return out, (given, (out.forces, out.velocities, y))


@partial(jax.jit, static_argnums=0)
def _backward(asked: BatchRequest, kept: Any, cotangents: Forces) -> Any:
    given, point = kept
    return (*pull_back(JAX, asked, given, point, (cotangents.forces, cotangents.velocities)), None)


_solve.defvjp(_forward, _backward)
