"""A judge of contact verdicts that shares no arithmetic with the package: decimals, own projections.

What it judges is the definition of SOLVED (docs, `surefoot.contact.problem.residuals`)::

    eps_k = w_k ||λ_k - P_K(λ_k - (u_k + Γ(u_k)) / w_k)||,   w_k = ||G_kk||₂
    s     = max ||u_k|| over the block's contacts that are on, at the admissible forces nearest to zero
            (a contact that is off joins nothing, nor do entries of G at rounding level)
    SOLVED:  max eps_k <= tol s   and   max_k 4 eps Σ_j ||G_kj|| ||λ_j|| <= tol s

Velocities are summed with 80 decimal digits, so that nothing cancels; projections try every face, edge and
corner and keep the nearest admissible point. Proofs of infeasibility are checked in rational numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from typing import Any

import numpy as np
from admissible import ONE, ZERO, Vector, nearest, norm, rays

DIGITS = Context(prec=80, Emin=-999_999, Emax=999_999)
EPS = 2.0**-52
REACH = 1e6
"""A proof of infeasibility must reach so many times the force s / least ||G_kk||."""
NOISE, LENT = 1e-14, 1e-5
"""Share of their contacts' sizes up to which entries of G are rounding; share of speed lent through them."""
VANISHING = 1e-290
"""Speeds below this [m/s] are rounding: numbers next to them have no 16 digits any more."""
NOWHERE = 1e-2
"""Step, as a share of ||λ||, of the one-sided derivative that stands for a normal cone where G_kk is zero."""


@dataclass(frozen=True)
class Data:
    """A contact problem as plain numbers, read from the arguments of `ContactProblem`."""

    G: np.ndarray
    g: np.ndarray
    mu: np.ndarray
    low: np.ndarray
    high: np.ndarray
    convex: bool
    facets: int
    inner: bool
    held: np.ndarray

    @property
    def contacts(self) -> int:
        return self.mu.size


def read(arguments: dict[str, Any]) -> Data:
    """The data of the keyword arguments of a `ContactProblem`."""
    G = arguments["G"]
    G = np.array(G.toarray() if hasattr(G, "toarray") else G, dtype=float)
    g = np.array(arguments["g"], dtype=float)
    n = g.size // 3
    R = np.asarray(arguments.get("compliance", 0.0), dtype=float)
    if R.shape == (n,):
        R = np.repeat(R, 3)
    G = 0.5 * (G + G.T)
    G[np.diag_indices(3 * n)] += R
    held = arguments.get("bilateral")
    return Data(
        G,
        g,
        np.broadcast_to(np.asarray(arguments["mu"], dtype=float), n),
        np.broadcast_to(np.asarray(arguments.get("normal_min", 0.0), dtype=float), n),
        np.broadcast_to(np.asarray(arguments.get("normal_max", np.inf), dtype=float), n),
        arguments.get("law", "coulomb") == "convex",
        arguments.get("facets") or 0,
        arguments.get("fit", "inner") == "inner",
        np.zeros(n, dtype=bool) if held is None else np.asarray(held),
    )


def _sizes(G: np.ndarray) -> np.ndarray:
    """||G_kj||₂ of the 3x3 blocks, scaled so that nothing overflows or underflows."""
    n = G.shape[0] // 3
    blocks = G.reshape(n, 3, n, 3).transpose(0, 2, 1, 3)
    peak = np.abs(blocks).max(axis=(2, 3), initial=0.0)
    safe = np.where(peak > 0.0, peak, 1.0)
    return np.linalg.norm(blocks / safe[:, :, None, None], 2, axis=(2, 3)) * peak


def connected(data: Data, noise: float = 0.0) -> np.ndarray:
    """The number of the connected block of each contact: union-find over contacts that are on.

    Entries of G_kj up to `noise` times sqrt(trace G_kk trace G_jj) join nothing.
    """
    n = data.contacts
    parent = list(range(n))

    def root(k: int) -> int:
        while parent[k] != k:
            parent[k] = parent[parent[k]]
            k = parent[k]
        return k

    peak = np.abs(data.G).reshape(n, 3, n, 3).max(axis=(1, 3), initial=0.0)
    size = np.sqrt(np.maximum(np.diagonal(data.G).reshape(n, 3).sum(axis=1), 0.0))
    touching = peak > noise * size[:, None] * size
    off = data.high <= 0.0
    touching[off], touching[:, off] = False, False
    for k, j in np.argwhere(touching):
        parent[root(int(k))] = root(int(j))
    return np.array([root(k) for k in range(n)], dtype=int)


def velocities(data: Data, forces: np.ndarray) -> list[Vector]:
    """u = G λ + g, summed with 80 digits."""
    exact = DIGITS.create_decimal_from_float
    f = [exact(float(x)) for x in forces.ravel()]
    pushed = np.flatnonzero(forces.ravel())
    rows = []
    for i in range(data.g.size):
        total = exact(float(data.g[i]))
        for j in pushed[np.flatnonzero(data.G[i, pushed])]:
            total += exact(float(data.G[i, j])) * f[j]
        rows.append(total)
    return [(rows[i], rows[i + 1], rows[i + 2]) for i in range(0, len(rows), 3)]


