"""Derivatives of contact problems in 50-digit arithmetic, without a formula for one.

The natural map λ - P_K(λ - (u + Γ(u)) / w) is solved in decimals, at the problem and at one that is moved by
1e-22 along a direction: the difference is the derivative to about 20 digits. Projections are those of
`admissible`. Newton's matrix is a difference quotient, rounded to doubles; its steps are those
of least squares, since redundant contacts make it singular.

The problems are of two kinds: `regular` ones with a full-rank G and a lawful state of chosen modes, and
`redundant` ones, a rigid body on more points than it has degrees of freedom, in numbers that doubles hold
exactly (a rank that is only kept up to rounding would not be kept at all).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from typing import Any

import numpy as np
from admissible import nearest, norm
from building import unit
from numpy.random import Generator

DIGITS = Context(prec=80, Emin=-999_999, Emax=999_999)
STEP, NUDGE = Decimal("1e-22"), Decimal("1e-25")
"""Steps of the derivative and of Newton's matrix."""
LEAST = Decimal("1e-46")
KINDS = ("open", "stick", "slide", "low stick", "low slide", "high stick", "high slide", "held")


@dataclass(frozen=True)
class Moving:
    """A contact problem and a direction in which it moves.

    Attributes
    ----------
    arguments
        Keyword arguments of `ContactProblem`.
    rates
        Those of `jvp`.
    moved
        Returns G and g (as lists of decimals) at a decimal step along the direction.
    regular
        Whether G has full rank.
    """

    arguments: dict[str, Any]
    rates: dict[str, np.ndarray]
    moved: Callable[[Decimal], tuple[np.ndarray, np.ndarray]]
    regular: bool


def decimals(array: np.ndarray) -> np.ndarray:
    """Return doubles as decimals, exactly."""
    return np.array([Decimal(float(x)) for x in np.ravel(array)], dtype=object).reshape(np.shape(array))


# ------------------------------------------------------------------------------------------------ problems


def _state(rng: Generator, kind: str, mu: float, convex: bool) -> tuple[Any, ...]:
    """Return λ, u and the normal bounds of a contact of a kind, away from every change of it."""
    height, low, high = float(rng.uniform(0.5, 2.0)), 0.0, np.inf
    slip = unit(rng, 2) * rng.uniform(0.2, 1.0)
    if kind == "held":
        return rng.normal(size=3), np.zeros(3), 0.0, np.inf
    against, most = -mu * slip / np.linalg.norm(slip), mu * float(np.linalg.norm(slip))
    inside = mu * rng.uniform(0.0, 0.8) * unit(rng, 2)
    lift = most if convex else 0.0
    if kind == "open":
        return np.zeros(3), np.array([*slip, lift + rng.uniform(0.2, 1.0)]), low, high
    if rng.random() < 0.3 or kind.startswith("low"):
        low = height if kind.startswith("low") else height - rng.uniform(0.1, 0.4)
    if rng.random() < 0.3 or kind.startswith("high"):
        high = height if kind.startswith("high") else height + rng.uniform(0.1, 0.4)
    push = {"low": 1.0, "hig": -1.0}.get(kind[:3], 0.0) * rng.uniform(0.2, 1.0)
    if kind.endswith("stick"):
        return np.array([*(height * inside), height]), np.array([0.0, 0.0, push]), low, high
    return np.array([*(height * against), height]), np.array([*slip, lift + push]), low, high


