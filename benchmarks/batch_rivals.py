"""A rival for gradients of contact: JAX through sweeps."""

from __future__ import annotations

from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray

SWEEPS = 200
"""Gauss-Seidel sweeps that JAX differentiates through, unrolled by `lax.scan`."""


def jax_sweeps(
    G: FloatArray, g: FloatArray, mu: float, weights: FloatArray
) -> tuple[Any, tuple[FloatArray, FloatArray]]:
    """Return a call that solves and differentiates all problems, and its forces and gradients by g.

    Projected Gauss-Seidel on exact cones (Coulomb's law: the friction disk of the present normal force), one
    contact after the other, in double precision, compiled and mapped over the batch.
    """
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)
    n = g.shape[1] // 3

    def contact(f: Any, k: int, A: Any, a: Any) -> Any:
        own = A[3 * k : 3 * k + 3, 3 * k : 3 * k + 3]
        u = A[3 * k : 3 * k + 3] @ f + a[3 * k : 3 * k + 3]
        normal = jnp.maximum(f[3 * k + 2] - u[2] / own[2, 2], 0.0)
        u = u[:2] + own[:2, 2] * (normal - f[3 * k + 2])
        w = f[3 * k : 3 * k + 2] - u / jnp.maximum(own[0, 0], own[1, 1])
        length = jnp.sqrt(jnp.maximum(w @ w, 1e-300))
        w = w * jnp.minimum(1.0, mu * normal / length)
        return f.at[3 * k : 3 * k + 3].set(jnp.array([w[0], w[1], normal]))

    def solve(A: Any, a: Any) -> Any:
        def sweep(f: Any, _: None) -> tuple[Any, None]:
            for k in range(n):
                f = contact(f, k, A, a)
            return f, None

        return jax.lax.scan(sweep, jnp.zeros(3 * n), None, length=SWEEPS)[0]

    def number(A: Any, a: Any, w: Any) -> Any:
        f = solve(A, a)
        return w[: 3 * n] @ f + w[3 * n :] @ (A @ f + a), f

    both = jax.jit(jax.vmap(jax.value_and_grad(number, argnums=1, has_aux=True)))
    given = jnp.asarray(G), jnp.asarray(g), jnp.asarray(weights.reshape(len(G), -1))
    (_, forces), slopes = both(*given)

    def call() -> None:
        jax.block_until_ready(both(*given))

    return call, (np.asarray(forces), np.asarray(slopes))