def velocities_of(data: Data, forces: np.ndarray) -> list[list[float]]:
    """The velocities (n, 3) of forces, rounded once."""
    with localcontext(DIGITS):
        return [[float(x) for x in v] for v in velocities(data, forces)]


def velocity_rounding(data: Data, forces: np.ndarray) -> np.ndarray:
    """(n,) bound on what summing in double precision may do to a velocity [m/s]."""
    lengths = np.array([math.hypot(*f) for f in forces.tolist()])
    with np.errstate(over="ignore"):
        return EPS * (3 * data.contacts + 3) * (_sizes(data.G) @ lengths)


@dataclass(frozen=True)
class Verdict:
    """What the definition says of forces.

    Attributes
    ----------
    finite
        Whether every force is.
    error
        (n,) eps_k [m/s].
    scale
        (n,) s of the contact's connected block [m/s].
    share
        Largest eps_k / (sqrt(1 + mu²) s); 0/0 is 0.
    worst
        Largest eps_k / s.
    rounding
        Largest 4 eps Σ_j ||G_kj|| ||λ_j|| / s of contacts that are on; the least forces of parts at rest are
        known without it.
    """

    finite: bool
    error: np.ndarray
    scale: np.ndarray
    share: float
    worst: float
    rounding: float

    def solved(self, tol: float) -> bool:
        """Whether both lines of the definition hold."""
        close = bool((self.error <= tol * self.scale).all())
        return self.finite and close and bool(self.rounding <= tol)


def judge(data: Data, forces: np.ndarray) -> Verdict:
    """Judge (n, 3) forces."""
    n = data.contacts
    if not np.isfinite(forces).all():
        return Verdict(False, np.full(n, np.inf), np.zeros(n), math.inf, math.inf, math.inf)
    with localcontext(DIGITS):
        sizes = _sizes(data.G)
        scale = scales(data)
        u = velocities(data, forces)
        error = np.array([_error(data, k, forces[k], u[k], sizes[k, k]) for k in range(n)])
    lengths = np.array([math.hypot(*f) for f in forces.tolist()])
    lost = 4.0 * EPS * (sizes @ lengths)
    least = np.where(data.held, 0.0, np.maximum(data.low, 0.0))
    known = (forces[:, :2] == 0.0).all(axis=1) & (forces[:, 2] == least) & (scale == 0.0)
    error[known] = 0.0
    worst = np.array([ratio(e, s) for e, s in zip(error, scale, strict=True)])
    share = worst / np.hypot(1.0, data.mu)
    pairs = zip(lost, scale, known | (data.high <= 0.0), strict=True)
    rounding = max((0.0 if free else float(ratio(x, s)) for x, s, free in pairs), default=0.0)
    return Verdict(True, error, scale, float(share.max(initial=0.0)), float(worst.max(initial=0.0)), rounding)


def ratio(x: float, y: float) -> float:
    """An error over its scale: without one any error is infinite."""
    return 0.0 if x == 0.0 else (x / y if y > 0.0 else math.inf)


def speeds_of_parts(data: Data, noise: float = 0.0) -> np.ndarray:
    """s of each contact's connected block: the fastest contact that is on, at the least admissible forces."""
    with localcontext(DIGITS):
        least = np.zeros((data.contacts, 3))
        least[:, 2] = np.where(data.held, 0.0, np.maximum(data.low, 0.0))
        speeds = np.array([float(norm(v)) for v in velocities(data, least)])
    speeds[(data.high <= 0.0) | (speeds <= velocity_rounding(data, least))] = 0.0
    number = connected(data, noise)
    return np.array([speeds[number == number[k]].max() for k in range(data.contacts)])


def scales(data: Data) -> np.ndarray:
    """s of each contact, as generous as it may be: parts that rounding alone joins lend little of theirs."""
    s = np.maximum(speeds_of_parts(data, NOISE), LENT * speeds_of_parts(data))
    return np.where(s > 0.0, np.maximum(s, VANISHING), s)


