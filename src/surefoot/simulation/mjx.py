"""MuJoCo's model stepped by MJX: the same physics, compiled by JAX.

JAX compiles a step per shape of model, half a minute to a minute on one core; worlds of one robot on one kind
of terrain share it. What is a world's own, the length of its step, friction and softness, is data.
"""

from __future__ import annotations

import contextlib
import io
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra, SimulationError
from surefoot.robot import Robot
from surefoot.simulation.mujoco import LARGEST, MujocoWorld
from surefoot.simulation.mujoco_contacts import read_contacts
from surefoot.simulation.world import ContactReading
from surefoot.stepping.bodies import finite_vector
from surefoot.terrain import Terrain
from surefoot.terrain.frames import surface_frames


def import_mjx() -> Any:
    """Return JAX and MJX, in double precision.

    Raises
    ------
    MissingExtra
        If they are not installed.
    """
    try:
        import jax

        with contextlib.redirect_stdout(io.StringIO()):  # it prints which back ends are not here
            from mujoco import mjx
    except ImportError as error:
        raise MissingExtra("mujoco-mjx", "mjx") from error
    jax.config.update("jax_enable_x64", True)
    return jax, mjx


STATE = ("qpos", "qvel", "qacc_warmstart", "time")
"""What a step hands on."""


def left_behind(data: Any) -> dict[str, Any]:
    """Return what contacts are read from after a step."""
    contact = data._impl.contact
    return {
        "geom_xpos": data.geom_xpos, "cvel": data.cvel, "subtree_com": data.subtree_com,
        "geom": contact.geom, "efc_address": contact.efc_address, "frame": contact.frame,
        "efc_force": data._impl.efc_force,
    }  # fmt: skip


@cache
def _compiled() -> Any:
    """Return the step; JAX keeps what it compiled for each shape of model."""
    jax, mjx = import_mjx()
    return jax.jit(mjx.step)


class MjxWorld(MujocoWorld):
    """A robot on a terrain in MJX; see `MujocoWorld`, whose model it steps.

    Parameters
    ----------
    robot, terrain, mu, dt, payload, solref, solimp, payload_position
        See `MujocoWorld`.

    Raises
    ------
    MissingExtra
        If MJX is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        solref: Sequence[float] | None = None,
        solimp: Sequence[float] | None = None,
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._jax, self._mjx = import_mjx()
        self.on_device: Any = None
        super().__init__(
            robot, terrain, mu, dt, payload, solref=solref, solimp=solimp, payload_position=payload_position
        )
        self.model.opt.disableflags &= ~int(self._mujoco.mjtDisableBit.mjDSBL_ISLAND)  # none in MJX
        self.on_device = self._mjx.put_model(self.model)
        self.reset(robot.nominal)

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q [m, -, rad], (nv,) v [m/s, rad/s] in Pinocchio's order, at time 0."""
        super().reset(q, v)
        if self.on_device is not None:
            self.at_rest = self._mjx.put_data(self.model, self.data)
            self._moving = {name: np.array(getattr(self.data, name)) for name in STATE}

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt`; see `MujocoWorld.step`."""
        applied, external = np.zeros(self.model.nv), np.zeros((self.model.nbody, 6))
        applied[self.robot.base_dof :] = finite_vector("torques", torques, self.robot.joints)
        if push is not None and self.base_body:
            external[self.base_body, :3] = finite_vector("push", push, 3)
        data = self.data
        self._before[0][:], self._before[1][:] = data.qpos, data.qvel
        # the same kinds of arrays every time, or JAX would compile again
        given = {**self._moving, "qfrc_applied": applied, "xfrc_applied": external}
        state = _compiled()(self.on_device, self.at_rest.replace(**given))
        moving = {name: np.asarray(getattr(state, name)) for name in STATE}
        if not np.abs(moving["qvel"]).max(initial=0.0) < LARGEST:
            raise self._lost()
        self._moving, self._after = moving, state
        data.qpos[:], data.qvel[:], data.time = moving["qpos"], moving["qvel"], float(moving["time"])

    def _lost(self) -> SimulationError:
        """Return the error that says what was lost; the state is still that before the step."""
        return self._lost_at(float(self._moving["time"]), self.data.qvel)

    def contacts(self) -> ContactReading:
        """Return forces, gaps and velocities at the feet's spheres during the last step."""
        if float(self._moving["time"]) == 0.0:
            return super().contacts()
        read = {name: np.asarray(value) for name, value in left_behind(self._after).items()}
        return self.reading(read)

    def reading(self, read: dict[str, FloatArray]) -> ContactReading:
        """Return forces (p, 3) [N], gaps (p,) [m], velocities at the feet from what a step `left_behind`."""
        points, forces, velocities, positions, gaps, _ = self._blank()
        normals = self._normals
        over = None if self._planar else self._ground_near(read["geom_xpos"][self._geoms])
        if over is not None:
            surface_frames(over[1], self._frames)
        read_contacts(
            read["geom_xpos"], read["cvel"], read["subtree_com"], read["geom"].astype(np.int32),
            read["efc_address"].astype(np.int32), read["frame"].reshape(-1, 9), read["efc_force"],
            self._owner, self._spheres, self._sizes, self._frames, gaps, points,
        )  # fmt: skip
        if over is not None:
            gaps, normals = over
        return ContactReading(forces, gaps, velocities, positions, normals=normals)

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-], from the next step on."""
        super().set_friction(mu)
        if self.on_device is not None:
            friction = self._jax.numpy.asarray(self.model.geom_friction)
            self.on_device = self.on_device.replace(geom_friction=friction)