def regular(rng: Generator, contacts: int, plain: bool = False) -> Moving:
    """A problem with a full-rank G and a solution of random modes."""
    n = contacts
    convex = rng.random() < 0.4
    mu = rng.uniform(0.2, 0.9, n)
    kinds = rng.choice(KINDS, n, p=[0.25, 0.25, 0.3, 0.03, 0.04, 0.03, 0.04, 0.06])
    if plain:
        kinds = rng.choice(KINDS[:3], n)
    J = rng.normal(size=(3 * n, 3 * n + 4))
    G = J @ J.T / (3 * n + 4)
    G = 0.5 * (G + G.T)
    parts = [_state(rng, str(kinds[k]), float(mu[k]), convex) for k in range(n)]
    λ, u = np.array([p[0] for p in parts]), np.array([p[1] for p in parts])
    g = u.ravel() - G @ λ.ravel()
    R = rng.uniform(0.0, 0.3, 3 * n) if rng.random() < 0.3 else np.zeros(3 * n)
    g -= R * λ.ravel()
    low, high = np.array([p[2] for p in parts]), np.array([p[3] for p in parts])
    arguments = {
        "G": G, "g": g, "mu": mu, "normal_min": low, "normal_max": high, "compliance": R,
        "law": "convex" if convex else "coulomb", "bilateral": kinds == "held",
    }  # fmt: skip
    dG = rng.normal(size=G.shape)
    rates = {
        "G": dG + dG.T, "g": rng.normal(size=3 * n), "mu": rng.normal(size=n),
        "compliance": rng.normal(size=3 * n),
        "normal_min": rng.normal(size=n) * (low > 0), "normal_max": rng.normal(size=n) * np.isfinite(high),
    }  # fmt: skip
    exact = {name: decimals(v) for name, v in (("G", G), ("g", g), ("R", R), ("dR", rates["compliance"]))}
    slopes = decimals(rates["G"]), decimals(rates["g"])

    def moved(t: Decimal) -> tuple[np.ndarray, np.ndarray]:
        A = exact["G"] + t * slopes[0]
        A[np.diag_indices(3 * n)] += exact["R"] + t * exact["dR"]
        return A, exact["g"] + t * slopes[1]

    return Moving(arguments, rates, moved, True)


