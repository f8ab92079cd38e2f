"""The judge is judged: projections by SciPy, verdicts and proofs on problems that can be done by hand."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np
import pytest
from admissible import nearest, rays
from building import FEASIBLE, INFEASIBLE, case, corners
from families import FAMILIES
from oracle import DIGITS, check_proof, judge, read
from scipy.optimize import minimize

DELICATE = ("gripped", "narrow", "nearly_squeezed", "steep_or_smooth", "spread")
"""Families with solutions that double precision may not be able to show."""
BOUNDS = [(0.0, None), (0.3, None), (0.0, 0.8), (0.3, 0.8), (0.5, 0.5)]


@pytest.mark.parametrize("facets", [0, 3, 4, 8])
@pytest.mark.parametrize("fit", ["inner", "outer"])
def test_the_nearest_force_is_scipys(facets: int, fit: str) -> None:
    rng = np.random.default_rng(facets)
    for low, high in BOUNDS:
        p, mu = rng.normal(size=3), float(rng.uniform(0.2, 1.5))
        with localcontext(DIGITS):
            section = rays(Decimal(mu), facets, fit == "inner") if facets else None
            top = None if high is None else Decimal(high)
            ours = nearest(tuple(map(Decimal, p.tolist())), Decimal(mu), Decimal(low), top, section)  # type: ignore[arg-type]
        found = np.array([float(x) for x in ours])
        rules = [{"type": "ineq", "fun": lambda x, low=low: x[2] - low}]
        if high is not None:
            rules.append({"type": "ineq", "fun": lambda x, high=high: high - x[2]})
        if facets:
            c = corners(mu, facets, fit == "inner")
            walls = np.array(
                [np.cross([*a, 1.0], [*b, 1.0]) for a, b in zip(c, np.roll(c, -1, 0), strict=True)]
            )
            rules.append({"type": "ineq", "fun": lambda x, walls=walls: walls @ x})
        else:
            rules.append(
                {"type": "ineq", "fun": lambda x, mu=mu: mu * x[2] - np.sqrt(x[0] ** 2 + x[1] ** 2 + 1e-18)}
            )
        start = [1e-3, 0.0, max(low, 0.4)]
        options = {"ftol": 1e-14, "maxiter": 500}
        best = minimize(
            lambda x, p=p: np.sum((x - p) ** 2), start, constraints=rules, method="SLSQP", options=options
        )
        assert np.linalg.norm(found - p) <= np.linalg.norm(best.x - p) + 1e-7
        assert all(np.min(rule["fun"](found)) >= -1e-8 for rule in rules)


@pytest.mark.parametrize("name", sorted(FAMILIES))
def test_what_families_know_is_true(name: str) -> None:
    for seed in range(4):
        found = case(name, seed)
        data = read(found.arguments)
        if found.forces is not None:
            assert found.truth == FEASIBLE
            verdict = judge(data, found.forces)
            assert verdict.error.max() <= 1e-12 * np.abs(data.g).max() * max(1.0, data.mu.max()), (name, seed)
            assert name in DELICATE or verdict.solved(1e-12), (name, seed, verdict.worst, verdict.rounding)
        if found.direction is not None:
            assert found.truth == INFEASIBLE
            assert check_proof(data, found.direction).fault is None


def test_a_block_on_the_ground_by_hand() -> None:
    data = read({"G": np.eye(3), "g": [0.0, 0.0, -2.0], "mu": 0.5})
    assert not judge(data, np.array([[0.0, 0.0, 2.0]])).solved(0.0)  # its rounding is not nothing
    assert judge(data, np.array([[0.0, 0.0, 2.0]])).solved(1e-14)
    verdict = judge(data, np.array([[0.0, 0.0, 1.0]]))  # half of the fall is stopped
    assert verdict.scale[0] == 2.0
    assert verdict.share == pytest.approx(0.5 / np.sqrt(1.25))
    assert judge(data, np.array([[0.0, 0.0, np.nan]])).finite is False


def test_a_slide_by_hand() -> None:
    data = read({"G": np.eye(3), "g": [3.0, 0.0, -2.0], "mu": 0.5})
    assert judge(data, np.array([[-1.0, 0.0, 2.0]])).solved(1e-14)
    assert judge(data, np.array([[1.0, 0.0, 2.0]])).share > 0.1  # friction that pushes along
    convex = read({"G": np.eye(3), "g": [3.0, 0.0, -2.0], "mu": 0.5, "law": "convex"})
    assert judge(convex, np.array([[-1.0, 0.0, 2.0]])).share > 0.1


def test_a_contact_that_nothing_moves_by_hand() -> None:
    """w = 0: the distance of -(u + Γ) to the normal cone, wherever the force is."""
    data = read({"G": np.diag([1.0, 1.0, 0.0]), "g": [1.0, 0.0, -0.05], "mu": 0.5})
    assert judge(data, np.array([[-1.25e10, 0.0, 2.5e10]])).share > 0.01
    for z, error in ((0.0, 0.0), (3.0, 0.1)):
        loose = read({"G": np.zeros((3, 3)), "g": [0.0, 0.0, 0.1], "mu": 0.5})
        assert judge(loose, np.array([[0.0, 0.0, z]])).error[0] == pytest.approx(error, abs=1e-7)


def test_proofs_by_hand() -> None:
    G = np.zeros((6, 6))
    G[2, 2] = G[5, 5] = 1.0
    G[2, 5] = G[5, 2] = -1.0
    data = read({"G": G, "g": [0, 0, -1.0, 0, 0, -1.0], "mu": 0.5})
    d = np.array([[0, 0, 1.0], [0, 0, 1.0]])
    assert check_proof(data, d).fault is None
    assert check_proof(data, d).reach == np.inf
    assert "signs" in str(check_proof(data, -d).fault)
    assert "reaches" in str(check_proof(data, np.array([[0, 0, 1.0], [0, 0, 1.0 + 1e-3]])).fault)
    assert "signs" in str(check_proof(data, d + np.array([0.1, 0, 0])).fault)
    apart = read({"G": G, "g": [0, 0, 1.0, 0, 0, 1.0], "mu": 0.5})
    assert "not negative" in str(check_proof(apart, d).fault)
    bounded = read({"G": G, "g": [0, 0, -1.0, 0, 0, -1.0], "mu": 0.5, "normal_max": [1.0, np.inf]})
    assert "signs" in str(check_proof(bounded, d).fault)
