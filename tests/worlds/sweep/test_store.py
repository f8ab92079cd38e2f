"""A sweep's folder: what is there is kept, what is broken is told, what is another's is left alone."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from surefoot.base.errors import ProblemError, WriteError
from surefoot.worlds.sweep import run_sweep
from tests.worlds.sweep.deadly import deadly

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")
from surefoot.worlds.sweep.store import Store
from surefoot.worlds.sweep.sweep_worker import SweepTask, run_chunk


def partly_done(folder: Path, config: Any, *parts: range) -> None:
    """Leave what a driver leaves that was killed after some writings."""
    with closing(Store(folder, config)) as store:
        for part in parts:
            store.add(run_chunk(SweepTask(config.experiment, config.space), part))


def whole(config: Any, folder: Path) -> Any:
    """Return the table of an undisturbed sweep, without wall times."""
    return run_sweep(config, folder, backend="serial").table.drop_columns(["wall_time"])


def test_a_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    seen = tmp_path / "seen"
    config = deadly(20, seen=str(seen))
    partly_done(tmp_path / "a", config, range(5), range(9, 12))
    seen.unlink()
    result = run_sweep(config, tmp_path / "a", backend="serial")
    assert (result.resumed, result.table.num_rows) == (8, 20)
    assert sorted(map(int, seen.read_text().split())) == [5, 6, 7, 8, *range(12, 20)]
    assert result.table.drop_columns(["wall_time"]).equals(whole(config, tmp_path / "b"))
    again = run_sweep(config, tmp_path / "a", backend="serial")
    assert (again.resumed, again.table) == (20, result.table)


def test_a_sample_is_written_once(tmp_path: Path) -> None:
    config = deadly(6)
    partly_done(tmp_path / "a", config, range(4), range(2, 6), range(6))
    assert run_sweep(config, tmp_path / "a", backend="serial").table["index"].to_pylist() == list(range(6))


def test_more_samples_can_be_asked_for_later_and_fewer_not(tmp_path: Path) -> None:
    small, large = deadly(7), deadly(20)
    run_sweep(small, tmp_path / "a", backend="serial")
    assert run_sweep(large, tmp_path / "a", backend="serial").resumed == 7
    table = whole(large, tmp_path / "a")
    assert table.equals(whole(large, tmp_path / "b"))
    with pytest.raises(ProblemError, match="holds sample 19, the sweep has only 7"):
        run_sweep(small, tmp_path / "a", backend="serial")
    assert whole(large, tmp_path / "a").equals(table)


def test_another_sweep_is_refused_and_nothing_touched(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_sweep(deadly(6), tmp_path / "a", backend="serial")
    before = {p.name: p.read_bytes() for p in (tmp_path / "a").iterdir()}
    with pytest.raises(
        ProblemError, match=r"holds another sweep \(seed is 0 there, 1 here\); name another folder"
    ):
        run_sweep(deadly(6, seed=1), tmp_path / "a", backend="serial")
    with pytest.raises(ProblemError, match=r"\(settings is .*0.0.* there, .*0.001.* here\)"):
        run_sweep(deadly(6, seconds=0.001), tmp_path / "a", backend="serial")
    monkeypatch.setattr("surefoot.worlds.sweep.config.__version__", "99.1")
    with pytest.raises(ProblemError, match=r'\(surefoot is ".*" there, "99.1" here\)'):
        run_sweep(deadly(6), tmp_path / "a", backend="serial")
    assert {p.name: p.read_bytes() for p in (tmp_path / "a").iterdir()} == before


def test_samples_drawn_otherwise_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As by another version of SciPy."""
    partly_done(tmp_path / "a", deadly(20), range(5))
    from surefoot.worlds.sweep.space import Space

    points = Space._points
    monkeypatch.setattr(Space, "_points", lambda *a: 0.5 * points(*a))
    with pytest.raises(ProblemError, match=r"holds another sweep \(first is"):
        run_sweep(deadly(20), tmp_path / "a", backend="serial")


def test_a_worker_of_another_version_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    config = deadly(6)
    task = SweepTask(config.experiment, config.space)
    monkeypatch.setattr("surefoot.worlds.sweep.sweep_worker.__version__", "99.1")
    with pytest.raises(ProblemError, match=r"has Surefoot 99.1, the driver .*: install the same"):
        run_chunk(task, range(2))


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(ProblemError, match="is not empty and no sweep's folder"):
        run_sweep(deadly(), tmp_path, backend="serial")
    with pytest.raises(ProblemError, match=r"cannot write to .*thesis.txt"):
        run_sweep(deadly(), tmp_path / "thesis.txt", backend="serial")
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.txt"]


def test_two_drivers_do_not_share_a_folder(tmp_path: Path) -> None:
    with (
        closing(Store(tmp_path / "a", deadly())),
        pytest.raises(ProblemError, match=r"another sweep is writing to .*: wait for it or end it"),
    ):
        run_sweep(deadly(), tmp_path / "a", backend="serial")
    assert run_sweep(deadly(), tmp_path / "a", backend="serial").table.num_rows == 20


@pytest.mark.parametrize("damage", ["empty", "text"])
def test_rows_that_cannot_be_read_are_told(damage: str, tmp_path: Path) -> None:
    partly_done(tmp_path / "a", deadly(20), range(5))
    rows = tmp_path / "a" / "sweep.sqlite"
    rows.write_bytes(b"" if damage == "empty" else b"rows, rows, rows" * 64)
    if damage == "empty":  # as a kill before the first writing leaves it
        assert run_sweep(deadly(20), tmp_path / "a", backend="serial").resumed == 0
    else:
        with pytest.raises(ProblemError, match=r"sweep.sqlite cannot be read \(.*\); move it away"):
            run_sweep(deadly(20), tmp_path / "a", backend="serial")


def test_a_full_disk_is_told_and_what_was_written_kept(tmp_path: Path) -> None:
    config = deadly(4000)
    partly_done(tmp_path / "a", config, range(5))
    with closing(Store(tmp_path / "a", config)) as store:
        (pages,) = store._rows.execute("PRAGMA page_count").fetchone()
        store._rows.execute(f"PRAGMA max_page_count = {pages + 1}")  # SQLite's own word for a full disk
        with pytest.raises(WriteError, match=r"cannot write .*sweep.sqlite: database or disk is full"):
            store.add(run_chunk(SweepTask(config.experiment, config.space), range(5, 200)))
        assert store.done == set(range(5))
    assert run_sweep(deadly(20), tmp_path / "a", backend="serial").resumed == 5


def test_the_table_says_what_it_is_of(tmp_path: Path) -> None:
    config = deadly(3)
    path = run_sweep(config, tmp_path / "a", backend="serial").path
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    assert table.schema.names == ["index", "mu", "status", "error", "survived", "twice", "wall_time"]
    told = json.loads(table.schema.metadata[b"surefoot.sweep"])
    assert (told["experiment"], told["ranges"]["mu"]["high"]) == ("deadly", 1.0)
    with sqlite3.connect(tmp_path / "a" / "sweep.sqlite") as rows:
        assert json.loads(rows.execute("SELECT identity FROM sweep").fetchone()[0]) == told
    rows.close()
