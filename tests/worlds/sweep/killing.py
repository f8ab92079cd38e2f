"""Kill a sweep's driver or one of its workers at random, again and again, until it has ended all the same."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

DROPS = {
    "experiment": "drop",
    "samples": 2000,
    "seed": 11,
    "settings": {"body": "ball", "height": 0.02, "dt": 0.01, "duration": 0.3},
    "ranges": {"mu": [0.1, 1.0], "restitution": [0.0, 0.6], "slope": [0, 30], "mass": [0.5, 2.0]},
}
"""A sweep of 2,000 drops that takes a few seconds."""
DRIVER = """
import json, sys
from surefoot.worlds.sweep import run_sweep, sweep_from_dict
content, folder, backend, address = json.loads(sys.argv[1])
run_sweep(sweep_from_dict(content), folder, backend=backend, workers=2, address=address)
"""


def start(folder: Path, backend: str, address: str | None) -> subprocess.Popen[bytes]:
    """Start a driver of the sweep of `DROPS`."""
    told = json.dumps([DROPS, str(folder), backend, address])
    return subprocess.Popen([sys.executable, "-c", DRIVER, told])


def children(parent: int) -> list[int]:
    """Return the processes that a process has started."""
    out = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                after = (entry / "stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            if int(after[1]) == parent and after[0] != "Z":
                out.append(int(entry.name))
    return out


def loky_workers(driver: int) -> list[int]:
    """Return a driver's loky workers."""
    return [p for p in children(driver) if "loky" in _command(p) and "resource_tracker" not in _command(p)]


def ray_workers(_driver: int) -> list[int]:
    """Return the Ray workers of this machine that are at work on a chunk."""
    pids = [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit()]
    return [p for p in pids if _command(p).startswith("ray::run_chunk")]


def _command(pid: int) -> str:
    try:
        return (Path("/proc") / str(pid) / "cmdline").read_bytes().replace(b"\0", b" ").decode()
    except OSError:
        return ""


def run_and_kill(
    folder: Path, backend: str, seed: int, kills: int = 5, address: str | None = None
) -> dict[str, int]:
    """Run the sweep to its end through SIGKILLs at random moments; return how many hit whom."""
    chance, hits = random.Random(seed), {"driver": 0, "worker": 0}
    workers = ray_workers if backend == "ray" else loky_workers
    process, deadline = start(folder, backend, address), time.monotonic() + 300.0
    try:
        while sum(hits.values()) < kills:
            assert time.monotonic() < deadline, f"too slow, hits so far: {hits}"
            assert process.poll() is None, f"ended with {process.returncode} before all kills, hits: {hits}"
            at_work = workers(process.pid)
            if not at_work:
                time.sleep(0.01)
                continue
            time.sleep(chance.uniform(0.05, 0.6))
            target = "driver" if sum(hits.values()) % 2 == 0 else "worker"
            victim = process.pid if target == "driver" else chance.choice(at_work)
            try:
                os.kill(victim, signal.SIGKILL)
            except ProcessLookupError:
                continue
            hits[target] += 1
            if target == "driver":
                process.wait()
                process = start(folder, backend, address)
        assert process.wait(timeout=max(1.0, deadline - time.monotonic())) == 0
    finally:
        process.kill()
        process.wait()
    return hits
