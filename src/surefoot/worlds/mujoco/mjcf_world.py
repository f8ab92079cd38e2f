"""A MuJoCo world that is somebody's MJCF file: its joints, actuators, collision shapes and contacts."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.base.errors import ModelError, ProblemError, check_name, mujoco_line
from surefoot.base.numerics.vectors import finite_vector
from surefoot.base.spatial import GRAVITY
from surefoot.mechanics import Robot, Terrain, file_actuators, read_present, with_rotors
from surefoot.records import Log
from surefoot.worlds.interface.world import ground_of
from surefoot.worlds.mujoco.actuators import Drives
from surefoot.worlds.mujoco.mjcf_feet import add_corners, foot_geoms
from surefoot.worlds.mujoco.mujoco_world import HEAVIEST, MujocoWorld, add_ground
from surefoot.worlds.mujoco.record_softness import world_softness
from surefoot.worlds.mujoco.spec import GroundLaw, add_payload, compile_spec, import_mujoco


class MjcfWorld(MujocoWorld):
    """The world of an MJCF file; see `surefoot.worlds.interface.world.World` for the methods.

    Rotor inertia, damping and dry friction of joints, actuators with their limits, collision shapes and the
    softness of contacts are the file's. Ours are the step, elliptic friction cones (forces of pyramids have
    no tangents to read), the friction of feet and ground, and that these push where they touch, not a margin
    before. A file without ground gets the terrain's, as soft as its feet if it says how soft they are, else
    close to rigid as for URDF files; one with a floor has that.

    Parameters
    ----------
    robot
        Loaded from the same file, with its feet: spheres there, or soles, whose corners become spheres.
    path
        The file.
    terrain
        What a file without ground stands on; None for flat.
    mu
        Friction of feet and ground [-].
    dt
        Length of a step, whatever the file says [s].
    payload, payload_position
        Point mass fixed to the base [kg], unknown to any controller, and its (3,) place there, base axes [m].
    collision
        What may touch: "full" for all shapes of the file, "feet" for them and the ground alone.
    **law
        ``solref``, ``solimp``: MuJoCo's softness of feet and ground, None for the file's own; ``exact`` and
        ``restitution`` of `MujocoWorld`.

    Raises
    ------
    ModelError
        For a file that MuJoCo cannot read, whose robot is another, or whose actuators are neither motors nor
        servos.
    ProblemError
        For a file whose ground is not level, or a terrain on top of it.
    """

    def __init__(
        self,
        robot: Robot,
        path: str | Path,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        collision: str = "full",
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
        **law: Unpack[GroundLaw],
    ) -> None:
        solref, solimp = self._choose_law(**law)
        mujoco = self.mujoco = import_mujoco()
        self.actuators = file_actuators(robot)
        self.robot = with_rotors(robot, self.actuators.armature)
        self.dt, self.terrain = real_number("dt", dt, low=1e-6), ground_of(terrain)
        self.payload = real_number("payload", payload, low=0.0, high=HEAVIEST)
        self.payload_position = finite_array("payload_position", payload_position, (3,))
        spec, raw = _read(mujoco, path)
        floors = _floors(mujoco, raw)
        if not floors:
            add_ground(spec, self.terrain, real_number("mu", mu, low=0.0), solref, solimp)
        elif self.terrain.text != "flat":
            raise ProblemError(
                f"{path} has a floor of its own: it goes with flat ground, got {self.terrain.text}"
            )
        root = int(raw.jnt_bodyid[0]) if raw.njnt else 0
        self._set_options(spec, root)
        joints = _joints(mujoco, raw, self.robot, path)
        add_corners(mujoco, spec, raw, self.robot)
        self.model = compile_spec(spec, path)
        self._drives = Drives(mujoco, self.model, joints)
        feet = foot_geoms(mujoco, self.model, self.robot, path)
        check_name("collision", collision, ("feet", "full"))
        self._take(feet, root, collision == "full", floors)
        both, model = [*feet, *self.ground_geoms], self.model
        if collision == "feet":
            model.geom_contype[:], model.geom_conaffinity[:] = 0, 0
            model.geom_contype[self.ground_geoms], model.geom_conaffinity[feet] = 1, 1
        model.geom_margin[both], model.geom_gap[both] = 0.0, 0.0
        plain = mujoco.MjSpec().default.geom
        own = [
            (model.geom_solref[f] != plain.solref).any() or (model.geom_solimp[f] != plain.solimp).any()
            for f in feet
        ]
        if not floors and any(own):  # the ground is as soft as the feet, where the file says how soft
            model.geom_priority[self.ground_geoms], model.geom_solmix[self.ground_geoms] = 0, 0.0
        if solref is not None:
            model.geom_solref[both] = solref
        if solimp is not None:
            model.geom_solimp[both, : len(solimp)] = solimp
        self.set_friction(mu)
        self.reset(robot.nominal)

    def _set_options(self, spec: Any, root: int) -> None:
        """Set the step and what reading forces needs; hang the payload on the base."""
        mujoco, option = self.mujoco, spec.option
        option.timestep, option.cone = self.dt, mujoco.mjtCone.mjCONE_ELLIPTIC
        option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        if self.payload > 0.0:
            add_payload(spec.bodies[root], self.payload, self.payload_position)

    def _drive(self, torques: FloatArray) -> None:
        """See `MujocoWorld`."""
        self._drives.ask(self.data, finite_vector("torques", torques, self.robot.joints))
        self._keep()

    def _note_torques(self) -> None:
        """See `MujocoWorld`."""
        self.applied = self._drives.given(self.data)

    def set_friction(self, mu: float) -> None:
        """Change the friction of feet and ground [-], from the next step on."""
        both = [*self._reader.feet.geoms.tolist(), *self.ground_geoms]
        self.model.geom_friction[both, 0] = max(real_number("mu", mu, low=0.0), 1e-5)

    def softness(self, log: Log) -> dict[str, Any]:
        """Return what the softness of feet and ground means in a run; see `MujocoWorld.softness`."""
        if self.stepper is not None:
            return super().softness(log)
        load = GRAVITY * (self.robot.mass + self.payload)
        first, ground = int(self._reader.feet.geoms[0]), self.ground_geoms[0]
        rank = [(self.model.geom_priority[g], self.model.geom_solmix[g]) for g in (first, ground)]
        deciding = first if rank[0] > rank[1] else ground
        return world_softness(self.mujoco, self.model, deciding, self._reader.feet.bodies, log, load)


def _read(mujoco: Any, path: str | Path) -> tuple[Any, Any]:
    """Return the file's MjSpec, and its model as it is."""
    try:
        return read_present(mujoco, Path(path))
    except (ValueError, OSError) as error:
        raise ModelError(f"{path} is not an MJCF that MuJoCo can read: {mujoco_line(error)}") from error


