"""Families of feasible contact problems, and of problems whose answer nobody knows."""

from __future__ import annotations

from dataclasses import replace

import nasty
import numpy as np
import scipy.sparse as sp
from building import (
    FAMILIES,
    FEASIBLE,
    UNKNOWN,
    Case,
    any_matrix,
    beside,
    bodies_matrix,
    family,
    feasible_case,
    lawful_state,
    laws,
    plain_block,
    rescaled,
    symmetric,
    with_free_velocity,
)
from insoluble import squeezed_beside_lawful, squeezed_twins
from numpy.random import Generator


@family
def small(rng: Generator) -> Case:
    """One to eight contacts, every kind of matrix, bounds, pyramids, bilateral contacts."""
    n = int(rng.integers(1, 9))
    return feasible_case(rng, any_matrix(rng, n), laws(rng, n))


__all__ = ["FAMILIES", "nasty"]


@family
def medium(rng: Generator) -> Case:
    """Ten to forty contacts."""
    n = int(rng.integers(10, 41))
    return feasible_case(rng, any_matrix(rng, n), laws(rng, n))


@family
def redundant(rng: Generator) -> Case:
    """Many contacts of one to three bodies: rank 6 to 18, plain cones."""
    n = int(rng.integers(4, 31))
    return feasible_case(rng, bodies_matrix(rng, n, int(rng.integers(1, 4)))[2], laws(rng, n, plain=True))


@family
def unequal(rng: Generator) -> Case:
    """Masses a million times apart that push each other."""
    n = int(rng.integers(2, 16))
    G = bodies_matrix(rng, n, max(2, n // 2), 1e6)[2]
    return feasible_case(rng, G, laws(rng, n, plain=True))


@family
def unequal_loads(rng: Generator) -> Case:
    """As `unequal`, with forces as unequal as the masses: heavy contacts carry what they weigh."""
    n = int(rng.integers(2, 16))
    G = bodies_matrix(rng, n, max(2, n // 2), 1e6)[2]
    arguments = laws(rng, n, plain=True)
    forces, u = lawful_state(rng, arguments, n)
    forces /= np.array([np.linalg.norm(G[3 * k : 3 * k + 3, 3 * k : 3 * k + 3], 2) for k in range(n)])[
        :, None
    ]
    return Case({"G": G, "g": with_free_velocity(G, forces, u)} | arguments, FEASIBLE, forces)


@family
def scales(rng: Generator) -> Case:
    """G from 1e-12 to 1e12, g from 1e-9 to 1e9."""
    return rescaled(small(rng), 10.0 ** rng.integers(-12, 13), 10.0 ** rng.integers(-9, 10))


@family
def large_sparse(rng: Generator) -> Case:
    """Sixty to 150 contacts in chains of bodies, a sparse matrix."""
    n = int(rng.integers(60, 151))
    J, inverse, _ = bodies_matrix(rng, n, n // 3, 10.0 ** rng.uniform(0, 3))
    G = symmetric((J * inverse) @ J.T)
    found = feasible_case(rng, G, laws(rng, n, plain=True))
    return replace(found, arguments=found.arguments | {"G": sp.csr_matrix(G)})


@family
def compliant(rng: Generator) -> Case:
    """Soft contacts on one or two bodies."""
    n = int(rng.integers(2, 10))
    soft = 10.0 ** rng.uniform(-6, 1)
    arguments = laws(rng, n) | {"compliance": soft}
    return feasible_case(rng, bodies_matrix(rng, n, int(rng.integers(1, 3)))[2], arguments)


@family
def still(rng: Generator) -> Case:
    """g = 0: no force is needed."""
    n = int(rng.integers(1, 7))
    return Case(
        {"G": any_matrix(rng, n), "g": np.zeros(3 * n)} | laws(rng, n, plain=True), FEASIBLE, np.zeros((n, 3))
    )


@family
def locked(rng: Generator) -> Case:
    """Bilateral contacts of a singular matrix, and contacts that are off."""
    n = int(rng.integers(2, 9))
    held = rng.random(n) < 0.6
    high = np.where(held | (rng.random(n) < 0.6), np.inf, 0.0)
    arguments = laws(rng, n, plain=True) | {"bilateral": held, "normal_max": high}
    return feasible_case(rng, bodies_matrix(rng, n, 1)[2], arguments)


@family
def decoupled(rng: Generator) -> Case:
    """Two lawful blocks, one up to 1e9 times as fast or as heavy as the other."""
    one, two = plain_block(rng), plain_block(rng)
    return beside(rng, one, rescaled(two, 10.0 ** rng.integers(-9, 10), 10.0 ** rng.integers(-9, 10)))


@family
def rank_one(rng: Generator) -> Case:
    """G = outer(J, J) and any g: often none, sometimes a solution."""
    n = int(rng.integers(1, 9))
    J = rng.normal(size=3 * n) * 10.0 ** rng.uniform(-4, 4)
    g = rng.normal(size=3 * n) * 10.0 ** rng.uniform(-4, 4)
    return Case({"G": np.outer(J, J), "g": g} | laws(rng, n), UNKNOWN)


@family
def anything(rng: Generator) -> Case:
    """Any matrix with any g."""
    n = int(rng.integers(1, 13))
    return Case({"G": any_matrix(rng, n), "g": rng.normal(size=3 * n)} | laws(rng, n), UNKNOWN)


@family
def enormous(rng: Generator) -> Case:
    """Squeezed bodies with compliance from 1e-18 to 1e-3: feasible, with forces up to 1e18."""
    n = int(rng.integers(2, 7))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n), "law": "convex"}, n, 1.0)[1]
    return Case(bad.arguments | {"compliance": 10.0 ** rng.uniform(-18, -3)}, UNKNOWN)


@family
def weakly_coupled(rng: Generator) -> Case:
    """Two blocks joined by entries from 1e-300 to 1e-12 of theirs, one of them faster or squeezed."""
    found = squeezed_beside_lawful(rng) if rng.random() < 0.5 else decoupled(rng)
    G = np.array(found.arguments["G"])
    free = np.argwhere(G == 0.0)
    if len(free):
        i, j = free[int(rng.integers(len(free)))]
        size = np.sqrt(abs(G[i, i] * G[j, j])) * 10.0 ** -float(rng.choice([12, 20, 100, 290]))
        G[i, j] = G[j, i] = size
    return Case(found.arguments | {"G": G}, UNKNOWN)


@family
def extreme(rng: Generator) -> Case:
    """Numbers near the ends of double precision: nothing may become NaN."""
    n = int(rng.integers(1, 5))
    found = feasible_case(rng, any_matrix(rng, n), laws(rng, n, plain=True))
    a, b = 10.0 ** rng.integers(-280, 281), 10.0 ** rng.integers(-140, 141)
    return replace(rescaled(found, a, b), truth=UNKNOWN, forces=None)
