"""The window of live runs: one line without a screen, and what is told to MuJoCo's viewer."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from surefoot.app.cli.main import main
from surefoot.app.viz.window import ViewerWindow, check_display
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import quaternion_from_rotation, rotation_about
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems need no DISPLAY")
def test_without_a_screen_it_is_one_line(monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main(["walk", "go2", "--view"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert "needs a screen: neither DISPLAY nor WAYLAND_DISPLAY is set" in said.err


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="X11 alone looks for a display by name")
def test_a_screen_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":7919")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(ProblemError, match="--view cannot open a window"):
        check_display()


def test_what_the_viewer_is_told() -> None:
    robot, handle = load_robot("go2"), Mock(cam=SimpleNamespace(), lock=nullcontext)
    launch = Mock(return_value=handle)
    window = ViewerWindow(robot, FlatTerrain(), launch)
    keys: list[int] = []
    window.open(keys.append)
    launch.call_args.kwargs["key_callback"](265)
    assert keys == [265]
    assert window.model.body(handle.cam.trackbodyid).name == "base:0"
    q = robot.nominal.copy()
    q[:3] = (1.0, 2.0, 0.4)
    q[3:7] = quaternion_from_rotation(rotation_about(np.array([0.0, 0.0, 1.0]), 0.5))
    assert window.show(q, np.array([0.3, 0.0, -0.2]))
    assert window.data.body("base:0").xpos == pytest.approx([1.0, 2.0, 0.4])
    assert window.data.body("base:0").xmat.reshape(3, 3)[:2, 0] == pytest.approx([np.cos(0.5), np.sin(0.5)])
    handle.sync.assert_called_once_with()
    assert handle.set_texts.call_args.args[0][2] == "0.3 m/s forward, 0.0 left, -0.2 rad/s"
    handle.is_running.return_value = False
    assert not window.show(q, np.zeros(3))
    window.close()
    handle.close.assert_called_once_with()


@pytest.mark.long
def test_a_process_that_may_not_open_windows() -> None:
    said = "`launch_passive` requires that the Python script be run under `mjpython`"
    window = ViewerWindow(load_robot("go2"), FlatTerrain(), Mock(side_effect=RuntimeError(said)))
    with pytest.raises(ProblemError, match=r"cannot open a window: .*mjpython"):
        window.open(print)
