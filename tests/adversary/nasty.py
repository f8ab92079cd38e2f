"""Families made against the definition itself: its scales, its thresholds, its special cases."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from building import (
    FEASIBLE,
    INFEASIBLE,
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
from insoluble import squeezed_twins, squeezing, weak
from numpy.random import Generator
from oracle import read, velocities_of


@family
def gripped(rng: Generator) -> Case:
    """Preloads (normal_min) that hold each other: at the least forces there is hardly a velocity, or none."""
    n = int(rng.integers(2, 8))
    G = bodies_matrix(rng, n, int(rng.integers(1, 3)))[2]
    low = rng.uniform(0.5, 2.0, n) * 10.0 ** rng.uniform(-2, 4)
    least = np.zeros((n, 3))
    least[:, 2] = low
    arguments = {"mu": rng.uniform(0.1, 1.0, n), "normal_min": low}
    u = np.zeros((n, 3))
    u[:, 2] = rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-12, 0) * rng.random(n)
    return Case({"G": G, "g": with_free_velocity(G, least, u)} | arguments, FEASIBLE, least)


@family
def nearly_squeezed(rng: Generator) -> Case:
    """Walls that close on a body that gives way by 1e-12 to 1e-2: feasible, with forces as large."""
    n = int(rng.integers(2, 7))
    G, d = squeezing(rng, n, "coulomb")
    G = G / np.abs(G).max()
    G[np.diag_indices(3 * n)] += 10.0 ** rng.uniform(-12, -2)
    arguments = {"mu": rng.uniform(0.1, 1.0, n), "law": str(rng.choice(["coulomb", "convex"]))}
    forces, u = lawful_state(rng, arguments, n)
    forces += 10.0 ** rng.uniform(0, 10) * d
    u[d.any(axis=1)] = 0.0
    return Case({"G": G, "g": with_free_velocity(G, forces, u)} | arguments, FEASIBLE, forces)


@family
def spread(rng: Generator) -> Case:
    """Every contact in units of its own, from 1e-5 to 1e5: the weights w_k differ by up to 1e20."""
    n = int(rng.integers(2, 10))
    found = feasible_case(rng, any_matrix(rng, n), laws(rng, n, plain=True))
    assert found.forces is not None
    unit = 10.0 ** rng.uniform(-5, 5, n)
    D = np.repeat(unit, 3)
    G = symmetric(D[:, None] * found.arguments["G"] * D)
    u = np.array(velocities_of(read(found.arguments), found.forces)) * unit[:, None]
    forces = found.forces / unit[:, None]
    return Case(found.arguments | {"G": G, "g": with_free_velocity(G, forces, u)}, FEASIBLE, forces)


@family
def bridged(rng: Generator) -> Case:
    """A slow and a fast part whose only link is a contact that is off."""
    one, two = plain_block(rng), rescaled(plain_block(rng), 1.0, 10.0 ** rng.integers(2, 10))
    found = beside(rng, one, two)
    G, g = found.arguments["G"], found.arguments["g"]
    n = len(g) // 3
    row = rng.normal(size=(3, 3 * n)) * np.sqrt(np.diagonal(G)) * 0.3
    links = np.block([[G, row.T], [row, np.eye(3) * (1.0 + np.trace(G))]])
    arguments = found.arguments | {
        "G": symmetric(links),
        "g": np.concatenate([g, rng.normal(size=3)]),
        "mu": np.append(found.arguments["mu"], 0.5),
        "normal_max": np.append(np.full(n, np.inf), 0.0),
    }
    forces = None if found.forces is None else np.vstack([found.forces, np.zeros(3)])
    return Case(arguments, found.truth, forces)


@family
def noise_between(rng: Generator) -> Case:
    """Two parts joined by the rounding of J M⁻¹ Jᵀ alone, one of them much faster."""
    one, two = plain_block(rng), rescaled(plain_block(rng), 1.0, 10.0 ** rng.integers(0, 7))
    found = beside(rng, one, two)
    assert found.forces is not None
    G = found.arguments["G"].copy()
    size = np.sqrt(np.outer(np.diagonal(G), np.diagonal(G)))
    G = symmetric(np.where(G == 0.0, size * 1e-16 * rng.normal(size=G.shape), G))
    u = np.array(velocities_of(read(found.arguments), found.forces))
    return Case(
        found.arguments | {"G": G, "g": with_free_velocity(G, found.forces, u)}, FEASIBLE, found.forces
    )


@family
def steep_or_smooth(rng: Generator) -> Case:
    """Friction from 1e-300 to 1e8, side by side."""
    n = int(rng.integers(1, 7))
    mu = 10.0 ** rng.choice([-300, -150, -16, -8, -4, 0, 2, 4, 8], n)
    arguments: dict[str, Any] = {"mu": mu, "law": str(rng.choice(["coulomb", "convex"]))}
    if rng.random() < 0.3:
        arguments |= {"facets": int(rng.choice([3, 4, 8])), "fit": str(rng.choice(["inner", "outer"]))}
    return feasible_case(rng, bodies_matrix(rng, n, int(rng.integers(1, 3)))[2], arguments)


@family
def narrow(rng: Generator) -> Case:
    """Bounds that leave one normal force, or next to none."""
    n = int(rng.integers(1, 7))
    low = np.where(rng.random(n) < 0.5, rng.uniform(0.0, 1.0, n), 0.0)
    high = low + rng.choice([0.0, 1e-300, 1e-12, 1e-6], n)
    high[rng.random(n) < 0.3] = np.inf
    return feasible_case(
        rng, any_matrix(rng, n), laws(rng, n, plain=True) | {"normal_min": low, "normal_max": high}
    )


@family
def repeated(rng: Generator) -> Case:
    """The same contact many times over, bit by bit."""
    n, copies = int(rng.integers(1, 4)), int(rng.integers(2, 9))
    G = bodies_matrix(rng, n, n)[2]
    arguments = laws(rng, n, plain=True)
    forces, u = lawful_state(rng, arguments, n)
    g = with_free_velocity(G, forces * copies, u)
    arguments = arguments | {"mu": np.tile(arguments["mu"], copies), "G": np.tile(G, (copies, copies))}
    return Case(arguments | {"g": np.tile(g, copies)}, FEASIBLE, np.tile(forces, (copies, 1)))


@family
def full_rank(rng: Generator) -> Case:
    """Any g on a positive definite G, condition numbers up to 1e10: solutions exist (Klarbring, Pang)."""
    n = int(rng.integers(1, 11))
    Q = np.linalg.qr(rng.normal(size=(3 * n, 3 * n)))[0]
    G = symmetric((Q * 10.0 ** rng.uniform(-rng.uniform(0, 10), 0, 3 * n)) @ Q.T)
    mu = rng.uniform(0.0, 2.0, n)
    law = str(rng.choice(["coulomb", "convex"]))
    return Case({"G": G, "g": rng.normal(size=3 * n), "mu": mu, "law": law}, FEASIBLE)


@family
def written_otherwise(rng: Generator) -> Case:
    """The same matrices as lists, in Fortran's order, float32, whole numbers, sparse with stored zeros."""
    n = int(rng.integers(1, 7))
    G = bodies_matrix(rng, n, int(rng.integers(1, 3)))[2]
    kind = int(rng.integers(5))
    if kind == 0:
        G = np.round(4.0 * G)
        G = symmetric(G @ G)
    if kind == 1:
        G = G.astype(np.float32).astype(float)
    found = feasible_case(rng, G, laws(rng, n))
    if kind == 4:  # entries in two halves, and zeros that are stored
        i, j = np.indices(G.shape).reshape(2, -1)
        form: Any = sp.coo_matrix(
            (np.tile(0.5 * G.ravel(), 2), (np.tile(i, 2), np.tile(j, 2))), shape=G.shape
        )
    else:
        form = [G.astype(np.int64), G.astype(np.float32), np.asfortranarray(G), G.tolist()][kind]
    return replace(found, arguments=found.arguments | {"G": form})


