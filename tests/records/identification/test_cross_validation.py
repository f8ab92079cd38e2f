"""Cross-validation: every toss is judged once, by a fit that has not seen it, in a fold with all laws."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.base.errors import ProblemError
from surefoot.records.identification.cross_validation import cross_validate
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_model import ThrownModel
from surefoot.records.identification.tosses import Tosses

LAWS = [ThrownModel("rigid", steps=1), ThrownModel("newton", steps=1)]
THREE = [*LAWS, ThrownModel("tangential", steps=1)]


@pytest.fixture(scope="module")
def tosses() -> Tosses:
    return random_tosses(13, (0.2, 0.2, 0.003), seed=8, steps=1, frames=45)


def test_every_toss_is_judged_once_by_a_fit_that_has_not_seen_it(tosses: Tosses) -> None:
    seen: list[tuple[str, int, Any]] = []

    def fit(train: Tosses, model: ThrownModel, test: Tosses, found: Any, seed: int) -> Any:
        assert seed == 3
        starts = {tuple(train.states[a]) for a in train.starts[:-1]}
        own = [tuple(test.states[a]) for a in test.starts[:-1]]
        assert not starts & {*own}
        assert len(train) + len(test) == len(tosses)
        seen.append((model.name, len(test), found))
        error = np.array([state[0] for state in own]) + (1.0 if model.name == "newton" else 0.0)
        value = SimpleNamespace(value=float(len(seen)))
        return SimpleNamespace(
            found=SimpleNamespace(numbers=f"body {len(seen)}"),
            test=TossErrors(error, 2.0 * error, 3.0 * error),
            parameters={"mu": value},
        )

    found = cross_validate(tosses, THREE, 4, fit, seed=3)
    assert [name for name, _, _ in seen] == ["rigid", "newton", "tangential"] * 4
    assert sorted(count for _, count, _ in seen[::3]) == [3, 3, 3, 4]
    assert [body and body.numbers for _, _, body in seen[:4]] == [None, "body 1", "body 1", None]
    np.testing.assert_allclose(found["rigid"].errors.position, tosses.states[tosses.starts[:-1], 0])
    gap = found["rigid"].less(found["newton"], "early")
    np.testing.assert_allclose([gap.value, gap.low, gap.high], -3.0)
    np.testing.assert_array_equal(found["newton"].values["mu"], [2.0, 5.0, 8.0, 11.0])


def test_folds_that_leave_too_little_are_refused(tosses: Tosses) -> None:
    with pytest.raises(ProblemError, match="folds"):
        cross_validate(tosses, LAWS, 1)
    with pytest.raises(ProblemError, match="2 folds of 13 tosses leave fewer than 8 to fit"):
        cross_validate(tosses, LAWS, 2)


@pytest.mark.long
def test_real_fits_know_newtons_restitution_is_not_theirs(tosses: Tosses) -> None:
    found = cross_validate(tosses, LAWS, 3, resamples=20)
    assert found["rigid"].errors.position.shape == (13,)
    assert found["rigid"].less(found["newton"], "early").value < 0.0
