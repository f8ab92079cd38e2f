"""Whether a published walk outlives its own simulator's softness: MuJoCo Playground's Go1, in its own loop.

    python -m benchmarks.publisher_loop GO1.xml POLICY.onnx [--seeds 10] [--seconds 4]

GO1.xml is the robot as Playground trains it: feet alone touch, steps of 4 ms, one iteration of the solver. A
floor is put under it (its scene's file is another), and the policy is told 0.5 m/s, observed and driven
as its publisher does: 50 Hz, targets of position motors half an action about the standing pose. The first
world of the table is the publisher's; the others have Coulomb's law, stiffer ground, half the step, or
another friction.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.motion.policy.network import open_network
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.transfer.variants import STANDARD

HOME = np.tile([0.1, 0.9, -1.8, -0.1, 0.9, -1.8], 2)
"""Pose that actions are about [rad]."""
HEIGHT, LOWEST = 0.278, 0.15
"""Of the base at the start, and of one that has not fallen [m]."""
SPEED, SHARE = 0.5, 0.5
"""Command [m/s], and the part of its way that a success makes."""
PERIOD, SCALE, FRICTION = 0.02, 0.5, 0.6
"""Of observations [s], size of an action [rad], friction of floor and feet."""


class PlaygroundLoop:
    """Sets targets as Playground's own loop does; it counts steps, and is reset before each run.

    Parameters
    ----------
    infer
        The network: a (48,) observation to a (12,) action.
    """

    def __init__(self, infer: Callable[[FloatArray], FloatArray]) -> None:
        self._infer = infer
        self.reset()

    def reset(self) -> None:
        """Begin a run."""
        self._action, self._next = np.zeros(12), 0.0

    def observation(self, data: Any) -> FloatArray:
        """Return (48,): velocities and gravity in the base's axes, joints, last action, command."""
        turn = data.site("imu").xmat.reshape(3, 3)
        sensors = [data.sensor(name).data for name in ("local_linvel", "gyro")]
        gravity, joints = turn.T @ [0.0, 0.0, -1.0], data.qpos[7:] - HOME
        parts = (*sensors, gravity, joints, data.qvel[6:], self._action, [SPEED, 0.0, 0.0])
        return np.concatenate(parts)

    def __call__(self, model: Any, data: Any) -> None:
        """Set the motors' targets before a step."""
        if data.time >= self._next - 1e-9:
            self._next += PERIOD
            import_mujoco().mj_forward(model, data)
            self._action = np.asarray(self._infer(self.observation(data)), dtype=np.float64)
        data.ctrl[:] = HOME + SCALE * self._action


def on_a_floor(path: Path) -> Any:
    """Return the model of the file on a floor, without its meshes, which only draw it."""
    mujoco = import_mujoco()
    spec = mujoco.MjSpec.from_file(str(path))
    drawn = [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_MESH]
    for part in (*drawn, *spec.meshes):
        spec.delete(part)
    floor = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 0.01])
    floor.contype, floor.conaffinity, floor.condim, floor.priority = 1, 0, 3, 1
    floor.friction = [FRICTION, 0.005, 0.0001]
    return spec.compile()


def standing() -> FloatArray:
    """Return the (19,) configuration at the start."""
    return np.concatenate([[0.0, 0.0, HEIGHT, 1.0, 0.0, 0.0, 0.0], HOME])


def walked(seconds: float) -> Callable[[Any, Any], bool]:
    """Return what tells whether a run ended upright, and far enough."""
    return lambda model, data: bool(data.qpos[2] > LOWEST and data.qpos[0] > SHARE * SPEED * seconds)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("network", type=Path)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=4.0)
    given = parser.parse_args()
    loop = PlaygroundLoop(open_network(given.network))
    report = sf.transfer(
        on_a_floor(given.model), loop, STANDARD, given.seeds, duration=given.seconds, start=standing(),
        success=walked(given.seconds),
    )  # fmt: skip
    print("\n".join(report.table()))


if __name__ == "__main__":
    main()