@family
def asymmetric(rng: Generator) -> Case:
    """G asymmetric within what is taken for rounding: its symmetric part counts."""
    n = int(rng.integers(1, 7))
    found = feasible_case(rng, any_matrix(rng, n), laws(rng, n))
    G = found.arguments["G"]
    E = np.triu(rng.normal(size=G.shape), 1) * 1e-9 * np.abs(G).max()
    return replace(found, arguments=found.arguments | {"G": G + E - E.T}, truth=UNKNOWN, forces=None)


@family
def thin_margin(rng: Generator) -> Case:
    """Walls that close by 1e-14 to 1e-6 of the speeds around: hardly infeasible."""
    n = int(rng.integers(2, 9))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n)}, n, 10.0 ** rng.uniform(-14, -6))[1]
    return replace(bad, truth=UNKNOWN, direction=None)


@family
def squeezed_sparse(rng: Generator) -> Case:
    """A squeezed part among 60 to 150 contacts, a sparse matrix."""
    n = int(rng.integers(60, 151))
    J, inverse, _ = bodies_matrix(rng, n, n // 3)
    G = symmetric((J * inverse) @ J.T)
    found = feasible_case(rng, G, {"mu": rng.uniform(0.1, 1.0, n)})
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, 4)}, 4, 10.0 ** rng.uniform(-3, 0))[1]
    both = beside(rng, found, bad)
    return replace(both, arguments=both.arguments | {"G": sp.csr_matrix(both.arguments["G"])})


