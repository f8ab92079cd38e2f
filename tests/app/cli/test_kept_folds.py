"""Folds of a cross-validation: a law is kept when it is judged, and what is there is not judged anew."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.app.cli import kept_folds
from surefoot.app.cli.identify_folds import identify_folds
from surefoot.app.cli.kept_folds import folds_folder, judge_folds, read_folds
from surefoot.app.cli.signals import INTERRUPTED
from surefoot.records.identification.cross_validation import cross_validate, gather_folds, judge_fold
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_fit import BodyNumbers, Estimate
from surefoot.records.identification.toss_model import ThrownModel
from surefoot.records.identification.tosses import Tosses

LAWS = [ThrownModel("rigid", steps=1), ThrownModel("newton", steps=1)]
GROWTH = np.array([[1e-3, 2e-3], [3e-3, 2e-3]])


@pytest.fixture(scope="module")
def tosses() -> Tosses:
    return random_tosses(13, (0.2, 0.2, 0.003), seed=8, steps=1, frames=45)


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Laws that were fitted, in order; the seventh fails while "fails" is among them."""
    seen: list[str] = []

    def fit(train: Tosses, model: ThrownModel, test: Tosses, found: Any, **settings: Any) -> Any:
        if len(seen) == 7 and "fails" in seen:
            raise KeyboardInterrupt
        seen.append(model.name)
        errors = TossErrors(*(k + test.states[test.starts[:-1], 0] for k in range(3)))
        estimate = Estimate(float(len(test)), -1.0, 7.5, "m")
        numbers = BodyNumbers({"mu": 0.1}, {"mu": np.arange(3.0)}, {"mu": estimate}, None, GROWTH)
        body = found or SimpleNamespace(numbers=numbers)
        return SimpleNamespace(found=body, test=errors, parameters={"mu": estimate})

    monkeypatch.setattr(kept_folds, "judge_fold", partial(judge_fold, fit=fit))
    return seen


def test_what_is_there_is_read_and_the_rest_is_judged(
    tosses: Tosses, fitted: list[str], tmp_path: Path
) -> None:
    shown: list[float] = []
    folder = tmp_path / "new" / "folds"
    first = judge_folds(tosses, LAWS, 4, folder, 1, shown.append)
    assert fitted == ["rigid", "newton"] * 4
    assert shown == [2.0, 4.0, 6.0, 8.0]
    for law in ("rigid", "newton"):
        (folder / f"fold-3-of-4-{law}.npz").unlink()
    again = judge_folds(tosses, LAWS, 4, folder, 1, None)
    assert fitted[8:] == ["rigid", "newton"]
    a, b = (gather_folds(tosses, folds) for folds in (first, again))
    np.testing.assert_array_equal(a["newton"].errors.position, b["newton"].errors.position)
    np.testing.assert_array_equal(a["rigid"].errors.position, tosses.states[tosses.starts[:-1], 0])
    np.testing.assert_array_equal(b["rigid"].values["mu"], [4.0, 3.0, 3.0, 3.0])
    for kept, law in zip(again, first, strict=True):
        assert kept["rigid"].numbers.parameters == law["rigid"].numbers.parameters
        assert kept["rigid"].numbers.values == law["rigid"].numbers.values
        assert kept["rigid"].numbers.scale is None
        np.testing.assert_array_equal(kept["rigid"].numbers.growth, GROWTH)
        np.testing.assert_array_equal(kept["rigid"].numbers.draws["mu"], np.arange(3.0))


def test_an_interrupt_leaves_the_laws_that_are_done(
    tosses: Tosses, fitted: list[str], tmp_path: Path
) -> None:
    fitted.append("fails")
    with pytest.raises(KeyboardInterrupt):
        judge_folds(tosses, LAWS, 4, tmp_path, 1, None)
    done = [f"fold-{k}-of-4-{law}.npz" for k in (1, 2, 3) for law in ("newton", "rigid")]
    assert sorted(path.name for path in tmp_path.iterdir()) == done
    whole = read_folds(LAWS, 4, tmp_path)
    assert [fold is None for fold in whole] == [False, False, False, True]
    told = gather_folds(tosses, whole)["newton"]
    mine = np.arange(len(tosses)) % 4 != 3
    np.testing.assert_array_equal(told.errors.position, tosses.states[tosses.starts[:-1], 0][mine])
    np.testing.assert_array_equal(told.values["mu"], [4.0, 3.0, 3.0])
    fitted.clear()
    judge_folds(tosses, LAWS, 4, tmp_path, 1, None)
    assert fitted == ["rigid", "newton"]


def test_an_interrupt_prints_the_folds_that_are_done(
    tosses: Tosses, fitted: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fitted.append("fails")
    for as_json in (True, False):
        code = identify_folds(tosses, LAWS, 4, {}, tmp_path, 1, as_json)
        assert code == INTERRUPTED
        printed = capsys.readouterr()
        assert "the same command goes on from there" in printed.err
        if as_json:
            facts = json.loads(printed.out)
            assert (facts["tosses"], facts["folds"], facts["folds_done"]) == (10, 4, 3)
            assert set(facts["laws"]) == {"rigid", "newton"}
        else:
            assert "10 tosses of 3 folds" in printed.out
            assert "over 3 of 4 folds" in printed.out
        fitted[:] = ["fails"] * 7


def test_other_tosses_first_laws_and_settings_have_folders_of_their_own(
    tosses: Tosses, tmp_path: Path
) -> None:
    model = tmp_path / "body.urdf"
    model.write_text("<robot/>")
    settings: dict[str, Any] = {"model": model, "resamples": 20, "seed": 0}
    places = [
        folds_folder(tmp_path, tosses, LAWS[0], settings),
        folds_folder(tmp_path, tosses.subset(np.arange(12)), LAWS[0], settings),
        folds_folder(tmp_path, tosses, LAWS[1], settings),
        folds_folder(tmp_path, tosses, LAWS[0], settings | {"seed": 1}),
    ]
    assert folds_folder(tmp_path, tosses, LAWS[0], settings) == places[0]
    model.write_text("<robot name='other'/>")
    places.append(folds_folder(tmp_path, tosses, LAWS[0], settings))
    assert len(set(places)) == 5


@pytest.mark.long
def test_a_law_that_is_added_begins_with_the_body_that_is_kept(tosses: Tosses, tmp_path: Path) -> None:
    judge_folds(tosses, LAWS[:1], 3, tmp_path, 1, None, resamples=20)
    added = gather_folds(tosses, judge_folds(tosses, LAWS, 3, tmp_path, 1, None, resamples=20))
    whole = cross_validate(tosses, LAWS, 3, resamples=20)
    for law in ("rigid", "newton"):
        np.testing.assert_array_equal(added[law].errors.position, whole[law].errors.position)
        for name, values in whole[law].values.items():
            np.testing.assert_array_equal(added[law].values[name], values)


@pytest.mark.long
def test_processes_judge_as_one_does(tosses: Tosses, tmp_path: Path) -> None:
    found = judge_folds(tosses, LAWS[:1], 3, tmp_path, 2, None, resamples=20)
    one = cross_validate(tosses, LAWS[:1], 3, resamples=20)["rigid"]
    both = gather_folds(tosses, found)["rigid"]
    np.testing.assert_array_equal(both.errors.position, one.errors.position)
    np.testing.assert_array_equal(both.values["mu"], one.values["mu"])
