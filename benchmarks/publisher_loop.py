"""Whether a published walk outlives its simulator's softness: a policy on its publisher's model and drives.

    python -m benchmarks.publisher_loop ROBOT.xml NETWORK [--spec YAML] [--mu 0.6] [--seeds 10] [--seconds 4]

ROBOT.xml is the robot as its publisher simulates it, with the file's step, solver, shapes and softness. A
floor is put under one that has none, and meshes that only draw are left out. The policy is told 0.5 m/s and
observes what its description says, at its own rate; servos get its targets, motors its targets' torques at
each step of the simulation, as publishers' loops do. The first world of the table is the publisher's; the
others have Coulomb's law, stiffer ground, half the step, or another friction.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ModelError, ProblemError, SurefootError, mujoco_line, one_line
from surefoot.motion.control.controller import RobotState
from surefoot.worlds.mujoco.readings import pinocchio_state
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.transfer.variants import STANDARD

LOWEST = 0.5
"""Share of its first height above which a base has not fallen."""
SPEED, SHARE = 0.5, 0.5
"""Command [m/s], and the part of its way that a success makes."""


class PublisherLoop:
    """Drives a model as a policy says; it counts steps, and is reset before each run.

    Parameters
    ----------
    model
        MjModel of a robot whose joints have the names of the policy's; each is driven by a motor or a servo.
    policy
        What is asked for targets.

    Raises
    ------
    ProblemError
        For a model without a joint of the policy's, or one that nothing drives.
    """

    def __init__(self, model: Any, policy: sf.Policy) -> None:
        mujoco = import_mujoco()
        self._mujoco, self._policy = mujoco, policy
        joints = {model.joint(j).name: j for j in range(model.njnt)}
        lacking = [name for name in policy.spec.joints if name not in joints]
        if lacking:
            raise ProblemError(f"the model has no joint {', '.join(lacking)}")
        driven = {int(model.actuator_trnid[a, 0]): a for a in range(model.nu)}
        shared = [(k, joints[name]) for k, name in enumerate(policy.robot.joint_names) if name in joints]
        self._own = np.array([k for k, j in shared if j in driven])
        chosen = [j for _, j in shared if j in driven]
        if not set(policy.spec.joints) <= {model.joint(j).name for j in chosen}:
            raise ProblemError("the model does not drive all of the policy's joints")
        self._q, self._v = model.jnt_qposadr[chosen], model.jnt_dofadr[chosen]
        self._actuators = np.array([driven[j] for j in chosen])
        affine = int(mujoco.mjtBias.mjBIAS_AFFINE)
        self._rest = np.array(model.qpos0)
        self._servos = model.actuator_biastype[self._actuators] == affine

    @property
    def start(self) -> FloatArray:
        """The (nq,) configuration that a run starts from: the policy's pose; other joints as the model's."""
        robot, posture = self._policy.robot, self._policy.posture
        q = self._rest.copy()
        q[:3], q[3:7] = posture[:3], posture[[6, 3, 4, 5]]
        q[self._q] = posture[robot.model.nq - robot.joints :][self._own]
        return q

    def reset(self) -> None:
        """Begin a run."""
        self._policy.reset()

    def state(self, data: Any) -> RobotState:
        """Return what the policy sees: joints that the model lacks are where the policy's pose has them."""
        robot = self._policy.robot
        base, speed = pinocchio_state(np.array(data.qpos[:7]), np.array(data.qvel[:6]))
        q, v = self._policy.posture.copy(), np.zeros(robot.model.nv)
        q[:7], v[:6] = base, speed
        q[robot.model.nq - robot.joints :][self._own] = data.qpos[self._q]
        v[robot.base_dof :][self._own] = data.qvel[self._v]
        return RobotState(q, v, time=float(data.time))

    def __call__(self, model: Any, data: Any) -> None:
        """Set the controls before a step."""
        command = self._policy.step(self.state(data))
        targets = command.joint_targets
        if targets is None:
            raise ProblemError("the policy gave no targets")
        data.ctrl[self._actuators] = np.where(
            self._servos, targets.positions[self._own], command.torques[self._own]
        )


def on_a_floor(path: Path, mu: float) -> Any:
    """Return the model of the file on a floor, without meshes that only draw it.

    Shapes whose files are not there are left out, too, which is said.
    """
    mujoco = import_mujoco()
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, OSError) as error:
        raise ModelError(f"{path} is not an MJCF that MuJoCo can read: {mujoco_line(error)}") from error
    kinds, folder = mujoco.mjtGeom, path.parent / spec.meshdir
    there = {mesh.name for mesh in spec.meshes if (folder / mesh.file).is_file()}
    meshes = [g for g in spec.geoms if g.type == kinds.mjGEOM_MESH]
    touching = [g for g in meshes if g.contype or g.conaffinity]
    kept = [g for g in touching if g.meshname in there]
    used = {g.meshname for g in kept}
    if len(kept) < len(touching):
        lacking = sorted({g.meshname for g in touching} - there)
        print(f"left out, as their files are missing: shapes {', '.join(lacking)}", file=sys.stderr)
    for part in (
        *(g for g in meshes if g not in kept), *(mesh for mesh in spec.meshes if mesh.name not in used)
    ):  # fmt: skip
        spec.delete(part)
    if not any(g.type == kinds.mjGEOM_PLANE for g in spec.geoms):
        floor = spec.worldbody.add_geom(name="floor", type=kinds.mjGEOM_PLANE, size=[0.0, 0.0, 0.01])
        floor.contype, floor.conaffinity, floor.condim, floor.priority = 1, 0, 3, 1
        floor.friction = [mu, 0.005, 0.0001]
    return spec.compile()


def walked(seconds: float, height: float) -> Callable[[Any, Any], bool]:
    """Return what tells whether a run from a height ended upright, and far enough."""
    return lambda model, data: bool(data.qpos[2] > LOWEST * height and data.qpos[0] > SHARE * SPEED * seconds)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("model", type=Path)
    parser.add_argument("network", type=Path)
    parser.add_argument(
        "--spec", type=Path, default=None, help="description; a YAML beside the network if not"
    )
    parser.add_argument("--mu", type=float, default=0.6, help="friction of a floor that is put under it")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=4.0)
    given = parser.parse_args()
    try:
        print("\n".join(tabulated(given)))
    except SurefootError as error:
        parser.error(one_line(error))


def tabulated(given: argparse.Namespace) -> list[str]:
    """Return the lines of the table that was asked for."""
    model = on_a_floor(given.model, given.mu)
    step = float(model.opt.timestep)
    policy = sf.Policy(given.network, given.spec, command=(SPEED, 0.0, 0.0), dt=step, trust=True)
    loop = PublisherLoop(model, policy)
    report = sf.transfer(
        model, loop, STANDARD, given.seeds, duration=given.seconds, start=loop.start,
        success=walked(given.seconds, float(loop.start[2])),
    )  # fmt: skip
    return report.table()


if __name__ == "__main__":
    main()
