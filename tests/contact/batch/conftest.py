"""Problems like a Go2's step: a floating body on four legs of three joints, feet at random speeds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.contact.solution import ContactSolution


class Problems(NamedTuple):
    G: FloatArray
    g: FloatArray
    mu: FloatArray


def go2_like(count: int, seed: int = 0, rigid: bool = False) -> Problems:
    """Return problems with four contacts; with `rigid` legs, G has rank 6."""
    rng = np.random.default_rng(seed)
    feet = np.array([[x, y, -0.3] for x in (0.19, -0.19) for y in (0.14, -0.14)])
    G, g, mu = np.empty((count, 12, 12)), np.empty((count, 12)), rng.uniform(0.1, 0.9, (count, 4))
    inverse = 1.0 / np.array([16.0, 16.0, 16.0, 0.1, 0.3, 0.3] + [0.05] * 12)
    for k in range(count):
        J = np.zeros((12, 18))
        for i, p in enumerate(feet + 0.03 * rng.normal(size=(4, 3))):
            rows = slice(3 * i, 3 * i + 3)
            J[rows, :3] = np.eye(3)
            J[rows, 3:6] = [[0, p[2], -p[1]], [-p[2], 0, p[0]], [p[1], -p[0], 0]]
            if not rigid:
                J[rows, 6 + 3 * i : 9 + 3 * i] = 0.2 * np.eye(3) + 0.05 * rng.normal(size=(3, 3))
        speed = 0.3 * rng.normal(size=18) * rng.choice([0.1, 1.0])
        speed[2] -= 0.2
        G[k], g[k] = J * inverse @ J.T, J @ speed
    return Problems(G, g, mu)


@pytest.fixture(scope="session")
def problems() -> Problems:
    """Forty problems with contacts that stick, slide and are open."""
    return go2_like(40)


@pytest.fixture(scope="session")
def redundant() -> Problems:
    """Ten problems of a rigid body on four feet."""
    return go2_like(10, 3, rigid=True)


@pytest.fixture(scope="session", params=["coulomb", pytest.param("convex", marks=pytest.mark.long)])
def solved(request: pytest.FixtureRequest, problems: Problems) -> tuple[str, list[ContactSolution]]:
    """The law, and the solutions of `problems` by `surefoot.solve`."""
    law = request.param
    found = [
        sf.solve(sf.ContactProblem(G, g, mu, law=law), tol=1e-12) for G, g, mu in zip(*problems, strict=True)
    ]
    assert all(s.solved for s in found)
    return law, found


@pytest.fixture(scope="session")
def hard() -> list[tuple[str, Problems]]:
    """Inputs that are no problems, or none that a force answers, with their names."""
    G, g, mu = (v[:1] for v in go2_like(1, 9))
    none = np.zeros_like(G)
    nan = g.copy()
    nan[0, 4] = np.nan
    bent = G.copy()
    bent[0, 2, 2] = np.inf
    return [
        ("nan in g", Problems(G, nan, mu)),
        ("infinite G", Problems(bent, g, mu)),
        ("negative mu", Problems(G, g, -mu)),
        ("G is zero", Problems(none, g, mu)),
        ("all is zero", Problems(none, 0.0 * g, 0.0 * mu)),
        ("at rest", Problems(G, 0.0 * g, mu)),
        ("no friction", Problems(G, g, 0.0 * mu)),
        ("huge", Problems(1e30 * G, 1e30 * g, mu)),
        ("tiny", Problems(1e-30 * G, 1e-30 * g, mu)),
        ("much friction", Problems(G, g, 1e6 * (mu + 1.0))),
    ]
