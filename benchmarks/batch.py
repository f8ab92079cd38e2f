"""Batches of four-contact problems of Go2: solves and gradients per second, and Pinocchio's ADMM in a loop.

Run: surefoot bench batch [--quick]. On a busy machine pin it (`taskset -c 0,1`); every figure is the
best of its repeats. Cold starts, tolerance 1e-8; the worst velocity errors (`Residuals.velocity_error`) are
printed too, and the gradients' error against the polished derivative.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.batch_rivals import jax_sweeps
from benchmarks.contact.rivals import ITERATIONS, PinocchioCall, Setting
from benchmarks.timing import least_time
from surefoot.base.arrays import FloatArray
from surefoot.contact.batch.loops import derive_range, solve_range
from surefoot.mechanics.robot.dynamics import delassus_dense
from surefoot.mechanics.robot.jacobians import contact_jacobian

TOL, MU = 1e-8, 0.6


def go2_problems(count: int, seed: int = 0) -> tuple[FloatArray, FloatArray]:
    """G and g of Go2 on four feet, in random poses and moving at random: stick, slide and open mixed."""
    robot, rng = sf.load_robot("go2"), np.random.default_rng(seed)
    G, g = np.empty((count, 12, 12)), np.empty((count, 12))
    for b in range(count):
        q = robot.nominal.copy()
        q[7:] += rng.uniform(-0.3, 0.3, 12)
        v = rng.normal(size=18) * np.repeat([0.4, 0.6, 1.5], [3, 3, 12])
        v[2] -= 0.4
        stance = robot.stance(q)
        G[b], g[b] = delassus_dense(robot, q, stance), contact_jacobian(robot, q, stance) @ v
    return G, g


def compiled_loop(G: FloatArray, g: FloatArray, weights: FloatArray, repeats: int) -> dict[str, float]:
    """Seconds per problem of the compiled loop on one thread."""
    count = len(G)
    laws = np.broadcast_to(np.array([[[MU], [0.0], [np.inf]]]), (1, 3, 4)).copy()
    buffers = np.empty((count, 11, 3))
    done, out, good = np.empty(count, dtype=np.int64), np.empty_like(weights), np.ones(count, dtype=np.bool_)

    def solve() -> None:
        solve_range(G, g, laws, False, 1e-8, TOL, -1, False, buffers, done, 0, count)

    def pull() -> None:
        derive_range(G, laws, False, buffers, good, weights, out, good, 0, count)

    def both() -> None:
        solve()
        pull()

    return {
        "compiled loop, solve": least_time(solve, repeats) / count,
        "compiled loop, solve and vjp": least_time(both, repeats) / count,
    }


def batches(G: FloatArray, g: FloatArray, weights: FloatArray, repeats: int) -> dict[str, float]:
    """Seconds per problem of `solve_batch`, on one and on all threads."""
    out = {}
    f, u = weights[:, :4], weights[:, 4:]
    for name, threads in (("one thread", 1), ("all threads", None)):
        solve = partial(sf.solve_batch, G, g, MU, tol=TOL, threads=threads)

        def both(solve: Callable[..., Any] = solve) -> None:
            found = solve(derivative=True).derivative
            assert found is not None
            found.vjp(f, u)

        out[f"solve_batch, {name}"] = least_time(solve, repeats) / len(G)
        out[f"solve_batch, {name}, with vjp"] = least_time(both, repeats) / len(G)
    return out


def pinocchio_loop(G: FloatArray, g: FloatArray, repeats: int) -> tuple[float, float]:
    """Seconds per problem of Pinocchio's ADMM at the loosest tolerance that meets ours; its worst error."""
    problems = [sf.ContactProblem(A, a, MU) for A, a in zip(G, g, strict=True)]
    worst = np.inf
    for tol in (1e-6, 1e-8, 1e-10, 1e-12):
        rival = PinocchioCall(problems[0], Setting("admm"), tol, ITERATIONS)
        worst = max(sf.residuals(p, rival.fresh((p.G, p.g))).velocity_error for p in problems)
        if worst <= TOL:
            break
    return least_time(lambda: [rival.fresh((p.G, p.g)) for p in problems], repeats) / len(G), worst


def slope_error(G: FloatArray, g: FloatArray, weights: FloatArray, slope: FloatArray) -> float:
    """Largest relative error of one problem's gradient by g, against the polished derivative."""
    wanted = sf.solve(sf.ContactProblem(G, g, MU)).derivative().vjp(weights[:4], weights[4:]).g
    return float(np.abs(slope - wanted).max() / np.abs(wanted).max())


def gradient_error(G: FloatArray, g: FloatArray, weights: FloatArray) -> float:
    """Largest relative error of the batch's gradients, against the polished derivative, away from kinks."""
    found = sf.solve_batch(G, g, MU, tol=TOL, derivative=True).derivative
    assert found is not None
    back = found.vjp(weights[:, :4], weights[:, 4:])
    smooth = np.flatnonzero(found.distance > 1e-6)
    return max((slope_error(G[k], g[k], weights[k], back.g[k]) for k in smooth), default=0.0)


def jax_gradients(
    G: FloatArray, g: FloatArray, weights: FloatArray, repeats: int
) -> tuple[float, float, float]:
    """Seconds per problem of JAX through sweeps; its worst velocity error, and the gradients'."""
    call, (forces, slopes) = jax_sweeps(G, g, MU, weights)
    problems = [sf.ContactProblem(A, a, MU) for A, a in zip(G, g, strict=True)]
    answers = zip(problems, forces.reshape(len(G), -1, 3), strict=True)
    error = max(sf.residuals(p, f).velocity_error for p, f in answers)
    off = np.max([slope_error(*one) for one in zip(G, g, weights, slopes, strict=True)])
    return least_time(call, repeats) / len(G), error, float(off)


def measure(quick: bool = False) -> dict[str, Any]:
    """Return everything measured; times in seconds per problem by name."""
    count, repeats = (100, 5) if quick else (500, 60)
    G, g = go2_problems(count)
    weights = np.random.default_rng(1).normal(size=(count, 8, 3))
    few = sf.solve_batch(G, g, MU, tol=TOL)
    times = compiled_loop(G, g, weights, repeats)
    many = 8  # threads have something to do
    tiled = np.tile(G, (many, 1, 1)), np.tile(g, (many, 1)), np.tile(weights, (many, 1, 1))
    times |= batches(*tiled, 6 * repeats)  # on a busy machine both cores are seldom free at once
    velocity = {"ours": float(few.residual.max())}
    gradient = {"ours": gradient_error(G[:200], g[:200], weights[:200])}
    times["Pinocchio ADMM, solve"], velocity["Pinocchio"] = pinocchio_loop(
        G[:50], g[:50], max(repeats // 10, 3)
    )
    if importlib.util.find_spec("jax") is not None:
        times["JAX through sweeps, with vjp"], velocity["JAX"], gradient["JAX"] = jax_gradients(
            G[:100], g[:100], weights[:100], 3
        )
    return {
        "problems": count, "times": times, "velocity_error": velocity,
        "gradient_error": gradient,
    }  # fmt: skip
