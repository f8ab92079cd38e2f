"""MuJoCo's model stepped by MJX: the same physics, compiled by JAX.

JAX compiles a step per shape of model, half a minute to a minute on one core; worlds of one robot on one kind of
terrain share it. What is a world's own, the length of its step,
friction and softness, is data.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import MissingExtra
from surefoot.robot import Robot
from surefoot.simulation.mujoco import LARGEST, MujocoWorld
from surefoot.stepping.bodies import finite_vector
from surefoot.terrain import Terrain


def import_mjx() -> Any:
    """Return JAX and MJX, in double precision.

    Raises
    ------
    MissingExtra
        If they are not installed.
    """
    try:
        import jax
        from mujoco import mjx
    except ImportError as error:
        raise MissingExtra("mujoco-mjx", "jax") from error
    jax.config.update("jax_enable_x64", True)
    return jax, mjx


@cache
def _compiled() -> Any:
    """Return the step; JAX keeps what it compiled for each shape of model."""
    jax, mjx = import_mjx()
    return jax.jit(mjx.step)


class MjxWorld(MujocoWorld):
    """A robot on a terrain in MJX; see `MujocoWorld`, whose model it steps.

    Parameters
    ----------
    robot, terrain, mu, dt, payload, solref, solimp
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
    ) -> None:
        self._jax, self._mjx = import_mjx()
        self._put: Any = None
        super().__init__(robot, terrain, mu, dt, payload, solref=solref, solimp=solimp)
        self._put = self._mjx.put_model(self.model)
        self.reset(robot.nominal)

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q and (nv,) v in Pinocchio's order, at time 0."""
        super().reset(q, v)
        if self._put is not None:
            self._state = self._mjx.put_data(self.model, self.data)

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt`; see `MujocoWorld.step`."""
        jnp = self._jax.numpy
        applied = np.zeros(self.model.nv)
        applied[self.robot.base_dof :] = finite_vector("torques", torques, self.robot.joints)
        external = np.zeros((self.model.nbody, 6))
        if push is not None and self._base:
            external[self._base, :3] = finite_vector("push", push, 3)
        self._before[0][:], self._before[1][:] = self.data.qpos, self.data.qvel
        given = self._state.replace(qfrc_applied=jnp.asarray(applied), xfrc_applied=jnp.asarray(external))
        state = _compiled()(self._put, given)
        if not np.abs(np.asarray(state.qvel)).max(initial=0.0) < LARGEST:
            raise self._lost()
        self._state = state
        self._mjx.get_data_into(self.data, self.model, state)

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground, from the next step on."""
        super().set_friction(mu)
        if self._put is not None:
            friction = self._jax.numpy.asarray(self.model.geom_friction)
            self._put = self._put.replace(geom_friction=friction)
