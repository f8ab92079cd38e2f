"""The command that tells whether a fit to tosses ended at a minimum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.identify_minimum import Fall, find_falls, main, robust_mean, show_falls
from benchmarks.problems.tosses import random_tosses, write_tosses
from surefoot.records.identification.identify import identify
from surefoot.records.identification.toss_model import ThrownModel


def test_the_loss_is_that_of_its_definition() -> None:
    rows = np.array([[3.0, 4.0, 0.0, 2.0], [0.0, 0.0, 0.0, 0.0], [np.nan, 0.0, 0.0, 1.0]])
    place = (np.hypot(2.0, np.sqrt(12.5)) - 2.0, np.hypot(2.0, 10.0) - 2.0)  # what is lost is 10 widths off
    turn = (np.hypot(0.5, np.sqrt(2.0)) - 0.5, np.hypot(0.5, 1.0) - 0.5)  # a quarter of the scale: four-fold
    by_hand = np.mean(place) + 4.0 * np.mean(turn)
    assert robust_mean(rows, np.array([2, 1]), np.array([2.0, 0.5])) == pytest.approx(by_hand)


def test_a_parameter_that_still_pays_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    show_falls(0.5, [Fall("mu", 0.128, 0.1363, -0.0135), Fall("scale", 1.0, 1.01, 0.02)])
    out = capsys.readouterr().out
    assert "| mu | 0.128 | 0.1363 | -1.35 % |" in out
    assert "lower by 0.5 % alone: mu" in out


@pytest.mark.long
def test_a_settled_fit_has_no_parameter_that_pays_and_a_moved_one_is_caught() -> None:
    """The noise is larger than what a toss jumps by where another corner lands first: a fit can settle."""
    law = ThrownModel(steps=1)
    recorded = random_tosses(8, (0.2, 0.2, 0.003), seed=1, steps=1, frames=45, noise=12.0)
    fit = identify(recorded, law, resamples=20)
    assert not any("did not settle" in note for note in fit.notes)
    upright, values = fit.found.upright(recorded), np.array([fit[p.name].value for p in law.parameters])
    loss, falls = find_falls(upright, law, fit.found, values, 8)
    assert loss == pytest.approx(fit.loss, rel=1e-9)
    assert min(fall.change for fall in falls) > -0.005
    moved = find_falls(upright, law, fit.found, values + np.array([0.05, 0.0, 0.0]), 8)[1]
    assert min(moved, key=lambda fall: fall.change).name == "mu"


@pytest.mark.long
def test_the_command_prints_a_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded = random_tosses(8, (0.2, 0.2, 0.003), seed=1, steps=1, frames=30)
    path = write_tosses(recorded, tmp_path / "t.npz")
    main([str(path), "--moves", "1"])
    assert "| restitution |" in capsys.readouterr().out
