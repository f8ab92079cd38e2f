"""Many robots of one model in MJX at once: state arrays in, state arrays out, one compiled call for all.

JAX compiles for each model, and each number of robots, in every process. Steps of one call run inside that
compiled code, so many steps a call are quick ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, finite_array, whole_number
from surefoot.robot import Robot
from surefoot.simulation.batch import chosen_robots, per_robot, rows_per_robot
from surefoot.simulation.mjx import STATE, MjxWorld, import_mjx, left_behind
from surefoot.simulation.mujoco import LARGEST
from surefoot.spatial import base_velocity, quaternion_wxyz, quaternion_xyzw, rotation_from_quaternion
from surefoot.terrain import Terrain

SLIPPERIEST = 1e-5
"""Least friction that MuJoCo takes."""


@dataclass(frozen=True)
class MjxBatchStep:
    """What a step of an `MjxBatch` returns.

    Attributes
    ----------
    q, v
        (count, nq) and (count, nv) in Pinocchio's order.
    forces
        (count, p, 3) of the ground during the last step, in contact axes [N].
    gaps
        (count, p) of the contact points during the last step [m].
    lost
        (count,) whose motion could not be resolved: they stay where they were until they are reset.
    """

    q: FloatArray
    v: FloatArray
    forces: FloatArray
    gaps: FloatArray
    lost: BoolArray


class MjxBatch:
    """Robots of one model on one terrain in MJX, each with its own state and friction.

    Parameters
    ----------
    robot, terrain, dt, payload, solref, solimp
        As for `MujocoWorld`, one for all.
    count
        Number of robots.
    mu
        Friction of the ground, a number or (count,).

    Raises
    ------
    MissingExtra
        If MJX is not installed.
    ProblemError
        For a value out of range.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        count: int = 1,
        mu: ArrayLike = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        solref: Sequence[float] | None = None,
        solimp: Sequence[float] | None = None,
    ) -> None:
        self.robot, self.count = robot, whole_number("count", count, low=1)
        self._mu = per_robot("mu", mu, self.count)
        self._world = MjxWorld(robot, terrain, 1.0, dt, payload, solref=solref, solimp=solimp)
        self.dt = self._world.dt
        self._lost = np.zeros(self.count, dtype=np.bool_)
        one = {name: np.asarray(getattr(self._world.data, name), dtype=np.float64) for name in STATE}
        self._moving = {name: np.repeat(value[None], self.count, axis=0) for name, value in one.items()}
        self._read: Any = None
        self.reset(robot.nominal)

    def reset(self, q: ArrayLike, v: ArrayLike | None = None, which: ArrayLike | None = None) -> None:
        """Put robots at q (count, nq) or (nq,) and v alike (None: at rest), without history.

        `which` (count,) is a mask of the robots that are meant; None for all.
        """
        model = self.robot.model
        chosen = chosen_robots(which, self.count)
        new_q = rows_per_robot("q", q, self.count, model.nq)
        new_v = (
            np.zeros((self.count, model.nv)) if v is None else rows_per_robot("v", v, self.count, model.nv)
        )
        states = [self._mujocos(self.robot.configuration(new_q[k]), new_v[k]) for k in np.flatnonzero(chosen)]
        for name in STATE:
            self._moving[name] = np.array(self._moving[name])
            self._moving[name][chosen] = 0.0
        for k, (qpos, qvel) in zip(np.flatnonzero(chosen).tolist(), states, strict=True):
            self._moving["qpos"][k], self._moving["qvel"][k] = qpos, qvel
        self._lost = np.where(chosen, False, self._lost)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (count, nq) [m, -, rad] and v (count, nv) [m/s, rad/s] in Pinocchio's order."""
        q, v = np.array(self._moving["qpos"]), np.array(self._moving["qvel"])
        if self.robot.floating:
            for k in range(self.count):
                q[k, 3:7] = quaternion_xyzw(q[k, 3:7])
                v[k, :3] = rotation_from_quaternion(q[k, 3:7]).T @ v[k, :3]
        return q, v

    def set_friction(self, mu: ArrayLike) -> None:
        """Change the friction of the ground [-], a number or (count,), from the next step on."""
        self._mu = per_robot("mu", mu, self.count)

    def step(self, torques: ArrayLike, push: ArrayLike | None = None, repeat: int = 1) -> MjxBatchStep:
        """Advance all robots by `repeat` steps under (count, joints) torques [N m] and (count, 3) pushes [N].

        Raises
        ------
        ProblemError
            For a wrong shape or an entry that is not finite. Nothing has moved.
        """
        world, count = self._world, self.count  # its model, still state and reading are shared
        repeat = whole_number("repeat", repeat, low=1)
        applied = np.zeros((count, world.model.nv))
        applied[:, self.robot.base_dof :] = finite_array("torques", torques, (count, self.robot.joints))
        external = np.zeros((count, world.model.nbody, 6))
        if push is not None:
            pushes = finite_array("push", push, (count, 3))
            if world.base_body:
                external[:, world.base_body, :3] = pushes
        if self._read is None:
            first = {name: np.asarray(value) for name, value in left_behind(world.at_rest).items()}
            self._read = {name: np.repeat(value[None], count, axis=0) for name, value in first.items()}
        ground, mu = np.array(world.ground_geoms), np.maximum(self._mu, SLIPPERIEST)
        moving, self._read, lost = _compiled()(
            world.on_device,
            world.at_rest,
            ground,
            repeat,
            self._moving,
            self._read,
            self._lost,
            mu,
            applied,
            external,
        )
        self._moving = {name: np.asarray(value) for name, value in moving.items()}
        self._lost = np.asarray(lost)
        return self._told()

    def _told(self) -> MjxBatchStep:
        """Return the states and what the ground did, robot by robot."""
        read = {name: np.asarray(value) for name, value in self._read.items()}
        seen = [self._world.reading({name: read[name][k] for name in read}) for k in range(self.count)]
        forces, gaps = np.array([s.forces for s in seen]), np.array([s.gaps for s in seen])
        return MjxBatchStep(*self.state(), forces, gaps, self._lost.copy())

    def _mujocos(self, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return a state in MuJoCo's order."""
        qpos, qvel = q.copy(), v.copy()
        if self.robot.floating:
            qpos[3:7], qvel[:3] = quaternion_wxyz(q[3:7]), base_velocity(q, v)
        return qpos, qvel


@cache
def _compiled() -> Any:
    """Return the steps of all robots; JAX keeps what it compiled for each shape of model and count."""
    jax, mjx = import_mjx()
    jnp = jax.numpy

    def one(
        model: Any, still: Any, ground: Any, repeat: Any, moving: Any, read: Any, lost: Any, mu: Any,
        applied: Any, external: Any,
    ) -> Any:  # fmt: skip
        own = model.replace(geom_friction=model.geom_friction.at[ground, 0].set(mu))
        given = still.replace(qfrc_applied=applied, xfrc_applied=external)

        def advance(_: Any, carried: Any) -> Any:
            before, lost = carried
            after = mjx.step(own, given.replace(**before[0]))
            now = {name: getattr(after, name) for name in STATE}, left_behind(after)
            lost = lost | ~(jnp.abs(after.qvel).max(initial=0.0) < LARGEST)  # not a number is lost, too
            keep = lambda new, old: jnp.where(lost, old, new).astype(old.dtype)  # noqa: E731
            return jax.tree.map(keep, now, before), lost

        (moving, read), lost = jax.lax.fori_loop(0, repeat, advance, ((moving, read), lost))
        return moving, read, lost

    return jax.jit(jax.vmap(one, in_axes=(None, None, None, None, 0, 0, 0, 0, 0, 0)))
