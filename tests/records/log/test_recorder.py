from __future__ import annotations

import errno
import os
import subprocess
import sys
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.base.errors import ProblemError, WriteError
from surefoot.records.log import CHANNELS, Log, npz, part_files
from surefoot.records.log import recorder as recorder_module
from surefoot.records.log.channels import Channel
from surefoot.records.log.reading import read_log
from surefoot.records.log.recorder import CHUNK_BYTES, Recorder

ROWS = [CHANNELS[name].sized(nq=19, p=4) for name in ("time", "q", "forces", "active", "grasp_map")]
NAMES = [channel.name for channel in ROWS]
ROW_BYTES = 8 * (1 + 19 + 12 + 72) + 4
CHUNK = CHUNK_BYTES // ROW_BYTES


def values(k: int) -> dict[str, Any]:
    return {
        "time": 1e-3 * k,
        "q": np.arange(19) + k,
        "forces": np.full((4, 3), -k),
        "active": np.arange(4) == k % 4,
        "grasp_map": np.full((6, 12), 0.5 * k),
    }


def fill(recorder: Recorder, count: int) -> None:
    for _ in range(count):
        at, row = recorder.slot(), values(recorder.count)
        for name, value in row.items():
            recorder.arrays[name][at] = value
        recorder.count += 1


