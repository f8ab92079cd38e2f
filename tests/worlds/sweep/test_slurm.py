"""A sweep as a job array: the job file as Slurm reads and runs it, what merges, the container's recipe."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from surefoot.base.errors import ProblemError
from surefoot.worlds.sweep import merge_sweep, read_sweep, run_sweep

pytest.importorskip("pyarrow", reason="tables are written by pyarrow: pip install -e '.[sweep]'")
ROOT = Path(__file__).resolve().parents[3]
SLURM = ROOT / "examples" / "slurm"
DIRECTIVES = {
    "job-name": r"[\w-]+", "array": r"\d+-\d+", "nodes": r"\d+", "ntasks": r"\d+", "cpus-per-task": r"\d+",
    "mem": r"\d+[KMGT]", "time": r"(\d+-)?\d\d:\d\d:\d\d", "signal": r"B:TERM@\d+", "requeue": r"",
    "output": r"\S+%A_%a\S*",
}  # fmt: skip
"""Options of sbatch (its manual, Slurm 24.05) as the job file uses them, and what their values look like."""
BALLS = """
experiment: drop
samples: 11
settings: {body: ball, dt: 0.01, duration: 0.1}
ranges: {mu: [0.1, 1.0], terrain: [flat, "slope:10"]}
"""


def test_sbatch_reads_the_job_file() -> None:
    first, *lines = (SLURM / "sweep.sbatch").read_text().splitlines()
    assert first == "#!/bin/bash"  # sbatch refuses a file without an interpreter
    asked = [line for line in lines if line.startswith("#SBATCH")]
    commands = [k for k, line in enumerate(lines) if line and not line.startswith("#")]
    assert max(k for k, line in enumerate(lines) if line in asked) < commands[0]  # later ones are ignored
    for line in asked:
        option, _, value = line.removeprefix("#SBATCH --").partition("=")
        assert re.fullmatch(DIRECTIVES[option], value), line


@pytest.mark.long
def test_tasks_of_an_array_run_parts_that_merge(tmp_path: Path) -> None:
    file = tmp_path / "balls.yaml"
    file.write_text(BALLS)
    told = {"SUREFOOT": f"{sys.executable} -m surefoot", "SLURM_CPUS_PER_TASK": "1"}
    for task in (2, 0, 1):
        words = [
            "bash",
            str(SLURM / "sweep.sbatch"),
            str(file),
            str(tmp_path / "parts"),
            "3",
            "--backend",
            "serial",
        ]
        subprocess.run(words, env={**os.environ, **told, "SLURM_ARRAY_TASK_ID": str(task)}, check=True)
    config = read_sweep(file)
    merged = merge_sweep(config, tmp_path / "whole", [tmp_path / "parts"])
    alone = run_sweep(config, tmp_path / "alone", backend="serial")
    assert merged.table.drop_columns(["wall_time"]).equals(alone.table.drop_columns(["wall_time"]))
    again = merge_sweep(config, tmp_path / "whole", [tmp_path / "parts" / "part-1", tmp_path / "alone"])
    assert again.table.equals(merged.table)  # what is there stays
    with pytest.raises(ProblemError, match=r"part-0 holds another sweep \(seed is 0 there, 7 here\)"):
        merge_sweep(config.with_numbers(None, 7), tmp_path / "other", [tmp_path / "parts"])
    with pytest.raises(ProblemError, match="is no sweep's folder and holds none"):
        merge_sweep(config, tmp_path / "whole", [tmp_path / "nowhere"])
    with pytest.raises(ProblemError, match="k < n"):
        run_sweep(config, tmp_path / "whole", part=(3, 3))


def test_the_container_holds_what_its_recipe_installs() -> None:
    sections: dict[str, list[str]] = {}
    name = "head"
    for line in (SLURM / "surefoot.def").read_text().splitlines():
        name = line[1:] if line.startswith("%") else name
        sections.setdefault(name, []).append(line.strip())
    assert {"Bootstrap: docker", "From: python:3.11-slim"} <= set(sections["head"])
    for line in filter(None, sections["files"][1:]):
        assert (ROOT / line.split()[0]).exists(), line
    extras = re.search(r"\[(.+?)\]", "".join(sections["post"]))
    assert extras is not None
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(extras[1].split(",")) <= set(project["optional-dependencies"])
    for name in ("post", "environment", "runscript", "test"):
        subprocess.run(["bash", "-n"], input="\n".join(sections[name][1:]), text=True, check=True)
