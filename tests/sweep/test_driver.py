"""Samples that fail, samples that kill, workers that are killed: a row for each sample, and only one."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import pytest

from surefoot.errors import ProblemError
from surefoot.sweep import run_sweep
from surefoot.sweep.driver import ChunkQueue
from surefoot.sweep.pools import Chunk, Pool
from surefoot.sweep.worker import Row, SweepTask, run_chunk
from tests.sweep.deadly import deadly

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")


class Fragile(Pool):
    """Runs chunks here; loses all that are waiting whenever a killer is among them, or at given times."""

    def __init__(self, config: Any, workers: int, killers: set[int], mishaps: set[int]) -> None:
        self.workers, self.given = workers, list[Chunk]()
        self._task, self._killers, self._mishaps = (
            SweepTask(config.experiment, config.space),
            killers,
            mishaps,
        )
        self._waiting: deque[Chunk] = deque()
        self._looks = 0

    @property
    def waiting(self) -> int:
        return len(self._waiting)

    def submit(self, chunk: Chunk) -> None:
        self.given.append(chunk)
        self._waiting.append(chunk)

    def wait(self, seconds: float) -> list[tuple[Chunk, list[Row] | None]]:
        self._looks += 1
        chunk = self._waiting.popleft()
        if not self._killers.intersection(chunk) and self._looks not in self._mishaps:
            return [(chunk, run_chunk(self._task, chunk))]
        lost = [chunk, *self._waiting]
        self._waiting.clear()
        return [(one, None) for one in lost]

    def close(self) -> None:
        return


@pytest.mark.parametrize("workers", [1, 2, 5])
@pytest.mark.parametrize(
    ("killers", "mishaps"),
    [(set(), set()), ({3}, set()), ({0, 7, 19}, set()), (set(), {1, 4, 6, 9, 12}), ({5}, {2, 9})],
)
def test_killers_are_found_and_bystanders_get_their_rows(
    workers: int, killers: set[int], mishaps: set[int]
) -> None:
    config = deadly(20)
    pool = Fragile(config, workers, killers, mishaps)
    crew = ChunkQueue(pool, config, list(range(20)))
    found = [row for rows in crew.rows() for row in rows]
    assert sorted(row["index"] for row in found) == list(range(20))
    assert {row["index"] for row in found if row["status"] == "crashed"} == killers
    for row in found:
        if row["status"] == "done":
            assert row["twice"] == 2.0 * row["mu"]
    for killer in killers:
        assert sum(chunk == (killer,) for chunk in pool.given) >= 3
    assert (crew.lost == 0) == (not killers and not mishaps)


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


@pytest.mark.parametrize("backend", ["loky", "ray", "dask"])
def test_a_sample_that_kills_its_worker_thrice_is_recorded_as_crashed(backend: str, tmp_path: Path) -> None:
    if backend != "loky":
        pytest.importorskip(
            {"dask": "distributed"}.get(backend, backend), reason=f"no {backend}: make test-extras"
        )
    pytest.importorskip("joblib", reason="loky comes with joblib")
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
    pytest.importorskip(
        {"dask": "distributed"}.get(backend, backend), reason=f"no {backend}: make test-extras"
    )
    config = deadly()
    with pytest.raises(ProblemError, match=r"answers at 127.0.0.1:1"):
        Pool(backend, SweepTask(config.experiment, config.space), None, "127.0.0.1:1")