def check(log: Log, count: int) -> None:
    assert len(log) == count
    for k in (0, count // 3, CHUNK - 1, CHUNK, count - 1):
        if k < count:
            for name, value in values(k).items():
                np.testing.assert_array_equal(log[name][k], value)
    assert {name: len(array) for name, array in log.arrays.items()} == dict.fromkeys(NAMES, count)


def written(rows: list[list[Any]], channels: list[Channel], folder: Path | None = None) -> Log:
    recorder = Recorder(len(rows), channels, folder)
    for row in rows:
        recorder.write(row)
    return recorder.finish({})


def test_a_row_that_is_written_at_once_is_what_is_assigned(tmp_path: Path) -> None:
    """Plain arrays, and all else that NumPy assigns: lists, integers, other orders in memory, broadcasts."""
    random = np.random.default_rng(2)
    channels = [CHANNELS[n].sized(nq=19, p=4) for n in ("time", "q", "attained", "forces", "active", "mu")]
    plain = [
        [0.1 * k, random.normal(size=19), k % 2 == 0, random.normal(size=(4, 3)), random.random(4) < 0.5, 0.6]
        for k in range(3)
    ]
    odd = [
        [1, np.arange(19), 1, random.normal(size=(3, 4)).T, [True, False, True, True], np.float64(0.5)],
        [np.float32(2.5), 7.0, np.True_, np.arange(3.0), np.arange(4) - 1, 1],
        [0.3, np.float32(np.arange(19)), False, random.normal(size=(8, 3))[::2], True, np.array(0.4)],
    ]
    rows = [plain[0], *odd, *plain[1:]]
    for folder in (None, tmp_path / "parts"):
        log = written(rows, channels, folder)
        for k, row in enumerate(rows):
            for channel, value in zip(channels, row, strict=True):
                wanted = np.zeros(channel.row_shape, channel.dtype)
                wanted[...] = value
                np.testing.assert_array_equal(log[channel.name][k], wanted)
                assert log[channel.name].dtype == channel.dtype


def test_a_row_that_does_not_fit_is_none(tmp_path: Path) -> None:
    row = [0.0, np.zeros(19), np.zeros((4, 3)), np.zeros(4, dtype=bool), np.zeros((6, 12))]
    recorder = Recorder(10, ROWS)
    with pytest.raises(ValueError, match="shape"):
        recorder.write([*row[:2], np.zeros((3, 4)), *row[3:]])
    recorder.write(row)
    for wrong in (np.zeros((5, 3)), np.zeros(12)):
        with pytest.raises(ValueError, match="shape"):
            recorder.write([*row[:2], wrong, *row[3:]])
    assert recorder.count == 1


@pytest.mark.parametrize("count", [1, CHUNK, CHUNK + 1, 2 * CHUNK, 3 * CHUNK + 7])
def test_streamed_rows_come_back(count: int, tmp_path: Path) -> None:
    recorder = Recorder(count, ROWS, tmp_path / "parts", {"robot": "box"})
    fill(recorder, count)
    log = recorder.finish({"outcome": "done"})
    check(log, count)
    assert log.facts == {"robot": "box", "outcome": "done"}
    again = read_log(tmp_path / "parts")
    check(again, count)
    assert again.facts == log.facts
    path = log.save(tmp_path / "log.npz")
    assert not (tmp_path / "parts").exists()
    check(read_log(path), count)
    check(log, count)


@pytest.mark.parametrize("streamed", [True, False])
def test_a_long_log_is_mapped_and_saved_the_same(
    streamed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in (npz, recorder_module):
        monkeypatch.setattr(module, "MEMORY", 2 * CHUNK_BYTES)
    count = 5 * CHUNK + 3
    recorder = Recorder(count, ROWS, tmp_path / "parts" if streamed else None)
    fill(recorder, count)
    log = recorder.finish({})
    assert isinstance(log["q"], np.memmap)
    check(log, count)
    again = read_log(log.save(tmp_path / "log.npz"))
    assert isinstance(again["q"], np.memmap)
    check(again, count)
    pieces = list(again.chunks(1000))
    assert sum(map(len, pieces)) == count
    np.testing.assert_array_equal(np.concatenate([p["q"] for p in pieces]), log["q"])


def test_memory_does_not_grow_with_the_run(tmp_path: Path) -> None:
    recorder = Recorder(10**9, ROWS, tmp_path / "parts")
    fill(recorder, 10)
    tracemalloc.start()
    try:
        fill(recorder, 20 * CHUNK)
        assert tracemalloc.get_traced_memory()[1] < 0.1 * CHUNK_BYTES
    finally:
        tracemalloc.stop()
        recorder.abandon()
    assert len(read_log(tmp_path / "parts")) == 20 * CHUNK + 10


def test_a_run_without_a_row_leaves_nothing(tmp_path: Path) -> None:
    Recorder(10, ROWS, tmp_path / "parts").abandon()
    assert not (tmp_path / "parts").exists()


def test_nothing_that_exists_is_touched(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "q.npy").write_text("mine")
    with pytest.raises(ProblemError, match="parts exists already"):
        Recorder(10, ROWS, tmp_path / "parts")
    assert (tmp_path / "parts" / "q.npy").read_text() == "mine"
    recorder = Recorder(10, ROWS, tmp_path / "run")
    fill(recorder, 3)
    (tmp_path / "run" / "notes.txt").write_text("mine")
    (tmp_path / "log.npz").write_text("mine")
    log = recorder.finish({})
    with pytest.raises(ProblemError, match=r"log.npz exists already"):
        log.save(tmp_path / "log.npz")
    assert (tmp_path / "log.npz").read_text() == "mine"
    log.save(tmp_path / "other.npz")
    assert [p.name for p in (tmp_path / "run").iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("call", range(11, 21))
def test_an_interrupted_write_is_made_again(
    call: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original, calls = part_files._write_at, 0

    def write(file: Any, offset: int, data: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == call:
            original(file, offset, data[: len(data) // 2])
            raise KeyboardInterrupt
        original(file, offset, data)

    recorder = Recorder(10**6, ROWS, tmp_path / "parts")
    fill(recorder, CHUNK)
    monkeypatch.setattr(part_files, "_write_at", write)
    calls = 10
    with pytest.raises(KeyboardInterrupt):
        fill(recorder, 1)
    check(recorder.finish({}), CHUNK)


def test_a_full_disk_keeps_what_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    original, room = part_files._write_at, 3 * CHUNK * 8 * 72

    def write(file: Any, offset: int, data: Any) -> None:
        if offset + len(data) > room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        original(file, offset, data)

    monkeypatch.setattr(part_files, "_write_at", write)
    recorder = Recorder(10**6, ROWS, tmp_path / "parts", {"outcome": "interrupted"})
    with pytest.raises(WriteError, match=r"cannot write .*parts: No space left on device"):
        fill(recorder, 9 * CHUNK)
    count = recorder.count
    assert count == 3 * CHUNK
    check(recorder.finish({"outcome": "stopped"}), count)  # a small one still has all of it
    check(read_log(tmp_path / "parts"), 2 * CHUNK)


def test_a_killed_run_loses_a_tenth_of_a_second_at_most(tmp_path: Path) -> None:
    code = f"""
import os, signal
from pathlib import Path
import surefoot as sf
from surefoot.worlds.rigid.rigid_world import RigidWorld
world, steps = RigidWorld(sf.load_robot("go2")), 0
def drop(state):
    global steps
    steps += 1
    if steps == 177: os.kill(os.getpid(), signal.SIGKILL)
    return 0.0 * world.robot.effort_limits
sf.run(world, drop, sf.Scenario(2.0), folder=Path("{tmp_path}") / "parts")
"""
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ended.returncode == -9, ended.stderr
    log = read_log(tmp_path / "parts")
    assert 0.177 - 0.1 <= log["time"][-1] <= 0.177
    assert log.facts["robot"] == "go2"
    for name in log:  # plain files for everybody
        assert len(np.load(tmp_path / "parts" / f"{name}.npy")) == len(log)
