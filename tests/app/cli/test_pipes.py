"""What the shell does to a command's streams: closed outputs, readers that leave, narrow screens, devices."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.text_files import parse_yaml, read_text

STANCES = Path(__file__).parents[3] / "examples" / "stances"
POSSIBLE = f"check {STANCES / 'chimney.yaml'} --no-picture"


def shell(line: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a line of the shell, in which "surefoot" is this checkout's."""
    command = f"{sys.executable} -m surefoot"
    return subprocess.run(
        ["bash", "-o", "pipefail", "-c", line.replace("surefoot ", f"{command} ", 1)],
        capture_output=True, text=True, timeout=120, env={**os.environ, **variables},
    )  # fmt: skip


@pytest.mark.parametrize("output", [">&-", "2>&-", "| true", "--json | true"])
@pytest.mark.sampled(2)
def test_closed_outputs_change_no_exit_code(output: str) -> None:
    done = shell(f"surefoot {POSSIBLE} {output}")
    assert done.returncode == 0
    assert "rror" not in done.stderr  # what is compiled is told there


@pytest.mark.parametrize("command", [POSSIBLE, "--version"])
def test_a_full_disk_is_one_line(command: str) -> None:
    done = shell(f"surefoot {command} > /dev/full", PYTHONUNBUFFERED="")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("columns", ["0", pytest.param("60", marks=pytest.mark.long), "45", "many"])
def test_narrow_screens_cut_no_names(columns: str) -> None:
    printed = shell(f"surefoot {POSSIBLE}", COLUMNS=columns).stdout
    cells = [line.split("│") for line in printed.splitlines() if line.startswith("│")]
    names = "".join(cell[1].strip() for cell in cells if len(cell) == 9)
    assert "lefthigh" in names.replace(" ", ""), printed


def test_a_stance_is_read_from_the_standard_input() -> None:
    done = shell(f"surefoot check - --no-picture --json < {STANCES / 'chimney.yaml'}")
    assert done.returncode == 0, done.stderr
    assert '"possible": true' in done.stdout


@pytest.mark.parametrize("device", ["/dev/full", "/dev/zero"])
def test_a_device_without_an_end_is_refused(device: str, printed: Any) -> None:
    assert "longer than 64 MB" in printed("check", device, code=2)


@pytest.mark.parametrize("text", ["a: 1\na: 2\n", "b:\n  - {x: 1, x: 1}\n", "b: &k {x: 1, x: 2}\nc: *k\n"])
def test_a_key_that_stands_twice_is_refused(text: str) -> None:
    with pytest.raises(ProblemError, match="stands twice"):
        parse_yaml(text, "file")
    assert parse_yaml("a: &k {x: 1}\nb: *k\n", "file") == {"a": {"x": 1}, "b": {"x": 1}}


def test_what_is_no_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ProblemError, match="not text"):
        read_text(tmp_path / "file")
