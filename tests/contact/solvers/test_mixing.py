"""Anderson's mixing: on a linear map what GMRES is, and harmless where there is nothing to mix."""

from __future__ import annotations

import numpy as np
import pytest

from surefoot.base.arrays import FloatArray
from surefoot.contact.solvers.mixing import Mixing


def slow_map(size: int) -> tuple[FloatArray, FloatArray]:
    """Return A and b of x -> A x + b, whose error falls by 1 % a step along one direction."""
    Q = np.linalg.qr(np.random.default_rng(0).normal(size=(size, size)))[0]
    return Q @ np.diag(np.linspace(-0.5, 0.99, size)) @ Q.T, np.ones(size)


def test_a_linear_map_takes_as_many_steps_as_it_has_dimensions() -> None:
    A, b = slow_map(8)
    answer, mixing, x = np.linalg.solve(np.eye(8) - A, b), Mixing(10), np.zeros(8)
    for _ in range(10):
        x = mixing.next(x, A @ x + b)
    np.testing.assert_allclose(x, answer, rtol=1e-6)
    plain = np.zeros(8)
    for _ in range(50):
        plain = A @ plain + b
    assert np.abs(plain - answer).max() > 1.0


def test_few_differences_still_shorten_it() -> None:
    A, b = slow_map(40)
    answer, mixing, x = np.linalg.solve(np.eye(40) - A, b), Mixing(3), np.zeros(40)
    for _ in range(60):
        x = mixing.next(x, A @ x + b)
    plain = np.zeros(40)
    for _ in range(60):
        plain = A @ plain + b
    assert np.abs(x - answer).max() < 1e-2 * np.abs(plain - answer).max()


@pytest.mark.parametrize("scale", [1e-9, 1e9])
def test_units_do_not_matter(scale: float) -> None:
    A, b = slow_map(6)
    one, other = Mixing(4), Mixing(4, scale)
    x, y = np.zeros(6), np.zeros(6)
    for _ in range(4):
        x, y = one.next(x, A @ x + b), other.next(y, A @ y + scale * b)
    np.testing.assert_allclose(y, scale * x, rtol=1e-9)


def test_equal_points_and_numbers_that_are_none_are_not_mixed() -> None:
    mixing, x = Mixing(3), np.ones(2)
    for _ in range(4):
        assert mixing.next(x, x) is x
    lost = np.array([np.nan, 1.0])
    assert mixing.next(x, lost) is lost
    assert len(mixing) > 0
    mixing.forget()
    assert len(mixing) == 0
    assert mixing.next(x, 2.0 * x).tolist() == [2.0, 2.0]
