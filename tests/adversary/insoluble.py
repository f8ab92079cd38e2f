"""Families of contact problems without a solution: with a proof of it, and without one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from building import (
    FEASIBLE,
    INFEASIBLE,
    NO_SOLUTION,
    UNKNOWN,
    Case,
    beside,
    family,
    lawful_state,
    plain_block,
    rescaled,
    symmetric,
    with_free_velocity,
)
from numpy.random import Generator
from oracle import read


def squeezing(rng: Generator, contacts: int, law: str) -> tuple[np.ndarray, np.ndarray]:
    """G and a direction d with G d = 0 up to rounding: walls around a body whose pushes cancel.

    The last contact of J answers the first ones: its normal row is minus their weighted sum. For the convex
    law pushes lean, within mu = 0.3.
    """
    n = contacts
    size = int(rng.choice([3, 6, 12]))
    whole = rng.random() < 0.5  # small integers: G d is exactly zero
    J = rng.integers(-3, 4, (3 * n, size)).astype(float) if whole else rng.normal(size=(3 * n, size))
    inverse = 2.0 ** rng.integers(-3, 4, size) if whole else 10.0 ** rng.uniform(-1.5, 1.5, size)
    d = np.zeros((n, 3))
    on = rng.random(n) < 0.6
    on[-1] = on[0] = True
    d[on, 2] = rng.integers(1, 4, int(on.sum())) if whole else rng.uniform(0.3, 3.0, int(on.sum()))
    if law == "convex" and rng.random() < 0.7:
        lean = 0.25 * d[:, 2]
        d[:, 0] = lean * (rng.integers(-1, 2, n) if whole else rng.uniform(-0.8, 0.8, n))
    d[-1] = 0.0, 0.0, 1.0
    J[-1] = -(d[:-1].ravel() @ J[:-3])
    if np.abs(J[-1]).max() == 0.0:
        J[0, 0], d[0] = 1.0, (0.0, 0.0, 1.0)
        J[-1] = -(d[:-1].ravel() @ J[:-3])
    return symmetric((J * inverse) @ J.T), d


def squeezed_twins(rng: Generator, arguments: dict[str, Any], n: int, margin: float) -> tuple[Case, Case]:
    """A feasible problem and its infeasible twin, which differ by a little approach along d."""
    law = arguments.get("law", "coulomb")
    G, d = squeezing(rng, n, law)
    data = read({"G": G, "g": np.zeros(3 * n)} | arguments)
    forces, u = lawful_state(rng, arguments, n)
    forces /= max(float(np.abs(G).max()), 1e-300)
    on = d.any(axis=1)
    u[on & ~data.held] = 0.0  # whoever squeezes must not lift
    u[on & (data.high == 0.0)] = 0.0
    scale = float(np.linalg.norm(d))
    push = margin / scale**2 * d
    forces_g = with_free_velocity(G, forces, u)
    free = forces_g + push.ravel()
    twin = Case({"G": G, "g": free} | arguments, FEASIBLE if law == "coulomb" else UNKNOWN, None)
    if law == "coulomb":  # u_n grows where λ may be > 0: give those contacts no force
        lone = forces.copy()
        lone[on] = 0.0
        twin = replace(
            twin, arguments=twin.arguments | {"g": with_free_velocity(G, lone, u + push)}, forces=lone
        )
    return twin, Case({"G": G, "g": forces_g - push.ravel()} | arguments, INFEASIBLE, None, d)


def _one_law(rng: Generator, n: int) -> dict[str, Any]:
    """Friction of at least 0.3, a law, perhaps pyramids that are wide enough for `squeezing`'s lean."""
    found: dict[str, Any] = {"mu": rng.uniform(0.4, 1.0, n), "law": str(rng.choice(["coulomb", "convex"]))}
    if rng.random() < 0.3:
        found |= {"facets": int(rng.choice([6, 8])), "fit": str(rng.choice(["inner", "outer"]))}
    return found


@family
def squeezed(rng: Generator) -> Case:
    """Walls that close on a body: no solution, and a proof; margins from 1e-4 to 1."""
    n = int(rng.integers(2, 13))
    return squeezed_twins(rng, _one_law(rng, n), n, 10.0 ** rng.uniform(-4, 0))[1]


@family
def squeezed_twin(rng: Generator) -> Case:
    """The feasible twins of `squeezed`: the walls open by as little as the others close."""
    n = int(rng.integers(2, 13))
    return squeezed_twins(rng, _one_law(rng, n) | {"law": "coulomb"}, n, 10.0 ** rng.uniform(-4, 0))[0]


@family
def squeezed_scales(rng: Generator) -> Case:
    """`squeezed`, G from 1e-12 to 1e12, g from 1e-9 to 1e9."""
    return rescaled(squeezed(rng), 10.0 ** rng.integers(-12, 13), 10.0 ** rng.integers(-9, 10))


