"""A sweep's folder: what is there is kept, what is broken is told, what is another's is left alone."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

import pytest

from surefoot.errors import ProblemError, WriteError
from surefoot.sweep import run_sweep
from tests.sweep.deadly import deadly

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install 'surefoot[sweep]'")
from surefoot.sweep.store import Store
from surefoot.sweep.worker import Task, run_chunk


def rows(config: Any, indices: range) -> list[dict[str, Any]]:
    return run_chunk(Task(config.experiment, config.space), indices)


def partly_done(folder: Path, config: Any, *parts: range) -> None:
    """Leave what a driver leaves that was killed after some parts."""
    with Store(folder, config) as store:
        for part in parts:
            store.add(rows(config, part))
            store.flush()


def whole(config: Any, folder: Path) -> Any:
    """Return the table of an undisturbed sweep, without wall times."""
    return run_sweep(config, folder, backend="serial").table.drop_columns(["wall_time"])


def test_a_sweep_goes_on_where_it_was(tmp_path: Path) -> None:
    seen = tmp_path / "seen"
    config = deadly(20, seen=str(seen))
    partly_done(tmp_path / "a", config, range(5), range(9, 12))
    seen.unlink()
    result = run_sweep(config, tmp_path / "a", backend="serial")
    assert (result.resumed, result.table.num_rows, result.notes) == (8, 20, ())
    assert sorted(map(int, seen.read_text().split())) == [5, 6, 7, 8, *range(12, 20)]
    assert result.table.drop_columns(["wall_time"]).equals(whole(config, tmp_path / "b"))
    assert not list((tmp_path / "a" / "parts").iterdir())
    again = run_sweep(config, tmp_path / "a", backend="serial")
    assert (again.resumed, again.table) == (20, result.table)


def test_more_samples_can_be_asked_for_later_and_fewer_not(tmp_path: Path) -> None:
    small, large = deadly(7), deadly(20)
    run_sweep(small, tmp_path / "a", backend="serial")
    assert run_sweep(large, tmp_path / "a", backend="serial").resumed == 7
    table = whole(large, tmp_path / "a")
    assert table.equals(whole(large, tmp_path / "b"))
    with pytest.raises(ProblemError, match="holds sample 19, the sweep has only 7"):
        run_sweep(small, tmp_path / "a", backend="serial")
    assert whole(large, tmp_path / "a").equals(table)


def test_a_driver_killed_between_the_merge_and_the_removal_of_parts(tmp_path: Path) -> None:
    config = deadly(6)
    partly_done(tmp_path / "a", config, range(6))
    part = tmp_path / "a" / "parts" / "part-000000.parquet"
    kept = part.read_bytes()
    run_sweep(config, tmp_path / "a", backend="serial")
    part.write_bytes(kept)
    result = run_sweep(config, tmp_path / "a", backend="serial")
    assert result.table["index"].to_pylist() == list(range(6))
    assert not part.exists()


def test_another_sweep_is_refused_and_nothing_touched(tmp_path: Path) -> None:
    run_sweep(deadly(6), tmp_path / "a", backend="serial")
    before = {p.name: p.read_bytes() for p in (tmp_path / "a").iterdir() if p.is_file()}
    with pytest.raises(ProblemError, match=r"holds another sweep \(seed is 0 there, 1 here\)"):
        run_sweep(deadly(6, seed=1), tmp_path / "a", backend="serial")
    with pytest.raises(ProblemError, match=r"settings.seconds is 0.0 there, 0.001 here"):
        run_sweep(deadly(6, seconds=0.001), tmp_path / "a", backend="serial")
    assert {p.name: p.read_bytes() for p in (tmp_path / "a").iterdir() if p.is_file()} == before


def set_version(monkeypatch: pytest.MonkeyPatch, version: str, *modules: str) -> None:
    for module in modules:
        monkeypatch.setattr(f"surefoot.sweep.{module}.__version__", version)


@pytest.mark.parametrize("there", ["0.0.9", None])
def test_another_version_does_not_go_on(there: str | None, tmp_path: Path) -> None:
    partly_done(tmp_path / "a", deadly(6), range(3))
    path = tmp_path / "a" / "sweep.json"
    told = {k: v for k, v in json.loads(path.read_text()).items() if k != "surefoot"}
    path.write_text(json.dumps(told | ({} if there is None else {"surefoot": there})))
    with pytest.raises(ProblemError, match=rf"was begun by Surefoot {there or 'no version'}, this is"):
        run_sweep(deadly(6), tmp_path / "a", backend="serial")


def test_rows_of_another_version_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    partly_done(tmp_path / "a", deadly(6), range(3))
    part = tmp_path / "a" / "parts" / "part-000000.parquet"
    import pyarrow.parquet

    assert b"surefoot.version" in pyarrow.parquet.read_schema(part).metadata
    set_version(monkeypatch, "99.1", "config", "columns", "store")
    partly_done(tmp_path / "b", deadly(6), range(3, 6))
    part.rename(tmp_path / "b" / "parts" / "part-000007.parquet")
    with pytest.raises(ProblemError, match=r"part-000007.parquet is not of this sweep"):
        run_sweep(deadly(6), tmp_path / "b", backend="serial")


def test_a_worker_of_another_version_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    config = deadly(6)
    task = Task(config.experiment, config.space)
    set_version(monkeypatch, "99.1", "worker")
    with pytest.raises(ProblemError, match=r"has Surefoot 99.1, the driver .*: install the same"):
        run_chunk(task, range(2))


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="files are named by /proc")
def test_names_are_on_the_disk_before_anything_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a power cut a table that was renamed may be gone if its folder was not brought to the disk."""
    config, steps = deadly(6), list[str]()
    sync, replace, unlink = os.fsync, os.replace, Path.unlink

    def synced(number: int) -> None:
        steps.append(f"sync {Path(os.readlink(f'/proc/self/fd/{number}')).name}")
        sync(number)

    def replaced(source: Any, target: Any) -> None:
        steps.append(f"rename {Path(target).name}")
        replace(source, target)

    def unlinked(path: Path, missing_ok: bool = False) -> None:
        steps.append(f"remove {path.name}")
        unlink(path, missing_ok)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", replaced)
    monkeypatch.setattr(Path, "unlink", unlinked)
    run_sweep(config, tmp_path / "a", backend="serial")
    part, table = "part-000000.parquet", "samples.parquet"
    assert steps == [
        "sync a", f"sync {tmp_path.name}", "sync sweep.json.tmp", "rename sweep.json", "sync a",
        f"sync {part}.tmp", f"rename {part}", "sync parts",
        f"sync {table}.tmp", f"rename {table}", "sync a", f"remove {part}",
    ]  # fmt: skip


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("mine")
    with pytest.raises(ProblemError, match="is not empty and no sweep's folder"):
        run_sweep(deadly(), tmp_path, backend="serial")
    with pytest.raises(ProblemError, match=r"cannot write to .*thesis.txt"):
        run_sweep(deadly(), tmp_path / "thesis.txt", backend="serial")
    assert [p.name for p in tmp_path.iterdir()] == ["thesis.txt"]


