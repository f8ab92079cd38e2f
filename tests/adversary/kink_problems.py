"""Contact problems whose solution lies exactly where contacts change their modes."""

from __future__ import annotations

from typing import Any

import numpy as np
from building import unit
from numpy.random import Generator

KINDS = ("grazing", "at rest", "edge stick", "low stick", "low edge", "high slide", "open", "stick", "slide")
"""At no load while slipping; without load and motion; on the cone's edge at rest; at a bound at rest; at the
upper bound while slipping freely; and three that are no kinks."""


def kinky(rng: Generator, contacts: int) -> tuple[dict[str, Any], np.ndarray, dict[str, np.ndarray]]:
    """Arguments of a problem, the (n, 3) forces that solve it, and rates of everything."""
    n = contacts
    convex = rng.random() < 0.4
    mu = rng.uniform(0.2, 0.9, n)
    J = rng.normal(size=(3 * n, 3 * n + 4))
    G = J @ J.T / (3 * n + 4)
    G = 0.5 * (G + G.T)
    λ, u, low, high = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n), np.full(n, np.inf)
    for k in range(n):
        λ[k], u[k], low[k], high[k] = _state(rng, str(rng.choice(KINDS)), float(mu[k]), convex)
    arguments = {
        "G": G, "g": u.ravel() - G @ λ.ravel(), "mu": mu, "normal_min": low, "normal_max": high,
        "law": "convex" if convex else "coulomb",
    }  # fmt: skip
    dG = rng.normal(size=G.shape)
    rates = {
        "G": dG + dG.T, "g": rng.normal(size=3 * n), "mu": 0.3 * rng.normal(size=n),
        "normal_min": rng.normal(size=n) * (low > 0.0), "normal_max": rng.normal(size=n) * np.isfinite(high),
    }  # fmt: skip
    return arguments, λ, rates


def _state(rng: Generator, kind: str, mu: float, convex: bool) -> tuple[np.ndarray, np.ndarray, float, float]:
    """λ, u and normal bounds of one contact."""
    height, slip = float(rng.uniform(0.5, 2.0)), unit(rng, 2) * rng.uniform(0.2, 1.0)
    speed = float(np.linalg.norm(slip))
    against, most, inside = -mu * slip / speed, mu * speed, 0.5 * mu * unit(rng, 2)
    lift = most if convex else 0.0
    none, moving = np.zeros(3), np.array([*slip, lift])
    loaded, held = np.array([*(height * against), height]), np.array([*(height * inside), height])
    return {
        "grazing": (none, moving, 0.0, np.inf),
        "at rest": (none, none, 0.0, np.inf),
        "edge stick": (loaded, none, 0.0, np.inf),
        "low stick": (held, none, height, np.inf),
        "low edge": (loaded, none, height, np.inf),
        "high slide": (loaded, moving, 0.0, height),
        "open": (none, moving + np.array([0.0, 0.0, 0.5]), 0.0, np.inf),
        "stick": (held, none, 0.0, np.inf),
        "slide": (loaded, moving, 0.0, np.inf),
    }[kind]


def moved(arguments: dict[str, Any], rates: dict[str, np.ndarray], step: float) -> dict[str, Any]:
    """The arguments after a step along the rates."""
    out = dict(arguments)
    for name, rate in rates.items():
        finite = np.isfinite(arguments[name])
        out[name] = np.where(finite, arguments[name] + step * rate, arguments[name])
    return out
