"""What families of contact problems are built from: matrices, lawful states, problems joined to one.

A feasible problem is built backwards: every contact is given a way to be lawful (open, sticking, sliding, at
a bound, held), which gives λ and u, and then g = u - G λ. A problem without a solution is built with its
proof, a lawful direction d with G d = 0 and g.d < 0, or with the argument why it has none.

A family is a function of a random generator that returns a `Case`; `case(name, seed)` builds one.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.random import Generator
from oracle import read, velocities

FEASIBLE, INFEASIBLE, NO_SOLUTION, UNKNOWN = "feasible", "infeasible", "no solution", "unknown"
"""Truths: with a solution, without one and with a proof, without one and without a proof, not known."""


@dataclass(frozen=True)
class Case:
    """A problem with its answer.

    Attributes
    ----------
    arguments
        Keyword arguments of `ContactProblem`.
    truth
        FEASIBLE, INFEASIBLE, NO_SOLUTION or UNKNOWN.
    forces
        (n, 3) of a solution, where one is known.
    direction
        (n, 3) of a proof of infeasibility, where there is one.
    """

    arguments: dict[str, Any]
    truth: str
    forces: np.ndarray | None = None
    direction: np.ndarray | None = None


Family = Callable[[Generator], Case]
FAMILIES: dict[str, Family] = {}


def family(function: Family) -> Family:
    """Put a family into the table under its function's name."""
    FAMILIES[function.__name__] = function
    return function


def case(name: str, seed: int) -> Case:
    """One problem of a family."""
    return FAMILIES[name](np.random.default_rng([zlib.crc32(name.encode()), seed]))


# ------------------------------------------------------------------------------------------------- matrices


def unit(rng: Generator, size: int = 3) -> np.ndarray:
    """A random direction."""
    v = rng.normal(size=size)
    return v / np.linalg.norm(v)


def frame(normal: np.ndarray) -> np.ndarray:
    """Rows tangent, tangent, normal."""
    side = np.eye(3)[int(np.argmin(np.abs(normal)))]
    first = np.cross(normal, side)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])


def cross_matrix(p: np.ndarray) -> np.ndarray:
    """[p]× with [p]× v = p × v."""
    return np.array([[0.0, -p[2], p[1]], [p[2], 0.0, -p[0]], [-p[1], p[0], 0.0]])


def symmetric(G: np.ndarray) -> np.ndarray:
    """The symmetric part."""
    return 0.5 * (G + G.T)


