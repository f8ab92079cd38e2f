"""2,000 drops whose driver and workers are killed at random: the same 2,000 rows as undisturbed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from surefoot.worlds.sweep import run_sweep, sweep_from_dict
from tests.worlds.sweep.killing import DROPS, run_and_kill

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")
pytest.importorskip("joblib", reason="loky comes with joblib")
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="workers are found in /proc"),
    pytest.mark.xdist_group("sweep-kills"),
]
PORT = 6397


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return the rows of a sweep that nobody disturbs, sorted by index, without wall times."""
    result = run_sweep(sweep_from_dict(DROPS), tmp_path_factory.mktemp("undisturbed") / "a", workers=2)
    assert result.lost_workers == 0
    return result.table.drop_columns(["wall_time"])


def rows_of(folder: Path) -> Any:
    import pyarrow.parquet

    return pyarrow.parquet.read_table(folder / "samples.parquet").sort_by("index").drop_columns(["wall_time"])


@pytest.fixture
def two_ray_workers() -> Iterator[str]:
    """Start a Ray with two workers on this machine and return its address."""
    pytest.importorskip("ray", reason="Ray is an extra of its own: make test-extras")
    ray = [sys.executable, "-m", "ray.scripts.scripts"]
    # an environment of their own: the workers are to find the package as this process does
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    environment |= {"RAY_AUTH_MODE": "disabled", "RAY_USAGE_STATS_ENABLED": "0"}
    options = ["--num-cpus=2", "--include-dashboard=false", f"--port={PORT}"]
    head = subprocess.Popen(
        [*ray, "start", "--head", "--block", *options], env=environment, stdout=subprocess.DEVNULL
    )
    try:
        subprocess.run(
            [*ray, "health-check", "--address", f"127.0.0.1:{PORT}"], env=environment, timeout=60, check=False
        )
        yield f"127.0.0.1:{PORT}"
    finally:
        head.terminate()
        head.wait(timeout=60)


def test_killed_drivers_and_workers_change_nothing(tmp_path: Path, undisturbed: Any) -> None:
    hits = run_and_kill(tmp_path / "a", "loky", seed=1)
    assert hits["driver"] + hits["worker"] == 5
    found = rows_of(tmp_path / "a")
    assert found.num_rows == 2000
    assert found.equals(undisturbed)
    assert set(found["status"].to_pylist()) == {"done"}
    assert sorted(p.name for p in (tmp_path / "a").iterdir()) == ["samples.parquet", "sweep.sqlite"]


def test_on_two_ray_workers_as_well(
    tmp_path: Path, undisturbed: Any, two_ray_workers: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RAY_AUTH_MODE", "disabled")
    hits = run_and_kill(tmp_path / "a", "ray", seed=2, address=two_ray_workers)
    assert hits["driver"] + hits["worker"] == 5
    found = rows_of(tmp_path / "a")
    assert found.num_rows == 2000
    assert found.equals(undisturbed)