@family
def squeezed_by_heavy(rng: Generator) -> Case:
    """A squeezed light body beside one whose contact hardly moves: the least ||G_kk|| is another's."""
    n = int(rng.integers(2, 5))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n)}, n, 0.3)[1]
    return beside(rng, rescaled(plain_block(rng), 10.0 ** -rng.integers(6, 14), 1.0), bad)


@family
def squeezed_inside(rng: Generator) -> Case:
    """A squeezed body that leans on a lawful heap: one connected part."""
    n = int(rng.integers(3, 9))
    G, d = squeezing(rng, n, "coulomb")
    J = rng.normal(size=(3 * n, 6))
    J[d.ravel() != 0.0] = 0.0  # what moves them otherwise leaves d's rows alone
    arguments = {"mu": rng.uniform(0.1, 1.0, n)}
    forces, u = lawful_state(rng, arguments, n)
    u[d.any(axis=1)] = 0.0
    total = symmetric(G + J @ J.T * 10.0 ** rng.uniform(-3, 3))
    g = with_free_velocity(total, forces / np.abs(total).max(), u) - 0.1 * d.ravel() / np.sum(d * d)
    return Case({"G": total, "g": g} | arguments, INFEASIBLE, None, d)


@family
def weak_beside_heavy(rng: Generator) -> Case:
    """`weak` beside a lawful block whose energy s² / w is up to 1e24 times as large."""
    good = rescaled(plain_block(rng, "convex"), 10.0 ** -rng.integers(0, 13), 10.0 ** rng.integers(0, 7))
    return beside(rng, good, weak(rng))


@family
def squeezed_extreme(rng: Generator) -> Case:
    """Squeezed bodies where squares overflow or vanish: G by 1e±290, g by 1e±140."""
    n = int(rng.integers(2, 5))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n)}, n, 0.3)[1]
    return rescaled(
        bad, 10.0 ** (rng.choice([-1, 1]) * rng.integers(120, 291)), 10.0 ** rng.integers(-140, 141)
    )


@family
def nearly_squeezed_extreme(rng: Generator) -> Case:
    """`nearly_squeezed` where squares overflow or vanish."""
    found = nearly_squeezed(rng)
    a = 10.0 ** (rng.choice([-1, 1]) * rng.integers(120, 200))
    return rescaled(found, a, 10.0 ** rng.integers(-60, 61))


@family
def denormal(rng: Generator) -> Case:
    """A lawful block beside one whose speeds are denormal numbers: 1 / s is no number."""
    small = replace(rescaled(plain_block(rng), 1.0, 10.0 ** -float(rng.integers(306, 320))), truth=UNKNOWN)
    return beside(rng, plain_block(rng), small)


@family
def indefinite(rng: Generator) -> Case:
    """Symmetric matrices that no mass makes, though no pair of rows and no contact's block shows it."""
    n = int(rng.integers(2, 6))
    G = np.full((3 * n, 3 * n), -rng.uniform(0.25, 0.45))
    G[np.diag_indices(3 * n)] = 1.0
    size = 10.0 ** rng.uniform(-1, 1, 3 * n)
    return Case({"G": size[:, None] * G * size, "g": rng.normal(size=3 * n)} | laws(rng, n), UNKNOWN)


@family
def squeezed_bounded(rng: Generator) -> Case:
    """Walls that close with all the force they have: the bound is reached, or the answer is not known."""
    n = int(rng.integers(2, 7))
    law = str(rng.choice(["coulomb", "convex"]))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n), "law": law}, n, 0.3)[1]
    high = np.where(rng.random(n) < 0.7, 10.0 ** rng.uniform(-2, 16, n), np.inf)
    return replace(bad, arguments=bad.arguments | {"normal_max": high}, truth=UNKNOWN, direction=None)


@family
def all_bounded(rng: Generator) -> Case:
    """Any problem whose normal forces are all bounded: forces are a compact set, so a solution exists.

    (P. Hartman, G. Stampacchia, "On some non-linear elliptic differential-functional equations", 1966.)
    """
    n = int(rng.integers(2, 9))
    law = str(rng.choice(["coulomb", "convex"]))
    arguments = {"mu": rng.uniform(0.0, 1.0, n), "law": law}
    if rng.random() < 0.5:
        found = squeezed_twins(rng, arguments | {"mu": rng.uniform(0.4, 1.0, n)}, n, 0.3)[1].arguments
    else:
        found = {"G": any_matrix(rng, n), "g": rng.normal(size=3 * n)} | arguments
    unit = float(np.abs(found["g"]).max()) / float(np.abs(found["G"]).max())
    return Case(found | {"normal_max": unit * 10.0 ** rng.uniform(-2, 3, n)}, FEASIBLE)
