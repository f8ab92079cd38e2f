"""The scales of a contact problem against NumPy: norms, speeds of connected parts, noise, preloads."""

from __future__ import annotations

import numpy as np
import pytest

import surefoot as sf
from benchmarks.problems.contacts import pile
from surefoot.contact.problem import problem as contact_problem
from surefoot.contact.problem import scales


def random_block(rng: np.random.Generator, contacts: int) -> np.ndarray:
    J = rng.normal(size=(3 * contacts, 3 * contacts))
    return np.asarray(J @ J.T)


def test_the_norm_of_a_block_is_numpys() -> None:
    rng = np.random.default_rng(0)
    for k in range(300):
        B = rng.normal(size=(3, 3))
        B = 0.5 * (B + B.T) if k % 3 == 0 else B @ B.T  # indefinite ones, too
        if k % 5 == 0:  # two or three eigenvalues of one size: the double roots
            Q = np.linalg.qr(B)[0]
            B = Q @ np.diag([[2.0, 2.0, 1.0], [2.0, 1.0, 1.0], [1.0, 1.0, 1.0]][k % 15 // 5]) @ Q.T
        B = B * 10.0 ** rng.uniform(-200, 200)
        entries = B[0, 0], B[1, 1], B[2, 2], B[0, 1], B[0, 2], B[1, 2]
        found = scales.symmetric_norm(*map(float, entries))
        top = np.abs(B).max()
        assert found == pytest.approx(top * np.linalg.norm(B / top, 2), rel=2e-8)
    assert scales.symmetric_norm(0.0, 0.0, 0.0, 0.0, 0.0, 0.0) == 0.0


@pytest.mark.parametrize("parts", [1, 3])
@pytest.mark.parametrize("noise", [0.0, 1e-16])
def test_speeds_are_those_of_connected_parts(parts: int, noise: float) -> None:
    """Dense and block form alike; parts joined by rounding lend a millionth of their speed."""
    rng = np.random.default_rng(parts)
    G = np.zeros((6 * parts, 6 * parts))
    g = rng.normal(size=6 * parts) * np.repeat(10.0 ** (-4.0 * np.arange(parts)), 6)
    for k in range(parts):
        G[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = random_block(rng, 2)
    G += noise * np.where(G == 0.0, 1.0, 0.0)
    problem = sf.ContactProblem(G, g, 0.5)
    own = np.linalg.norm(g.reshape(-1, 3), axis=1).reshape(parts, 2).max(axis=1)
    expected = np.repeat(np.maximum(own, 1e-6 * own.max() if noise else 0.0), 2)
    w, s, trace, energy = problem.scales
    assert np.allclose(s, expected, rtol=1e-12)
    blocks = [G[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] for k in range(2 * parts)]
    assert np.allclose(w, [np.linalg.norm(B, 2) for B in blocks], rtol=2e-8)
    assert np.allclose(trace, [np.trace(B) for B in blocks])
    assert np.allclose(energy, np.repeat((s**2 / w).reshape(parts, 2).sum(axis=1), 2), rtol=1e-6)
    b, again = problem.blocks, np.zeros((4, 2 * parts))
    scales.scales_blocks(
        b.starts, b.columns, b.values, g, problem.normal_min, problem.normal_max, again
    )  # fmt: skip
    assert np.allclose(again, problem.scales, rtol=1e-12)


def test_contacts_that_are_off_join_nothing() -> None:
    """A chain of three: without its middle the ends have nothing to do with each other."""
    G = np.kron([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]], np.eye(3))
    g = np.array([1.0, 0, 0, 0, 0, 9.0, 0, 3.0, 0])
    assert sf.ContactProblem(G, g, 0.5).scales[1].tolist() == [9.0, 9.0, 9.0]
    off = sf.ContactProblem(G, g, 0.5, normal_max=[np.inf, 0.0, np.inf])
    assert off.scales[1].tolist() == [1.0, 0.0, 3.0]


def test_speed_is_that_at_the_least_forces() -> None:
    """Preloads count, and what rounding leaves of preloads that hold each other is no speed."""
    rng = np.random.default_rng(3)
    G, low = random_block(rng, 3), np.array([1.0, 20.0, 0.3])
    least = np.zeros((3, 3))
    least[:, 2] = low
    rest = sf.ContactProblem(G, -(G @ least.ravel()), 0.5, low)
    assert rest.scales[1].tolist() == [0.0, 0.0, 0.0]
    found = sf.solve(rest)
    assert found.solved
    assert np.array_equal(found.forces, least)
    moved = sf.ContactProblem(G, -(G @ least.ravel()) + 1e-6 * np.eye(9)[2], 0.5, low)
    assert np.allclose(moved.scales[1], 1e-6, rtol=1e-6)
    b, again = moved.blocks, np.zeros((4, 3))
    scales.scales_blocks(b.starts, b.columns, b.values, moved.g, low, moved.normal_max, again)
    assert np.allclose(again, moved.scales, rtol=1e-9)


@pytest.mark.parametrize("size", [1e-320, 1e-200, 1e200])
def test_squares_that_overflow_or_vanish(size: float) -> None:
    problem = sf.ContactProblem(np.eye(6), size * np.array([0.0, 3.0, 4.0, 0, 0, 0]), 0.5)
    expected = [0.0, 0.0] if size < 1e-290 else [5.0 * size, 0.0]
    assert np.allclose(problem.scales[1] / max(size, 1e-290), np.array(expected) / max(size, 1e-290))


def test_what_changes_in_place_is_seen() -> None:
    problem = sf.ContactProblem(np.eye(3), [0.0, 0.0, -1.0], 0.5)
    assert sf.residuals(problem, np.zeros((1, 3))).velocity_error == 1.0
    problem.g[2] = -1e-9
    assert problem.scales[1, 0] == 1e-9
    assert sf.residuals(problem, np.zeros((1, 3))).velocity_error == pytest.approx(1.0)


def test_scales_of_many_contacts_are_those_of_the_whole_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    """From blocks and from all of G: the same numbers, in one part and in two."""
    drawn = pile(np.random.default_rng(3), 40, 150, 0.5, 1.0)
    apart = np.kron(np.eye(2), drawn.G)
    for G, g in ((drawn.G, drawn.g), (apart, np.append(drawn.g, 2.0 * drawn.g))):
        many = sf.ContactProblem(G, g, 0.5)
        from_blocks = many.scales
        with monkeypatch.context() as at:
            at.setattr(contact_problem, "MOST_DENSE", 1000)
            np.testing.assert_array_equal(many.scales, from_blocks)
