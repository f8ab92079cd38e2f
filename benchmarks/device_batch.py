"""Time the Warp kernel on a device: problems a second, with their accuracy.

    python -m benchmarks.device_batch --device cuda --problems 2000000
    python -m benchmarks.device_batch --device cpu --problems 20000

Four contacts on a body with four legs: sticking, sliding and open ones. The goal on an H200 is 20 million
problems a second at a velocity error of 1e-6.
"""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks.timing import least_time
from surefoot.arrays import FloatArray

REPEATS = 5
DISTINCT = 4096
"""Problems made; a batch repeats them."""


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


def main() -> None:
    """Print one line for the solves and one for the gradients."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--device", default="cpu", help="cpu, cuda, cuda:1")
    parser.add_argument("--problems", type=int, default=20_000)
    parser.add_argument("--tol", type=float, default=1e-6)
    parser.add_argument(
        "--single", action="store_true", help="float32 arrays (computed in double all the same)"
    )
    chosen = parser.parse_args()
    import warp as wp

    from surefoot.batch import warp as sfw

    wp.config.quiet = True
    real = wp.float32 if chosen.single else wp.float64
    repeats = -(-chosen.problems // DISTINCT)
    arrays = [
        wp.array(
            np.tile(v, (repeats,) + (1,) * (v.ndim - 1))[: chosen.problems], dtype=real, device=chosen.device
        )
        for v in problems(min(DISTINCT, chosen.problems))
    ]
    G, g, mu = arrays
    found = sfw.solve(G, g, mu, tol=chosen.tol)  # compiles
    weights = wp.full((chosen.problems, 4, 3), real(1.0), dtype=real, device=chosen.device)
    sfw.vjp(G, g, mu, found, forces=weights)

    def solves() -> None:
        sfw.solve(G, g, mu, tol=chosen.tol, out=found)
        wp.synchronize_device(chosen.device)

    def gradients() -> None:
        sfw.vjp(G, g, mu, found, forces=weights)
        wp.synchronize_device(chosen.device)

    wp.synchronize_device(chosen.device)
    for call in (solves, gradients):
        rate = chosen.problems / least_time(call, REPEATS)
        print(f"{call.__name__}: {rate:,.0f} a second on {chosen.device}")
    status, residual = found.status.numpy(), found.residual.numpy()
    print(f"solved: {np.mean(status == 0):.4%}")
    print(f"velocity error: median {np.median(residual):.1e}, most {residual.max():.1e}")


if __name__ == "__main__":
    main()