def bodies_matrix(
    rng: Generator, contacts: int, bodies: int, ratio: float = 1.0, turning: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """J (3n, 6b), M⁻¹ (its diagonal), and J M⁻¹ Jᵀ of free bodies that touch each other or the ground.

    Masses spread over `ratio`; normals point from the second body (or the ground) to the first.
    """
    size = 6 if turning else 3
    mass = ratio ** rng.uniform(-0.5, 0.5, bodies)
    inverse = np.concatenate(
        [np.concatenate([np.full(3, 1 / m), 1 / (m * rng.uniform(0.01, 0.1, 3))])[:size] for m in mass]
    )
    J = np.zeros((3 * contacts, size * bodies))
    for k in range(contacts):
        first = k % bodies
        second = -1 if bodies == 1 or rng.random() < 0.4 else int(rng.integers(bodies))
        axes = frame(unit(rng))
        for body, sign in ((first, 1.0), (second, -1.0)):
            if body < 0 or (body == first and sign < 0.0):
                continue
            arm = rng.uniform(-0.5, 0.5, 3)
            J[3 * k : 3 * k + 3, size * body : size * body + 3] += sign * axes
            if turning:
                J[3 * k : 3 * k + 3, size * body + 3 : size * body + 6] -= sign * axes @ cross_matrix(arm)
    return J, inverse, symmetric((J * inverse) @ J.T)


def any_matrix(rng: Generator, contacts: int) -> np.ndarray:
    """G of full rank, of few bodies, of very unequal bodies, or with blocks that are zero."""
    kind = rng.integers(5)
    if kind == 0:
        J = rng.normal(size=(3 * contacts, 3 * contacts + 3))
        return symmetric(J @ J.T)
    if kind == 1:
        J = rng.normal(size=(3 * contacts, max(1, int(rng.integers(1, 2 * contacts + 1)))))
        return symmetric(J @ J.T)
    ratio = 10.0 ** rng.uniform(0, 6) if kind == 3 else 10.0
    G = bodies_matrix(rng, contacts, int(rng.integers(1, max(2, contacts // 2 + 1))), ratio)[2]
    if kind == 4:  # a contact that nothing moves
        rows = slice(3 * int(rng.integers(contacts)), None)
        rows = slice(rows.start, rows.start + 3)
        G[rows], G[:, rows] = 0.0, 0.0
    return G


# --------------------------------------------------------------------------------------------- lawful states


def laws(rng: Generator, contacts: int, plain: bool = False) -> dict[str, Any]:
    """Friction, bounds, cones and law; `plain` leaves bounds and pyramids out."""
    kinds = [0.0, 1e-6, 0.2, 0.5, 1.0, 5.0]
    found: dict[str, Any] = {"mu": rng.choice(kinds, contacts, p=[0.1, 0.05, 0.2, 0.4, 0.2, 0.05])}
    if rng.random() < 0.35:
        found["law"] = "convex"
    if plain:
        return found
    if rng.random() < 0.35:
        found["facets"] = int(rng.choice([3, 4, 6, 8]))
        found["fit"] = str(rng.choice(["inner", "outer"]))
    if rng.random() < 0.3:
        some = rng.random(contacts) < 0.5
        found["normal_min"] = np.where(
            some & (rng.random(contacts) < 0.5), rng.uniform(0.1, 1.0, contacts), 0.0
        )
        high = np.where(rng.random(contacts) < 0.2, 0.0, rng.uniform(1.0, 3.0, contacts))
        found["normal_max"] = np.where(some, np.maximum(high, found["normal_min"]), np.inf)
    if rng.random() < 0.2:
        held = rng.random(contacts) < 0.3
        found["bilateral"] = held
        if "normal_min" in found:
            found["normal_min"] = np.where(held, 0.0, found["normal_min"])
            found["normal_max"] = np.where(held, np.inf, found["normal_max"])
    return found


def corners(mu: float, facets: int, inner: bool) -> np.ndarray:
    """(facets, 2) corners of a pyramid's section at height 1."""
    angles = (0.0 if inner else np.pi / facets) + 2.0 * np.pi * np.arange(facets) / facets
    size = mu if inner else mu / np.cos(np.pi / facets)
    return size * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def lawful_state(rng: Generator, arguments: dict[str, Any], contacts: int) -> tuple[np.ndarray, np.ndarray]:
    """Random λ and u (n, 3) of size about 1 that obey the laws, contact by contact."""
    n = contacts
    empty = {"G": np.zeros((3 * n, 3 * n)), "g": np.zeros(3 * n)} | arguments
    data = read(empty)
    λ, u = np.zeros((n, 3)), np.zeros((n, 3))
    for k in range(n):
        if data.held[k]:
            λ[k] = rng.normal(size=3)
            continue
        low, high = max(float(data.low[k]), 0.0), float(data.high[k])
        if high == 0.0:
            u[k] = rng.normal(size=3)
            continue
        section = None
        if data.facets:
            section = corners(float(data.mu[k]), data.facets, data.inner)
        λ[k], u[k] = _lawful(rng, float(data.mu[k]), low, high, section, data.convex)
    return λ, u


def _lawful(
    rng: Generator, mu: float, low: float, high: float, section: np.ndarray | None, convex: bool
) -> tuple[np.ndarray, np.ndarray]:
    """λ and u of one contact."""
    normal = rng.uniform(low, min(high, low + 2.0))
    way = rng.choice(
        ["open", "stick", "slide", "edge", "grazing", "high"], p=[0.25, 0.25, 0.25, 0.1, 0.05, 0.1]
    )
    v = unit(rng, 2) * rng.uniform(0.1, 1.0)
    if section is None:
        against, most = -mu * v / np.linalg.norm(v), mu * float(np.linalg.norm(v))
        inside = mu * np.sqrt(rng.random()) * unit(rng, 2)
    else:
        best = int(np.argmax(-section @ v))
        if rng.random() < 0.3:  # across a face: its whole edge dissipates alike
            other = section[(best + 1) % len(section)]
            across = section[best] + other
            if np.linalg.norm(across) > 0.0:
                v = -across / np.linalg.norm(across) * rng.uniform(0.1, 1.0)
            against = section[best] + rng.random() * (other - section[best])
        else:
            against = section[best]
        most = float(np.max(-section @ v))
        inside = rng.dirichlet(np.ones(len(section))) @ section
    lift = most if convex else 0.0
    if way == "open":
        n = np.array([*(against * low), low]) if low > 0.0 else np.zeros(3)
        return n, np.array([*v, lift + rng.uniform(0.0, 1.0)])
    if way == "stick":
        return np.array([*(normal * 0.95 * inside), normal]), np.zeros(3)
    if way == "slide":
        return np.array([*(normal * against), normal]), np.array([*v, lift])
    if way == "edge":
        return np.array([*(normal * against), normal]), np.zeros(3)
    if way == "high" and high < np.inf:
        return np.array([*(high * against), high]), np.array([*v, lift - rng.uniform(0.0, 1.0)])
    return np.array([0.0, 0.0, low]), np.zeros(3)


def with_free_velocity(G: np.ndarray, forces: np.ndarray, u: np.ndarray) -> np.ndarray:
    """g = u - G λ, rounded once."""
    n = len(forces)
    data = read({"G": G, "g": np.zeros(3 * n), "mu": 0.0})
    pushed = velocities(data, -forces)
    exact = [
        [float(p + type(p)(float(x))) for p, x in zip(a, b, strict=True)]
        for a, b in zip(pushed, u, strict=True)
    ]
    return np.array(exact).ravel()


def feasible_case(rng: Generator, G: np.ndarray, arguments: dict[str, Any]) -> Case:
    """A problem with a solution, for a matrix and laws."""
    n = G.shape[0] // 3
    forces, u = lawful_state(rng, arguments, n)
    size = float(np.abs(G).max(initial=0.0))
    total = G
    if "compliance" in arguments:
        total = G + np.diag(np.broadcast_to(arguments["compliance"], 3 * n))
    forces_scaled = {k: arguments[k] for k in ("normal_min", "normal_max") if k in arguments}
    if size > 0.0 and not forces_scaled:
        forces = forces / size
    return Case({"G": G, "g": with_free_velocity(total, forces, u)} | arguments, FEASIBLE, forces)


def rescaled(found: Case, a: float, b: float) -> Case:
    """The same problem with G times a and g times b: forces and bounds times b / a."""
    arguments = dict(found.arguments)
    arguments["G"] = arguments["G"] * a
    arguments["g"] = np.asarray(arguments["g"]) * b
    for name in ("normal_min", "normal_max"):
        if name in arguments:
            arguments[name] = np.asarray(arguments[name]) * (b / a)
    if "compliance" in arguments:
        arguments["compliance"] = np.asarray(arguments["compliance"]) * a
    return replace(
        found, arguments=arguments, forces=None if found.forces is None else found.forces * (b / a)
    )


def beside(rng: Generator, one: Case, two: Case) -> Case:
    """Two problems that know nothing of each other, as one, their contacts shuffled."""
    a, b = one.arguments, two.arguments
    G = sp.block_diag([a["G"], b["G"]]).toarray()
    n, m = len(a["g"]) // 3, len(b["g"]) // 3
    order = rng.permutation(n + m)
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    arguments: dict[str, Any] = {"G": G[np.ix_(rows, rows)], "g": np.concatenate([a["g"], b["g"]])[rows]}
    defaults = {"mu": 0.0, "normal_min": 0.0, "normal_max": np.inf, "bilateral": False}
    for name, default in defaults.items():
        if name in a or name in b:
            both = [np.broadcast_to(x.get(name, default), s) for x, s in ((a, n), (b, m))]
            arguments[name] = np.concatenate(both)[order]
    for name in ("law", "facets", "fit"):
        if name in a:
            arguments[name] = a[name]
    bad = [c for c in (one, two) if c.truth in (INFEASIBLE, NO_SOLUTION)]
    truth = FEASIBLE if one.truth == two.truth == FEASIBLE else UNKNOWN
    if bad:
        truth = INFEASIBLE if any(c.truth == INFEASIBLE for c in bad) else NO_SOLUTION

    def joined(x: np.ndarray | None, y: np.ndarray | None) -> np.ndarray:
        x = np.zeros((n, 3)) if x is None else x
        y = np.zeros((m, 3)) if y is None else y
        return np.concatenate([x, y])[order]

    forces = joined(one.forces, two.forces) if truth == FEASIBLE else None
    direction = joined(one.direction, two.direction) if truth == INFEASIBLE else None
    return Case(arguments, truth, forces, direction)


def plain_block(rng: Generator, law: str = "coulomb") -> Case:
    """A small lawful block with one law."""
    n = int(rng.integers(1, 5))
    G = bodies_matrix(rng, n, int(rng.integers(1, 3)))[2]
    return feasible_case(rng, G, {"mu": rng.uniform(0.0, 1.0, n), "law": law})
