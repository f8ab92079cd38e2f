"""Folds of a cross-validation: each is kept when it is judged, and what is there is not judged anew."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.problems.tosses import random_tosses
from surefoot.app.cli import kept_folds
from surefoot.app.cli.kept_folds import folds_folder, judge_folds
from surefoot.records.identification.cross_validation import JudgedFold, cross_validate, gather_folds
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_model import ThrownModel
from surefoot.records.identification.tosses import Tosses

LAWS = [ThrownModel("rigid", steps=1), ThrownModel("newton", steps=1)]


@pytest.fixture(scope="module")
def tosses() -> Tosses:
    return random_tosses(13, (0.2, 0.2, 0.003), seed=8, steps=1, frames=45)


@pytest.fixture
def judged(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Folds that were judged, in order; a fold 3 fails while 99 is among them."""
    seen: list[int] = []

    def fake(tosses: Tosses, models: Any, folds: int, fold: int, **settings: Any) -> JudgedFold:
        if fold == 3 and 99 in seen:
            raise KeyboardInterrupt
        seen.append(fold)
        count = len(np.arange(len(tosses))[fold::folds])
        errors = TossErrors(np.full(count, fold + 0.1), np.full(count, 0.2), np.arange(float(count)))
        values = {model.name: {"mu": fold / 7} for model in models}
        return JudgedFold(dict.fromkeys(values, errors), values)

    monkeypatch.setattr(kept_folds, "judge_fold", fake)
    return seen


def test_what_is_there_is_read_and_the_rest_is_judged(
    tosses: Tosses, judged: list[int], tmp_path: Path
) -> None:
    shown: list[float] = []
    first = judge_folds(tosses, LAWS, 4, tmp_path / "new" / "folds", 1, shown.append)
    assert judged == [0, 1, 2, 3]
    assert shown == [1.0, 2.0, 3.0, 4.0]
    (tmp_path / "new" / "folds" / "fold-3-of-4.npz").unlink()
    again = judge_folds(tosses, LAWS, 4, tmp_path / "new" / "folds", 1, None)
    assert judged == [0, 1, 2, 3, 2]
    a, b = (gather_folds(tosses, folds) for folds in (first, again))
    np.testing.assert_array_equal(a["newton"].errors.position, b["newton"].errors.position)
    np.testing.assert_array_equal(a["rigid"].errors.position, np.arange(13) % 4 + 0.1)
    np.testing.assert_array_equal(b["rigid"].values["mu"], np.arange(4) / 7)


def test_an_interrupt_leaves_what_is_done(tosses: Tosses, judged: list[int], tmp_path: Path) -> None:
    judged.append(99)
    with pytest.raises(KeyboardInterrupt):
        judge_folds(tosses, LAWS, 4, tmp_path, 1, None)
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"fold-{k}-of-4.npz" for k in (1, 2, 3)]
    judged.clear()
    judge_folds(tosses, LAWS, 4, tmp_path, 1, None)
    assert judged == [3]


def test_other_tosses_laws_and_settings_have_folders_of_their_own(tosses: Tosses, tmp_path: Path) -> None:
    model = tmp_path / "body.urdf"
    model.write_text("<robot/>")
    settings: dict[str, Any] = {"model": model, "resamples": 20, "seed": 0}
    places = [
        folds_folder(tmp_path, tosses, LAWS, settings),
        folds_folder(tmp_path, tosses.subset(np.arange(12)), LAWS, settings),
        folds_folder(tmp_path, tosses, LAWS[:1], settings),
        folds_folder(tmp_path, tosses, LAWS, settings | {"seed": 1}),
    ]
    assert folds_folder(tmp_path, tosses, LAWS, settings) == places[0]
    model.write_text("<robot name='other'/>")
    places.append(folds_folder(tmp_path, tosses, LAWS, settings))
    assert len(set(places)) == 5


@pytest.mark.long
def test_processes_judge_as_one_does(tosses: Tosses, tmp_path: Path) -> None:
    found = judge_folds(tosses, LAWS[:1], 3, tmp_path, 2, None, resamples=20)
    one = cross_validate(tosses, LAWS[:1], 3, resamples=20)["rigid"]
    both = gather_folds(tosses, found)["rigid"]
    np.testing.assert_array_equal(both.errors.position, one.errors.position)
    np.testing.assert_array_equal(both.values["mu"], one.values["mu"])
