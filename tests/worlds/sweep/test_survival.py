"""Shares that survived, counted and with their intervals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from surefoot.worlds.sweep import Space, SweepConfig, TextRange, run_sweep, sweep_from_dict
from surefoot.worlds.sweep.survival import counts, margins, survival_grid, wilson
from tests.worlds.sweep.deadly import Deadly, deadly

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")


def test_a_share_of_none_is_no_number() -> None:
    assert np.isnan([wilson(0, 0).value, wilson(0, 0).low, wilson(0, 0).high]).all()
    assert wilson(3, 7).low < wilson(3, 7).value == 3 / 7 < wilson(3, 7).high


def test_a_margin_counts_every_sample_that_is_done_once(tmp_path: Path) -> None:
    config = deadly(256, failing=(3, 4), broken=(9,))
    table = run_sweep(config, tmp_path / "a", backend="serial").table
    (margin,) = margins(config, table)
    mu = np.array(table["mu"].to_pylist())
    done = np.array(table["status"].to_pylist()) == "done"
    for k in range(8):
        inside = done & (mu >= margin.edges[k]) & (mu < margin.edges[k + 1])
        assert margin.counts[k] == inside.sum()
        assert margin.survived[k] == (inside & (mu > 0.5)).sum()
    assert counts(config, table) == {
        "done": 253,
        "error": 3,
        "crashed": 0,
        "survived": int(margin.survived.sum()),
    }
    assert margin.effect() == pytest.approx(0.5, abs=0.01)


def test_a_grid_has_every_sample_once(tmp_path: Path) -> None:
    settings = {"body": "ball", "dt": 0.01, "duration": 0.05}
    content = {"experiment": "drop", "samples": 40, "settings": settings,
               "ranges": {"mu": [0.2, 0.8], "mass": {"low": 0.1, "high": 10, "scale": "log"},
                          "terrain": ["flat", "slope:10"]}}  # fmt: skip
    config = sweep_from_dict(content)
    table = run_sweep(config, tmp_path / "a", backend="serial").table
    x, y, number, survived = survival_grid(config, table, "mu", "mass", bins=4)
    expected = np.histogram2d(table["mu"].to_pylist(), table["mass"].to_pylist(), [x, y])[0]
    np.testing.assert_array_equal(number, expected)
    assert number.sum() == 40
    assert (survived <= number).all()
    np.testing.assert_allclose(y, [0.1, 0.1 * 10**0.5, 1.0, 10**0.5, 10.0], rtol=1e-12)
    texts = margins(config, table)[-1]
    assert texts.labels == ("flat", "slope:10")
    assert texts.counts.sum() == 40


def test_a_sweep_of_nothing_but_its_seed(tmp_path: Path) -> None:
    config = SweepConfig("deadly", Deadly(), Space({"seen": TextRange(("",))}), 4)
    assert margins(config, run_sweep(config, tmp_path / "a", backend="serial").table)[0].labels == ("",)
    bare = SweepConfig("deadly", Deadly(), Space({}), 4)
    assert run_sweep(bare, tmp_path / "b", backend="serial").table["twice"].to_pylist() == [0.0] * 4


def test_a_bin_without_samples_has_no_median(tmp_path: Path) -> None:
    config = deadly(3)
    table = run_sweep(config, tmp_path / "a", backend="serial").table
    found = [middle["twice"] for middle in margins(config, table)[0].medians]
    assert sorted(k is None for k in found) == [False] * 3 + [True] * 5
