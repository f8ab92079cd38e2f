"""Without optional packages: a verdict without its picture, or one line that names all that is missing."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli import extras
from surefoot.app.cli.main import main

STANCE = str(Path(__file__).parents[3] / "examples" / "stances" / "slope.yaml")


def hide(monkeypatch: pytest.MonkeyPatch, *modules: str) -> None:
    """Make the modules look as if they were not installed."""
    for module in modules:
        monkeypatch.setitem(sys.modules, module, None)


@pytest.mark.parametrize("arguments", [["check", STANCE], ["region", STANCE], ["cone"]], ids=lambda a: a[0])
def test_verdict_without_matplotlib(
    arguments: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    hide(monkeypatch, "matplotlib")
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    out = capfd.readouterr()
    assert "no picture: matplotlib is not installed; run: pip install -e '.[viz]'" in out.out
    assert out.err == ""
    assert not list(tmp_path.iterdir())
    assert main([*arguments, "--json", "--out", str(tmp_path)]) == 0
    facts = json.loads(capfd.readouterr().out)
    assert facts["picture"] is None
    assert "[viz]" in facts["note"]


def test_all_that_is_missing_is_named_at_once(
    tmp_path: Path, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    def absent(name: str) -> None:
        raise PackageNotFoundError(name)

    hide(monkeypatch, "pinocchio", "mujoco", "matplotlib", "imageio", "imageio_ffmpeg")
    monkeypatch.setattr(extras, "distribution", absent)
    for options, named, extra in (
        ([], "pin, example-robot-data, mujoco, imageio, imageio-ffmpeg and matplotlib", "robot,sim,viz"),
        (["--no-video"], "pin, example-robot-data, mujoco and matplotlib", "robot,sim,viz"),
        (["--no-video", "--no-report"], "pin, example-robot-data and mujoco", "robot,sim"),
        (["a.urdf", "--feet", "b", "--no-video", "--no-report"], "pin and mujoco", "robot,sim"),
    ):
        for command in ("stand", "walk"):
            line = f"surefoot: {named} are not installed; run: pip install -e '.[{extra}]'\n"
            assert printed(command, *options, "--out", tmp_path, code=2) == line
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_a_run_without_pictures_says_so_in_one_line(
    tmp_path: Path, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide(monkeypatch, "matplotlib", "imageio", "imageio_ffmpeg")
    for command, seconds in (("stand", "0.1"), ("walk", "0.5")):
        said = printed(command, "solo12", "--duration", seconds, "--out", tmp_path)
        assert said.count("pictures left out") == 1
        assert "matplotlib" in said
        assert "imageio-ffmpeg" in said
        assert "[sim,viz]" in said
    assert len(list(tmp_path.rglob("report.html"))) == 2


def test_a_full_disk_leaves_no_empty_picture(
    tmp_path: Path, printed: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.figure import Figure

    def full(figure: object, path: Path, **settings: object) -> None:
        path.write_bytes(b"")
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Figure, "savefig", full)
    said = printed("check", STANCE, "--out", tmp_path)
    assert "No space left on device" in said
    assert "picture: /" not in said
    assert "report: " in printed("stand", "solo12", "--duration", "0.2", "--no-video", "--out", tmp_path)
    assert not list(tmp_path.rglob("*.png"))


@pytest.mark.long
def test_a_home_that_cannot_be_written_is_no_chatter(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "surefoot", "cone", "--out", str(tmp_path)],
        env={
            **os.environ,
            "HOME": "/proc/none",
            "XDG_CACHE_HOME": "/proc/none",
            "XDG_CONFIG_HOME": "/proc/none",
        },
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert len(list(tmp_path.rglob("*.png"))) == 1


def test_a_robot_without_a_wire_needs_no_dds() -> None:
    code = "import sys; sys.modules['cyclonedds'] = None; import surefoot.worlds.running.motor_robot"
    subprocess.run([sys.executable, "-c", code], check=True)
