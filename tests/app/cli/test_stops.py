"""Runs that end before their time: signals, a full disk, a world that cannot go on."""

from __future__ import annotations

import ctypes
import errno
import json
import os
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
import typer

from surefoot.app.cli import signals
from surefoot.app.cli.main import main
from surefoot.app.cli.signals import ends_softly
from surefoot.base.compilation import clock
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
@pytest.mark.sampled(2)
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


def test_a_signal_before_the_first_step_leaves_no_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    at_step(monkeypatch, 1, lambda: os.kill(os.getpid(), signal.SIGTERM))
    assert main([*WALK, str(tmp_path / "new" / "runs")]) == 143
    assert capfd.readouterr().err.strip() == "terminated"
    assert list(tmp_path.iterdir()) == []


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


def ended_by(run: Callable[[], object]) -> int:
    """Return the exit code with which a signal ends what runs."""
    with pytest.raises(typer.Exit) as found, ends_softly():
        run()
    return found.value.exit_code


def nap(seconds: float) -> None:
    """Let the time pass in many short sleeps."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.002)


def test_a_signal_whose_exception_c_swallows_comes_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """LLVM calls Python's functions while it compiles: what these raise goes nowhere."""
    monkeypatch.setattr(signals, "AGAIN", 0.5)  # after the next line, on a busy machine too

    @ctypes.CFUNCTYPE(None)
    def called_by_c() -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        nap(0.01)

    passed = []
    assert ended_by(lambda: (called_by_c(), passed.append("swallowed"), nap(30.0))) == 143
    assert passed == ["swallowed"]


def test_a_signal_that_comes_while_the_swallowed_one_is_heard_of_is_not_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine the second one may come so early, where C swallows it as well."""
    send_again, sent = signals.EndSignal.send_again, []

    def send_and_wait(self: signals.EndSignal) -> None:
        send_again(self)
        sent.append(self.number)
        if len(sent) < 4:
            nap(0.1)

    @ctypes.CFUNCTYPE(None)
    def called_by_c() -> None:
        os.kill(os.getpid(), signal.SIGTERM)
        nap(0.01)

    monkeypatch.setattr(signals.EndSignal, "send_again", send_and_wait)
    assert ended_by(lambda: (called_by_c(), nap(30.0))) == 143
    assert len(sent) >= 2


def test_a_signal_while_a_kernel_compiles_waits_for_it() -> None:
    done = []

    def compile_one() -> None:
        clock._compiling.start()
        try:
            os.kill(os.getpid(), signal.SIGTERM)
            nap(0.01)
            done.append("compiled")
        finally:
            clock._compiling.end()
        done.append("too far")

    assert ended_by(compile_one) == 143
    assert done == ["compiled"]


def compile_for(seconds: float, seed: int) -> None:
    """Compile kernels that nobody has compiled before."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        scope: dict[str, Any] = {}
        exec(f"def kernel(x):\n    y = x + {seed}.0\n    return (y * y).sum()", scope)
        numba.njit(scope["kernel"])(np.ones(3))


@pytest.mark.long
def test_no_signal_is_lost_in_eighty_cold_compiles() -> None:
    random = np.random.default_rng(5)
    for seed in range(80):
        timer = threading.Timer(random.uniform(0.0, 0.4), os.kill, (os.getpid(), signal.SIGTERM))
        assert ended_by(lambda: (timer.start(), compile_for(30.0, seed))) == 143  # noqa: B023