def _floors(mujoco: Any, model: Any) -> list[int]:
    """Return the geoms that are the file's ground: level planes at z = 0, or raise for other ground."""
    fixed = np.array(model.body_weldid)[np.array(model.geom_bodyid)] == 0
    solid = (np.array(model.geom_contype) | np.array(model.geom_conaffinity)) > 0
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = [int(g) for g in np.flatnonzero(fixed & solid)]
    for g in found:
        plane = int(model.geom_type[g]) == int(mujoco.mjtGeom.mjGEOM_PLANE)
        level = data.geom_xmat[g].reshape(3, 3)[2, 2] > 1.0 - 1e-12 and abs(data.geom_xpos[g, 2]) < 1e-9
        if not (plane and level):
            name = model.geom(g).name or f"number {g}"
            raise ProblemError(
                f"geom {name} stands in the world: controllers and logs know of a level floor at z = 0 alone"
            )
    return found


def _joints(mujoco: Any, model: Any, robot: Robot, path: str | Path) -> IntArray:
    """Return MuJoCo's numbers of the robot's joints (joints,), or raise if the file is of another robot."""
    free = int(mujoco.mjtJoint.mjJNT_FREE)
    names = tuple(model.joint(j).name or f"joint_{j}" for j in range(1, model.njnt))
    if not robot.floating or not model.njnt or int(model.jnt_type[0]) != free or names != robot.joint_names:
        loose = [name for name in names if name not in robot.joint_names]
        if robot.floating and loose and set(robot.joint_names) < set(names):
            raise ModelError(
                f"{path} has joints beside the robot, on bodies of their own: {', '.join(loose)}; "
                "a copy of the file without these bodies can be simulated, or take --world rigid"
            )
        raise ModelError(
            f"{path} and {robot.name} are not one robot with a free base: load it from that file"
        )
    return np.arange(1, model.njnt)