def redundant(rng: Generator, contacts: int) -> Moving:
    """A rigid body that lands on more points of a plane than it needs, in numbers that doubles hold."""
    n = max(contacts, 3)
    places = rng.permutation(81)[:n]
    p = np.stack([places % 9 - 4, places // 9 - 4, rng.integers(-1, 0, n, endpoint=True)], axis=1) / 4.0
    p[:, 2] = -0.5
    inverse = np.array([1.0, 1.0, 1.0, *rng.choice([2.0, 4.0, 8.0], 3)])
    v = rng.integers(-64, 65, 6) / 64.0
    v[2], v[3:] = -abs(v[2]) - 0.5, v[3:] / 4.0
    slope, push = rng.integers(-8, 9, (n, 3)) / 8.0, rng.integers(-8, 9, 6) / 8.0
    weights = rng.integers(-4, 5, 6) / 16.0
    mu = rng.choice([0.25, 0.5, 0.75], n)

    def jacobian(t: Decimal) -> np.ndarray:
        q = decimals(p) + t * decimals(slope)
        J = np.full((3 * n, 6), Decimal(0), dtype=object)
        for k in range(n):
            x, y, z = q[k]
            J[3 * k : 3 * k + 3, :3] = decimals(np.eye(3))
            J[3 * k : 3 * k + 3, 3:] = np.array([[0, z, -y], [-z, 0, x], [y, -x, 0]], dtype=object) * Decimal(
                1
            )
        return J

    def moved(t: Decimal) -> tuple[np.ndarray, np.ndarray]:
        J = jacobian(t)
        return (J * (decimals(inverse) + t * decimals(weights))) @ J.T, J @ (decimals(v) + t * decimals(push))

    with localcontext(DIGITS):
        G, g = moved(Decimal(0))
        ahead, behind = moved(Decimal(1)), moved(Decimal(-1))
        J, dJ = jacobian(Decimal(0)), jacobian(Decimal(1)) - jacobian(Decimal(0))
        dG = (dJ * decimals(inverse)) @ J.T + (J * decimals(weights)) @ J.T + (J * decimals(inverse)) @ dJ.T
        dg = (ahead[1] - behind[1]) / 2
    law = "convex" if rng.random() < 0.4 else "coulomb"
    arguments = {"G": G.astype(float), "g": g.astype(float), "mu": mu, "law": law}
    rates = {"G": dG.astype(float), "g": dg.astype(float), "mu": rng.integers(-8, 9, n) / 8.0}
    return Moving(arguments, rates, moved, False)


# ----------------------------------------------------------------------------------------------- references


class Reference:
    """The natural map of a problem in decimals, at one step along its direction."""

    def __init__(self, moving: Moving, t: Decimal) -> None:
        a, n = moving.arguments, moving.arguments["mu"].size
        self.G, self.g = moving.moved(t)
        self.n = n

        def at(name: str, default: float) -> np.ndarray:
            value = decimals(np.broadcast_to(np.asarray(a.get(name, default), dtype=float), n))
            return value + t * decimals(moving.rates.get(name, np.zeros(n)))

        self.mu = at("mu", 0.0)
        self.low, self.high = at("normal_min", 0.0), at("normal_max", np.inf)
        self.convex = a["law"] == "convex"
        self.held = a.get("bilateral", np.zeros(n, dtype=bool))
        blocks = self.G.astype(float)
        self.w = [
            Decimal(float(np.linalg.norm(blocks[3 * k : 3 * k + 3, 3 * k : 3 * k + 3], 2))) for k in range(n)
        ]

    def contact(self, k: int, λ: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The natural map of contact k, as a velocity."""
        if self.held[k]:
            return u
        shift = Decimal(0)
        if not self.convex:
            shift = self.mu[k] * norm(tuple(u[:2]))
        w = self.w[k]
        z = (λ[0] - u[0] / w, λ[1] - u[1] / w, λ[2] - (u[2] + shift) / w)
        high = None if self.high[k].is_infinite() else self.high[k]
        near = nearest(z, self.mu[k], self.low[k], high, None)
        return w * (λ - np.array(near, dtype=object))

    def value(self, λ: np.ndarray, u: np.ndarray) -> np.ndarray:
        return np.concatenate(
            [self.contact(k, λ[3 * k : 3 * k + 3], u[3 * k : 3 * k + 3]) for k in range(self.n)]
        )

    def matrix(self, λ: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The derivative of the map, as doubles: per contact after its λ and u, then u = G λ + g."""
        m = 3 * self.n
        G, out = self.G.astype(float), np.zeros((m, m))
        for k in range(self.n):
            own = slice(3 * k, 3 * k + 3)
            for a in range(3):
                step = np.array([NUDGE if b == a else Decimal(0) for b in range(3)], dtype=object)
                ahead, behind = (self.contact(k, λ[own] + s * step, u[own]) for s in (1, -1))
                out[own, 3 * k + a] += ((ahead - behind) / (2 * NUDGE)).astype(float)
                ahead, behind = (self.contact(k, λ[own], u[own] + s * step) for s in (1, -1))
                out[own] += np.outer(((ahead - behind) / (2 * NUDGE)).astype(float), G[3 * k + a])
        return out

    def solve(self, λ: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """Return λ and u of a solution next to λ, and the condition of the map there."""
        inverse = condition = None
        for _ in range(40):
            u = self.G @ λ + self.g
            F = self.value(λ, u)
            if max(abs(x) for x in F) < LEAST:
                return λ, u, float(condition or 1.0)
            if inverse is None or _ < 3:
                matrix = self.matrix(λ, u)
                values = np.linalg.svd(matrix, compute_uv=False)
                kept = values[values > 1e-11 * values[0]]
                condition = values[0] / kept[-1]
                inverse = np.linalg.pinv(matrix, rcond=1e-11)
            scale = max(abs(x) for x in F)
            λ = λ - decimals(inverse @ (F / scale).astype(float)) * scale
        raise ArithmeticError("the reference did not converge")


def reference(moving: Moving, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the (n, 3) rates of forces and velocities next to given forces, and the map's condition."""
    with localcontext(DIGITS):
        λ, u, condition = Reference(moving, Decimal(0)).solve(decimals(forces.ravel()))
        ahead, after, _ = Reference(moving, STEP).solve(λ)
        rate = ((ahead - λ) / STEP).astype(float).reshape(-1, 3)
        return rate, ((after - u) / STEP).astype(float).reshape(-1, 3), condition
