"""Runs that end before their time: signals, a full disk, a world that cannot go on."""

from __future__ import annotations

import errno
import json
import os
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from surefoot.app.cli.main import main
from surefoot.base.errors import SimulationError
from surefoot.records.log import part_files, recorder
from surefoot.records.log.reading import read_log
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld

STAND = ["stand", "--duration", "1", "--no-video", "--out"]
WALK = ["walk", "--duration", "1", "--no-video", "--no-report", "--out"]


def at_step(monkeypatch: pytest.MonkeyPatch, number: int, action: Any) -> None:
    """Let something happen in a step of the world."""
    original, steps = MujocoWorld.step, 0

    def step(self: MujocoWorld, *arguments: Any) -> None:
        nonlocal steps
        steps += 1
        if steps == number:
            action()
        original(self, *arguments)

    monkeypatch.setattr(MujocoWorld, "step", step)


@pytest.mark.parametrize("command", [STAND, WALK], ids=["stand", "walk"])
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_ends_a_run_as_ctrl_c_does(
    command: list[str], number: signal.Signals, code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at_step(monkeypatch, 150, lambda: os.kill(os.getpid(), number))
    before = signal.getsignal(number)
    assert main([*command, str(tmp_path), "--json"]) == code
    assert signal.getsignal(number) is before
    (folder,) = tmp_path.iterdir()
    assert 100 < len(read_log(folder / "log.npz")) < 150
    assert json.loads((folder / "summary.json").read_text())["outcome"] == "interrupted"
    assert not (folder / "log.parts").exists()


def test_a_signal_before_the_first_step_leaves_no_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    at_step(monkeypatch, 1, lambda: os.kill(os.getpid(), signal.SIGTERM))
    assert main([*WALK, str(tmp_path)]) == 143
    assert capfd.readouterr().err.strip() == "terminated"
    (folder,) = tmp_path.iterdir()
    assert list(folder.iterdir()) == []


def test_a_disk_that_fills_up_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    original = part_files._write_at

    def write(file: Any, offset: int, data: Any) -> None:
        if offset > part_files.HEADER_BYTES:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        original(file, offset, data)

    def savez(file: Any, **arrays: Any) -> None:
        file.write(b"PK")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(part_files, "_write_at", write)
    monkeypatch.setattr(recorder, "CHUNK_BYTES", 300_000)
    monkeypatch.setattr(recorder, "HELD_BACK", 0.5)
    monkeypatch.setattr(np, "savez_compressed", savez)
    assert main([*STAND, str(tmp_path), "--json"]) == 1
    out = capfd.readouterr()
    assert out.err == ""
    summary = json.loads(out.out)
    (folder,) = tmp_path.iterdir()
    assert summary["outcome"] == "stopped"
    assert summary["error"] == f"cannot write {folder / 'log.parts'}: No space left on device"
    rows = folder / "log.parts"
    assert summary["unwritten"] == [
        f"cannot write {folder / 'log.npz'}: No space left on device; its rows are in {rows}"
    ]
    assert not (folder / "log.npz").exists()
    kept = read_log(rows)
    assert 100 < len(kept) < summary["duration"] / kept.facts["dt"] < 900
    np.testing.assert_allclose(kept["forces"][100:].sum(axis=1)[:, 2], summary["mass"] * 9.81, rtol=0.05)


@pytest.mark.parametrize("command", [STAND, WALK], ids=["stand", "walk"])
def test_a_world_that_cannot_go_on_ends_the_run(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def fail() -> None:
        raise SimulationError("motion", 0.12, 1e-3, "FL_calf_joint", 1e9)

    at_step(monkeypatch, 120, fail)
    assert main([*command, str(tmp_path)]) == 1
    out = capfd.readouterr()
    assert out.err == ""
    (line,) = [text for text in out.out.splitlines() if "was lost" in text]
    assert "at 0.12 s the motion became non-finite" in line
    (folder,) = tmp_path.iterdir()
    log = read_log(folder / "log.npz")
    assert 100 < len(log) < 120
    assert log.facts["outcome"] == "invalid"
    assert log.facts["error"] in line