def test_two_drivers_do_not_share_a_folder(tmp_path: Path) -> None:
    with (
        Store(tmp_path / "a", deadly()),
        pytest.raises(ProblemError, match=r"another sweep is writing to .*: wait for it or end it"),
    ):
        run_sweep(deadly(), tmp_path / "a", backend="serial")
    assert run_sweep(deadly(), tmp_path / "a", backend="serial").table.num_rows == 20


@pytest.mark.parametrize("damage", ["cut", "empty", "flipped", "text"])
def test_a_damaged_part_is_put_aside_and_its_samples_run_again(damage: str, tmp_path: Path) -> None:
    config = deadly(20)
    partly_done(tmp_path / "a", config, range(5), range(5, 12))
    part = tmp_path / "a" / "parts" / "part-000001.parquet"
    data = bytearray(part.read_bytes())
    middle = data.index(b"done")  # in a page of the status column
    data[middle] ^= 0xFF
    part.write_bytes({"cut": data[: len(data) // 2], "empty": b"", "flipped": data, "text": b"rows"}[damage])
    result = run_sweep(config, tmp_path / "a", backend="serial")
    (note,) = result.notes
    assert "part-000001.parquet cannot be read" in note
    assert part.with_name("part-000001.parquet.unreadable").exists()
    assert result.resumed == 5
    assert result.table.drop_columns(["wall_time"]).equals(whole(config, tmp_path / "b"))


def test_what_a_killed_driver_left_half_written_is_removed(tmp_path: Path) -> None:
    config = deadly(20)
    partly_done(tmp_path / "a", config, range(5))
    left = [tmp_path / "a" / "parts" / "part-000001.parquet.tmp", tmp_path / "a" / "samples.parquet.tmp"]
    for file in left:
        file.write_bytes(b"PAR1")
    assert run_sweep(config, tmp_path / "a", backend="serial").resumed == 5
    assert not any(file.exists() for file in left)


def test_rows_of_another_sweep_are_refused(tmp_path: Path) -> None:
    for name, seed in (("a", 0), ("b", 1)):
        partly_done(tmp_path / name, deadly(20, seed=seed), range(5))
    part = tmp_path / "b" / "parts" / "part-000000.parquet"
    part.rename(tmp_path / "a" / "parts" / "part-000001.parquet")
    with pytest.raises(ProblemError, match=r"part-000001.parquet is not of this sweep"):
        run_sweep(deadly(20), tmp_path / "a", backend="serial")


def test_samples_drawn_otherwise_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    partly_done(tmp_path / "a", deadly(20), range(5))
    from surefoot.sweep.space import Space

    points = Space._points
    monkeypatch.setattr(Space, "_points", lambda *a: 0.5 * points(*a))
    with pytest.raises(ProblemError, match="sample 0 was drawn otherwise"):
        run_sweep(deadly(20), tmp_path / "a", backend="serial")


def test_a_full_disk_is_told_and_what_was_written_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, replace = deadly(20), os.replace
    partly_done(tmp_path / "a", config, range(5))

    def full(source: Any, target: Any) -> None:
        if "part-" in str(target):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(WriteError, match=r"cannot write .*part-000001.parquet: No space left on device"):
        run_sweep(config, tmp_path / "a", backend="serial")
    monkeypatch.undo()
    assert [p.name for p in (tmp_path / "a" / "parts").iterdir()] == ["part-000000.parquet"]
    assert run_sweep(config, tmp_path / "a", backend="serial").resumed == 5


def test_the_folder_says_what_it_is_of(tmp_path: Path) -> None:
    config = deadly(3)
    path = run_sweep(config, tmp_path / "a", backend="serial").path
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    assert table.schema.names == ["index", "mu", "status", "error", "survived", "twice", "wall_time"]
    assert table.schema.metadata[b"surefoot.sweep"].decode() == config.fingerprint()
    assert json.loads((tmp_path / "a" / "sweep.json").read_text())["ranges"]["mu"]["high"] == 1.0
    (tmp_path / "a" / "sweep.json").write_text("{")
    with pytest.raises(ProblemError, match=r"sweep.json cannot be read"):
        run_sweep(config, tmp_path / "a", backend="serial")
