"""Time batches of contact problems in JAX or PyTorch on a device: problems a second, with their accuracy.

    python -m benchmarks.device_batch --framework jax --problems 20000
    python -m benchmarks.device_batch --framework torch --device cuda --problems 2000000

Four contacts on a body with four legs: sticking, sliding and open ones. The goal on an H200 is 20 million
problems a second at a velocity error of 1e-6.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.timing import least_time
from surefoot.base.arrays import FloatArray

REPEATS = 5
DISTINCT = 4096
"""Problems made; a batch repeats them."""
Calls = tuple[Callable[[], Any], Callable[[], Any]]


def problems(count: int, seed: int = 0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return G (count, 12, 12), g (count, 12) and mu (count, 4) of a body with four three-jointed legs."""
    rng = np.random.default_rng(seed)
    feet = np.array([[x, y, -0.3] for x in (0.19, -0.19) for y in (0.14, -0.14)])
    inverse = 1.0 / np.array([16.0, 16.0, 16.0, 0.1, 0.3, 0.3] + [0.05] * 12)
    G, g = np.empty((count, 12, 12)), np.empty((count, 12))
    for k in range(count):
        J = np.zeros((12, 18))
        for i, p in enumerate(feet + 0.03 * rng.normal(size=(4, 3))):
            rows = slice(3 * i, 3 * i + 3)
            J[rows, :3] = np.eye(3)
            J[rows, 3:6] = [[0, p[2], -p[1]], [-p[2], 0, p[0]], [p[1], -p[0], 0]]
            J[rows, 6 + 3 * i : 9 + 3 * i] = 0.2 * np.eye(3) + 0.05 * rng.normal(size=(3, 3))
        speed = 0.3 * rng.normal(size=18) * rng.choice([0.1, 1.0])
        speed[2] -= 0.2
        G[k], g[k] = J * inverse @ J.T, J @ speed
    return G, g, rng.uniform(0.1, 0.9, (count, 4))


def in_jax(arrays: tuple[FloatArray, ...], device: str, tol: float) -> Calls:
    """Return calls that solve, and that take the gradient of the forces' sum, on a device of JAX."""
    import jax

    from surefoot.contact.batch import jax as sfj

    jax.config.update("jax_enable_x64", True)
    where = jax.devices(device)[0]
    given = [jax.device_put(v, where) for v in arrays]
    solve = jax.jit(lambda *a: sfj.solve(*a, tol=tol))
    slope = jax.jit(jax.grad(lambda *a: sfj.solve(*a, tol=tol).forces.sum(), argnums=(0, 1, 2)))
    return lambda: jax.block_until_ready(solve(*given)), lambda: jax.block_until_ready(slope(*given))


def in_torch(arrays: tuple[FloatArray, ...], device: str, tol: float) -> Calls:
    """Return calls that solve, and that take the gradient of the forces' sum, on a device of PyTorch."""
    import torch

    from surefoot.contact.batch import torch as sft

    given = [torch.tensor(v, dtype=torch.float64, device=device, requires_grad=True) for v in arrays]

    def done(found: Any) -> Any:
        if device != "cpu":
            torch.cuda.synchronize()
        return found

    def slope() -> Any:
        return done(torch.autograd.grad(sft.solve(*given, tol=tol).forces.sum(), given))

    return lambda: done(sft.solve(*given, tol=tol)), slope


def main() -> None:
    """Print a line for the solves, one for solves with gradients, and how well they were solved."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--framework", choices=("jax", "torch"), default="jax")
    parser.add_argument("--device", default="cpu", help="cpu, gpu (JAX), cuda (PyTorch)")
    parser.add_argument("--problems", type=int, default=20_000)
    parser.add_argument("--tol", type=float, default=1e-6)
    chosen = parser.parse_args()
    repeats = -(-chosen.problems // DISTINCT)
    arrays = tuple(
        np.tile(v, (repeats,) + (1,) * (v.ndim - 1))[: chosen.problems]
        for v in problems(min(DISTINCT, chosen.problems))
    )
    calls = {"jax": in_jax, "torch": in_torch}[chosen.framework](arrays, chosen.device, chosen.tol)
    found = calls[0]()  # compiles
    for name, call in zip(("solves", "solves with gradients"), calls, strict=True):
        call()
        rate = chosen.problems / least_time(call, REPEATS)
        print(f"{name}: {rate:,.0f} a second on {chosen.device}")
    status, residual = (
        np.asarray(v.detach().cpu() if hasattr(v, "detach") else v) for v in (found.status, found.residual)
    )
    print(f"solved: {np.mean(status == 0):.4%}")
    print(f"velocity error: median {np.median(residual):.1e}, most {residual.max():.1e}")


if __name__ == "__main__":
    main()