def _error(data: Data, k: int, force: np.ndarray, u: Vector, size: float) -> float:
    """eps_k [m/s]."""
    if data.held[k]:
        return float(norm(u))
    mu, low = Decimal(float(data.mu[k])), Decimal(max(float(data.low[k]), 0.0))
    high = None if data.high[k] == np.inf else Decimal(float(data.high[k]))
    corners = rays(mu, data.facets, data.inner) if data.facets else None
    shift = ZERO
    if not data.convex:
        shift = mu * norm(u[:2])
        if corners is not None:
            shift = max(-(c[0] * u[0] + c[1] * u[1]) for c in corners)
    f: Vector = tuple(Decimal(float(x)) for x in force)  # type: ignore[assignment]
    v = (u[0], u[1], u[2] + shift)
    w = Decimal(size)
    if w == 0:  # the one-sided derivative of the projection is the distance to the normal cone
        length, speed = max(norm(f), low), norm(v)
        length = length if length > 0 or high is None else high
        if speed == 0 or high == 0:
            outside = nearest(f, mu, low, high, corners)
            return 0.0 if _apart(f, outside) <= Decimal(NOWHERE) * length else math.inf
        w = speed / (Decimal(NOWHERE) * length) if length > 0 else ONE
    target = (f[0] - v[0] / w, f[1] - v[1] / w, f[2] - v[2] / w)
    return float(w * _apart(f, nearest(target, mu, low, high, corners)))


def _apart(a: Vector, b: Vector) -> Decimal:
    return norm((a[0] - b[0], a[1] - b[1], a[2] - b[2]))


@dataclass(frozen=True)
class Proof:
    """What is left of a claimed proof of infeasibility after a check in rational numbers.

    Attributes
    ----------
    reach
        |g.d| / max_k ||(G d)_k|| of the nearest direction that obeys the signs exactly; inf if G d = 0.
    needed
        1e6 s / least positive ||G_kk||, over the blocks that the direction touches.
    fault
        What is wrong, or None.
    """

    reach: float
    needed: float
    fault: str | None


def check_proof(data: Data, direction: np.ndarray, reach: float | None = None) -> Proof:
    """Check a direction: signs, g.d < 0, and how large forces must be for G d to matter."""
    d = np.array(direction, dtype=float)
    if d.shape != (data.contacts, 3) or not np.isfinite(d).all():
        return Proof(0.0, math.inf, "not a finite (n, 3) direction")
    lawful = [_recession(data, k, d[k]) for k in range(data.contacts)]
    rows = zip(lawful, d.tolist(), strict=True)
    off = max((abs(float(a) - b) for x, y in rows for a, b in zip(x, y, strict=True)), default=0.0)
    if off > 1e-12 * float(np.abs(d).max(initial=0.0)):
        return Proof(0.0, math.inf, f"breaks the signs by {off:.1e}")
    flat = [x for row in lawful for x in row]
    pushed = [j for j, x in enumerate(flat) if x != 0]
    power = sum((Fraction(float(data.g[j])) * flat[j] for j in pushed), Fraction(0))
    largest = Fraction(0)
    for i in range(0, data.g.size, 3):
        square = Fraction(0)
        for row in range(i, i + 3):
            joined = [j for j in pushed if data.G[row, j] != 0.0]
            v = sum((Fraction(float(data.G[row, j])) * flat[j] for j in joined), Fraction(0))
            square += v * v
        largest = max(largest, square)
    if power >= 0:
        return Proof(0.0, math.inf, f"g.d = {float(power):.1e} is not negative")
    true = math.inf if largest == 0 else _root(power * power / largest)
    number = connected(data, 2.0 * NOISE)
    touched = np.isin(number, number[np.any(d != 0.0, axis=1)])
    sizes = np.diagonal(_sizes(data.G))[touched]
    s = float(speeds_of_parts(data, 2.0 * NOISE)[touched].max(initial=0.0))
    positive = sizes[sizes > 0.0]
    needed = REACH * s / float(positive.min()) if positive.size else 0.0
    fault = None
    if true < 0.5 * needed:
        fault = f"reaches {true:.1e} N, {needed:.1e} N is needed"
    elif reach is not None and reach > 1.01 * true and reach > needed:
        fault = f"states a reach of {reach:.1e} N, it is {true:.1e} N"
    return Proof(true, needed, fault)


def _root(x: Fraction) -> float:
    """The square root of a rational number of any size."""
    with localcontext(DIGITS):
        root = (Decimal(x.numerator) / Decimal(x.denominator)).sqrt()
        return float(root) if root < Decimal("1e308") else math.inf


def _recession(data: Data, k: int, d: np.ndarray) -> tuple[Fraction, Fraction, Fraction]:
    """The direction nearest to d that contact k may take, as rational numbers."""
    nothing = Fraction(0)
    if data.held[k]:
        return Fraction(float(d[0])), Fraction(float(d[1])), Fraction(float(d[2]))
    if data.high[k] < np.inf:
        return nothing, nothing, nothing
    if not data.convex:
        return nothing, nothing, Fraction(max(float(d[2]), 0.0))
    with localcontext(DIGITS):
        mu = Decimal(float(data.mu[k]))
        corners = rays(mu, data.facets, data.inner) if data.facets else None
        p: Vector = tuple(Decimal(float(x)) for x in d)  # type: ignore[assignment]
        q = nearest(p, mu, ZERO, None, corners)
        shrink = ONE if q == p else ONE - Decimal("1e-60")
        return Fraction(q[0] * shrink), Fraction(q[1] * shrink), Fraction(q[2])
