"""Instructions of CasADi carried out for eight points at once give what CasADi gives, to the last digit."""

from __future__ import annotations

import numpy as np
import pytest

casadi = pytest.importorskip("casadi")

from surefoot.robot.symbolic_tape import mapped  # noqa: E402


def example(extra=lambda x: x):
    x, p = casadi.SX.sym("x", 4), casadi.SX.sym("p", 2)
    parts = [
        x[0] * x[1] + 2.0, x[2] / x[3] - p[0], casadi.sqrt(x[0] ** 2 + 1.0), -casadi.sin(x[1]), 2.0 * x[2],
        casadi.cos(p[1]) / x[3], 1.0 / x[3], p[0], 0.5,
    ]  # fmt: skip
    return casadi.Function("f", [x, p], [casadi.vertcat(*parts, extra(x[0])), casadi.jacobian(parts[0], x)])


@pytest.mark.parametrize("count", [1, 8, 13])
def test_every_point_gets_its_own_numbers(count):
    function, rng = example(), np.random.default_rng(count)
    given = rng.normal(size=(4, count)), rng.normal(size=(2, count))
    ours, theirs = mapped(function, count), function.map(count)
    assert isinstance(ours, casadi.Callback)
    for found, wanted in zip(ours(*given), theirs(*given), strict=True):
        assert found.sparsity() == wanted.sparsity()
        assert np.array(found.nonzeros()) == pytest.approx(np.array(wanted.nonzeros()), rel=1e-15, abs=0.0)


def test_what_is_not_known_is_left_to_casadi():
    function = example(lambda x: casadi.tanh(x))
    assert not isinstance(mapped(function, 3), casadi.Callback)
