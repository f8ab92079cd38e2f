"""Rivals for gradients of contact: JAX through sweeps, and MuJoCo's differences of a step."""

from __future__ import annotations

from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.timing import interleaved
from surefoot.arrays import FloatArray

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


def step_derivatives(calls: int) -> dict[str, float]:
    """Seconds of a step of Go2 with its A and B, and of MuJoCo's finite differences for A alone, in turns."""
    import mujoco

    from surefoot.stepping import Knot, StepOptions, Stepper, step_derivative

    robot = sf.load_robot("go2")
    stepper = Stepper(robot)
    state = stepper.start(sf.place(robot), np.r_[0.1, 0.05, -0.1, np.full(15, 0.01)])
    torques = np.zeros(robot.joints)
    for _ in range(10):
        state = stepper.step(state, torques).state
    knot = Knot(Stepper(robot, options=StepOptions(order=1)))
    knot.step(state.q, state.v, torques)
    out = knot.derivative()

    def first_order(smoothing: float) -> None:
        knot.step(state.q, state.v, torques)
        knot.derivative(smoothing, out)

    world: Any = sf.MujocoWorld(robot)
    world.reset(sf.place(robot))
    for _ in range(100):
        world.step(torques)
    m, d = world.model, world.data
    A = np.zeros((2 * m.nv + m.na, 2 * m.nv + m.na))
    found = interleaved(
        {
            "step": lambda _: stepper.step(state, torques),
            "step with A and B": lambda _: step_derivative(stepper, state, torques).A,
            "first-order step": lambda _: knot.step(state.q, state.v, torques),
            "first-order step with A and B": lambda _: first_order(0.0),
            "first-order step with A and B, smoothed": lambda _: first_order(1e-4),
            "MuJoCo mjd_transitionFD, A alone": lambda _: mujoco.mjd_transitionFD(
                m, d, 1e-6, True, A, None, None, None
            ),
        },
        budget=1.0, most=calls,
    )  # fmt: skip
    return {name: timing.median for name, timing in found.items()}
