"""A window that shows a robot while it walks: MuJoCo's passive viewer on a model that is only drawn.

Any world's run can be shown: the viewer has a model of its own, with meshes and ground, and is given
configurations.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Callable
from typing import Any

from surefoot.app.viz.video import drawn_spec
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, needs, one_line
from surefoot.base.spatial import quaternion_wxyz
from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

HELP = "arrows or WASD: faster, slower, turn; Q, E: sideways; space: stop"
_SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")


def check_display() -> None:
    """Refuse a machine without a screen, before any work.

    Raises
    ------
    ProblemError
        Saying what is missing.
    MissingExtra
        If there is no library that opens windows.
    """
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in _SCREENS):
        raise ProblemError(
            f"--view needs a screen: neither {' nor '.join(_SCREENS)} is set (on a remote machine: ssh -X)"
        )
    with needs("mujoco", "sim"):
        import glfw
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        opened = bool(glfw.init())
    if not opened:
        why = "; ".join(" ".join(str(w.message).split()) for w in said) or "no reason given"
        raise ProblemError(f"--view cannot open a window: {why}")


class ViewerWindow:
    """MuJoCo's passive viewer; see `surefoot.worlds.running.live.LiveView` for the methods.

    Parameters
    ----------
    robot, terrain
        Who walks where.
    launch
        Opens a viewer of a model and data: `mujoco.viewer.launch_passive`, which None stands for.

    Raises
    ------
    ProblemError
        If MuJoCo cannot draw the robot, or not show a window in this process.
    """

    def __init__(self, robot: Robot, terrain: Terrain, launch: Callable[..., Any] | None = None) -> None:
        self._mujoco: Any = import_mujoco()
        self._robot, self._launch = robot, launch
        try:
            self.model = drawn_spec(robot, terrain).compile()
        except ValueError as error:
            raise ProblemError(f"MuJoCo cannot draw {robot.name}: {one_line(error)}") from error
        self.data = self._mujoco.MjData(self.model)
        self._handle: Any = None

    def open(self, press: Callable[[int], object]) -> None:
        """See `LiveView.open`."""
        launch = self._launch
        if launch is None:
            import mujoco.viewer

            launch = mujoco.viewer.launch_passive
        self._pose(self._robot.nominal)
        try:
            self._handle = launch(
                self.model, self.data, key_callback=press, show_left_ui=False, show_right_ui=False
            )
        except RuntimeError as error:  # macOS shows windows under mjpython alone
            raise ProblemError(f"--view cannot open a window: {one_line(error)}") from error
        camera, size = self._handle.cam, float(self._robot.nominal[2])
        camera.type = self._mujoco.mjtCamera.mjCAMERA_TRACKING
        camera.trackbodyid = self.model.body("base:0").id
        camera.distance, camera.azimuth, camera.elevation = 5.0 * size, 140.0, -14.0

    def show(self, q: FloatArray, velocity: FloatArray) -> bool:
        """See `LiveView.show`."""
        if not self._handle.is_running():
            return False
        with self._handle.lock():
            self._pose(q)
        forward, left, turn = velocity
        asked = f"{forward:.1f} m/s forward, {left:.1f} left, {turn:.1f} rad/s"
        font, corner = self._mujoco.mjtFont.mjFONT_NORMAL, self._mujoco.mjtGridPos.mjGRID_TOPLEFT
        self._handle.set_texts((font, corner, asked, HELP))
        self._handle.sync()
        return True

    def _pose(self, q: FloatArray) -> None:
        self.data.qpos[:] = q
        self.data.qpos[3:7] = quaternion_wxyz(q[3:7])
        self._mujoco.mj_forward(self.model, self.data)

    def close(self) -> None:
        """See `LiveView.close`."""
        if self._handle is not None:
            self._handle.close()
            self._handle = None
