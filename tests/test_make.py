"""What make installs for standing, and that a machine that judges a change runs every test, and each once."""

from __future__ import annotations

import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from tests.app.cli.test_shown_commands import all_shown, same_run

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]

pytestmark = pytest.mark.skipif(
    shutil.which("make") is None or not (ROOT / "Makefile").exists(), reason="make is needed"
)


def planned(*targets: str) -> list[str]:
    """Return the commands that make would run in a checkout without an environment."""
    command = ["make", "--dry-run", "VENV=.no-such-environment", *targets]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()


def installed(lines: list[str]) -> set[str]:
    """Return the packages that the commands install, by the extras that they name."""
    names, todo = set[str](), [name for line in lines for name in re.findall(r"'\.\[([\w,]+)\]'", line)]
    for extras in todo:
        for requirement in (Requirement(text) for extra in extras.split(",") for text in EXTRAS[extra]):
            names.add(requirement.name)
            todo += requirement.extras if requirement.name == "surefoot" else []
    return names


def test_standing_installs_what_standing_needs() -> None:
    names = installed(planned("stand"))
    assert {"pin", "mujoco", "matplotlib"} <= names
    assert not names & {"jax", "casadi", "pyarrow", "scs", "pytest", "viser"}
    assert {"jax", "casadi", "pytest"} <= installed(planned("test"))


def test_nothing_is_installed_in_silence() -> None:
    assert [line for line in planned("stand") if "pip install" in line and "quiet" not in line]


def bench_commands() -> list[list[str]]:
    lines = planned("bench", "QUICK=--quick")
    return [shlex.split(line)[1:] for line in lines if "/bin/surefoot" in line.split(" ")[0]]


def test_the_benches_of_make_are_commands() -> None:
    parse = runpy.run_path(str(ROOT / "docs" / "check.py"), run_name="check")["parse"]
    assert len(bench_commands()) >= 7
    assert [parse(words) for words in bench_commands()] == [None] * len(bench_commands())
    assert not any("docs.tables" in line for line in planned("bench", "QUICK=--quick"))
    assert any("docs.tables" in line for line in planned("bench"))


@pytest.mark.long
def test_the_benches_of_make_run(tmp_path: Path) -> None:
    """Those that a page shows, too, are run with the other shown commands."""
    shown = {same_run(one.values[0]) for one in all_shown()}
    left = [words for words in bench_commands() if same_run(tuple(words)) not in shown]
    assert len(left) < len(bench_commands())
    for words in left:
        command = [sys.executable, "-m", "surefoot", *words]
        assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0, words


def test_every_test_runs_once() -> None:
    def chosen(*targets: str) -> list[str]:
        return [line.split("-m pytest")[1] for line in planned(*targets) if "-m pytest" in line]

    assert len(chosen("test")) == 1
    assert chosen("test")[0].endswith('-m "not long"')
    both = chosen("test", "test-all")
    assert both == [*chosen("test"), chosen("test")[0].replace('"not long"', "long")]
    assert "make test test-all" in (ROOT / ".ci/run").read_text(encoding="utf-8")
