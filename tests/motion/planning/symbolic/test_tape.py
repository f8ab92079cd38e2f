"""Instructions of CasADi carried out for many points at once give what CasADi gives, to the last digit."""

from __future__ import annotations

import numpy as np
import pytest

casadi = pytest.importorskip("casadi")

from surefoot.motion.planning.symbolic import tape as symbolic_tape  # noqa: E402
from surefoot.motion.planning.symbolic.tape import Tape, record_tape, tapes_of  # noqa: E402


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
    ours, theirs = record_tape(function).map_over(count), function.map(count)
    for found, wanted in zip(ours(*given), theirs(*given), strict=True):
        assert found.sparsity() == wanted.sparsity()
        assert np.array(found.nonzeros()) == pytest.approx(np.array(wanted.nonzeros()), rel=1e-15, abs=0.0)


def test_tapes_are_kept_under_what_they_were_made_from(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(symbolic_tape, "_folder", lambda: tmp_path)
    made = []

    def asked(source):
        return tapes_of(source, ["f"], lambda: made.append(source) or {"f": source})["f"]

    first, again, other = asked(example()), asked(example()), asked(example(lambda x: x + 1.0))
    assert len(made) == len(list(tmp_path.iterdir())) == 2
    given = np.ones((4, 3)), np.ones((2, 3))
    for found, wanted in zip(again.map_over(3)(*given), first.map_over(3)(*given), strict=True):
        assert (found.sparsity(), found.nonzeros()) == (wanted.sparsity(), wanted.nonzeros())
    assert len(other.table) == len(first.table) + 1
    for file in tmp_path.iterdir():
        file.write_bytes(b"cut off")
    assert isinstance(asked(example()), Tape)
    assert not isinstance(asked(example(casadi.tanh)), Tape)  # what is not known is left to CasADi
