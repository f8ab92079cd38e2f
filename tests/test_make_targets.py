"""Every target of the Makefile is run, with programs of its environment that write down their calls."""

from __future__ import annotations

import importlib.util
import os
import re
import runpy
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8") if (ROOT / "Makefile").exists() else ""
TARGETS = re.findall(r"^([a-z-]+):(?!=)", MAKEFILE, re.MULTILINE)
PROGRAMS = ("python", "surefoot", "ruff", "mypy", "lint-imports")
RECORDER = '#!/bin/sh\necho "$(basename "$0") $*" >> "$CALLS"\n'

pytestmark = pytest.mark.skipif(
    shutil.which("make") is None or not MAKEFILE, reason="make is needed, and a checkout"
)


def calls(folder: Path, target: str, *variables: str) -> list[list[str]]:
    """Run a target of a copy of the Makefile whose environment only writes down; return the calls."""
    shutil.copy(ROOT / "Makefile", folder)
    for name in ("pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, folder)
    bin_folder = folder / ".venv" / "bin"
    bin_folder.mkdir(parents=True)
    for name in PROGRAMS:
        (bin_folder / name).write_text(RECORDER, encoding="utf-8")
        (bin_folder / name).chmod(0o755)
    log = folder / "calls"
    log.touch()
    environment = {**os.environ, "CALLS": str(log), "MAKEFLAGS": ""}
    done = subprocess.run(
        ["make", "--no-print-directory", target, *variables],
        cwd=folder, env=environment, check=False, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return [line.split() for line in log.read_text(encoding="utf-8").splitlines()]


def fault(call: list[str]) -> str:
    """Return what is wrong with a call of a program; empty where it is one."""
    program, *words = call
    if program == "surefoot":
        return str(runpy.run_path(str(ROOT / "docs" / "check.py"), run_name="check")["parse"](words) or "")
    if program == "python" and words[0] == "-m":
        module = words[1]
        if importlib.util.find_spec(module.partition(".")[0]) is None and module != "pip":
            return f"no module {module}"
        if "." in module and not (ROOT / Path(*module.split("."))).with_suffix("").parent.is_dir():
            return f"no module {module}"
        if module == "pip":
            extras = [
                name for names in re.findall(r"\.\[([\w,]+)\]", " ".join(words)) for name in names.split(",")
            ]
            known = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
            return "".join(
                f"no extra {name} " for name in extras if name not in known["optional-dependencies"]
            )
    files = [word for word in words if word.startswith(("tests/", "docs/"))]
    return "".join(f"no file {name} " for name in files if not (ROOT / name).exists())


def test_every_target_is_named_and_explained() -> None:
    phony = MAKEFILE.partition(".PHONY:")[2].partition("\n")[0].split()
    assert sorted(phony) == sorted(TARGETS)
    assert {"help", "stand", "test", "bench", "docs", "clean"} <= {*TARGETS}


@pytest.mark.parametrize("target", TARGETS)
def test_a_target_runs(target: str, tmp_path: Path) -> None:
    made = calls(tmp_path, target, *(["QUICK=--quick"] if target == "bench" else []))
    assert [fault(call) for call in made] == [""] * len(made)
    assert bool(made) == (target not in ("help", "clean"))
    assert (tmp_path / ".venv").exists() == (target != "clean")


def test_a_bench_in_earnest_sets_the_tables_anew(tmp_path: Path) -> None:
    made = calls(tmp_path, "bench")
    assert ["python", "-m", "docs.tables"] in made
    assert not any("--quick" in call for call in made)
    (tmp_path / "quick").mkdir()
    quick = [call for call in calls(tmp_path / "quick", "bench", "QUICK=--quick") if call[0] == "surefoot"]
    assert all("--quick" in call for call in quick)
    assert len(quick) >= 7