@family
def squeezed_many(rng: Generator) -> Case:
    """`squeezed` with 15 to 40 contacts of which some are held or bounded away from the proof."""
    n = int(rng.integers(15, 41))
    return squeezed_twins(rng, _one_law(rng, n), n, 10.0 ** rng.uniform(-3, 0))[1]


@family
def squeezed_beside_lawful(rng: Generator) -> Case:
    """A lawful block with an unrelated squeezed one beside it, up to 1e6 times as fast or as heavy."""
    n = int(rng.integers(2, 6))
    law = str(rng.choice(["coulomb", "convex"]))
    bad = squeezed_twins(rng, {"mu": rng.uniform(0.4, 1.0, n), "law": law}, n, 10.0 ** rng.uniform(-3, 0))[1]
    good = plain_block(rng, law)
    return beside(rng, good, rescaled(bad, 10.0 ** rng.integers(-6, 7), 10.0 ** rng.integers(-6, 7)))


@family
def no_normal_row(rng: Generator) -> Case:
    """A contact whose normal nothing moves, approached: diag(1, 1, 0), g_n = -0.05 and the like."""
    n = int(rng.integers(1, 5))
    J = rng.normal(size=(3 * n, 6))
    k = int(rng.integers(n))
    J[3 * k + 2] = 0.0
    arguments = {"mu": rng.uniform(0.0, 1.0, n), "law": str(rng.choice(["coulomb", "convex"]))}
    forces, u = lawful_state(rng, arguments, n)
    forces[k], u[k] = 0.0, (rng.normal(), rng.normal(), 0.0)
    G = symmetric(J @ J.T)
    g = with_free_velocity(G, forces, u)
    g[3 * k + 2] = -(10.0 ** rng.uniform(-4, 0))
    d = np.zeros((n, 3))
    d[k, 2] = 1.0
    return Case({"G": G, "g": g} | arguments, INFEASIBLE, None, d)


@family
def held_apart(rng: Generator) -> Case:
    """Bilateral contacts that contradict each other: d is free in all their rows."""
    n = int(rng.integers(2, 6))
    J = rng.normal(size=(3 * n, 6))
    held = rng.random(n) < 0.5
    held[:2] = True
    d = np.zeros((n, 3))
    d[held] = rng.normal(size=(int(held.sum()), 3))
    d[0] = 0.0, 1.0, 0.0
    rest = d.ravel().copy()
    rest[1] = 0.0
    J[1] = -(rest @ J)
    G = symmetric(J @ J.T)
    arguments = {"mu": rng.uniform(0.1, 1.0, n), "bilateral": held}
    forces, u = lawful_state(rng, arguments, n)
    g = with_free_velocity(G, forces, u) - 10.0 ** rng.uniform(-3, 0) * d.ravel() / float(np.sum(d * d))
    return Case({"G": G, "g": g} | arguments, INFEASIBLE, None, d)


@family
def jamming(rng: Generator) -> Case:
    """A point mass that must leave a closing wedge through its own friction: Coulomb has no solution.

    Walls at angle a to the vertical, mu > tan a, both closing at speed c; the mass comes down or rests.
    Neither wall may be entered, so it must rise, sliding up on both; then all they can give points down.
    d = 0 is the only lawful direction: without friction it would be squeezed out.
    """
    a = np.deg2rad(rng.uniform(3.0, 20.0))
    mu = np.tan(a) * rng.uniform(1.5, 4.0)
    mass, close, fall = 10.0 ** rng.uniform(-2, 2), 10.0 ** rng.uniform(-2, 0), rng.choice([0.0, 1.0])
    c, s = np.cos(a), np.sin(a)
    J = np.array([[-s, 0, c], [0, 1, 0], [c, 0, s], [s, 0, c], [0, 1, 0], [-c, 0, s]])
    g = J @ np.array([0.0, 0.0, -fall])
    g[[2, 5]] -= close
    found = Case({"G": symmetric(J @ J.T / mass), "g": g, "mu": mu}, NO_SOLUTION)
    return beside(rng, plain_block(rng), found) if rng.random() < 0.3 else found


@family
def weak(rng: Generator) -> Case:
    """A convex problem whose infimum is not attained: null space touches the cone along one ray only."""
    mu = rng.uniform(0.3, 2.0)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    along = np.array([np.cos(angle), np.sin(angle), 0.0])
    across = np.array([-np.sin(angle), np.cos(angle), 0.0])
    G = symmetric(np.outer(across, across)) * 10.0 ** rng.uniform(-2, 2)
    g = -along + mu * np.array([0.0, 0.0, 1.0]) + rng.uniform(0.1, 3.0) * across
    found = Case({"G": G, "g": g, "mu": mu, "law": "convex"}, NO_SOLUTION)
    return beside(rng, plain_block(rng, "convex"), found) if rng.random() < 0.3 else found
