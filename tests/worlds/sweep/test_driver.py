"""Samples that fail, samples that kill, workers that are killed: a row for each sample, and only one."""

from __future__ import annotations

from pathlib import Path

import pytest

from surefoot.base.errors import ProblemError
from surefoot.worlds.sweep import run_sweep
from surefoot.worlds.sweep.pools import Pool
from surefoot.worlds.sweep.sweep_worker import SweepTask
from tests.worlds.sweep.deadly import deadly

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")


def need(backend: str) -> None:
    package = {"loky": "joblib", "dask": "distributed"}.get(backend, backend)
    pytest.importorskip(package, reason=f"no {backend}: make test-extras")


def test_a_sample_that_fails_is_recorded(tmp_path: Path) -> None:
    result = run_sweep(deadly(10, failing=(2,), broken=(4,)), tmp_path / "a", backend="serial")
    rows = {row["index"]: row for row in result.table.to_pylist()}
    assert [rows[k]["status"] for k in (1, 2, 4)] == ["done", "error", "error"]
    assert rows[2]["error"].startswith("at 0.1 s the motion became non-finite")
    assert rows[4]["error"] == "ZeroDivisionError: a bug"
    assert rows[2]["twice"] is None
    assert rows[2]["survived"] is None
    assert rows[2]["mu"] is not None
    assert rows[1]["twice"] == 2.0 * rows[1]["mu"]


@pytest.mark.long
@pytest.mark.parametrize("backend", ["loky", "ray", "dask"])
def test_a_sample_that_kills_its_worker_thrice_is_recorded_as_crashed(backend: str, tmp_path: Path) -> None:
    need(backend)
    seen = tmp_path / "seen"
    config = deadly(24, killers=(5, 17), failing=(2,), seen=str(seen))
    result = run_sweep(config, tmp_path / "a", backend=backend, workers=2)
    assert result.lost_workers >= 6 if backend == "loky" else result.lost_workers >= 4
    status = result.table["status"].to_pylist()
    assert [k for k, s in enumerate(status) if s == "crashed"] == [5, 17]
    assert [k for k, s in enumerate(status) if s == "error"] == [2]
    assert result.table["index"].to_pylist() == list(range(24))
    runs = seen.read_text().split()
    assert runs.count("5") >= 3
    told = result.table["error"].to_pylist()[5]
    assert told == "its worker died 3 times with this sample alone at work"
    assert run_sweep(config, tmp_path / "a", backend="serial").resumed == 24  # and is not tried again


@pytest.mark.parametrize("backend", ["ray", "dask"])
def test_a_cluster_that_is_not_there_is_told(backend: str) -> None:
    need(backend)
    config = deadly()
    with pytest.raises(ProblemError, match=r"answers at 127.0.0.1:1"):
        Pool(backend, SweepTask(config.experiment, config.space), None, "127.0.0.1:1")
