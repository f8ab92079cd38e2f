"""The motion of a body, now and as wanted: what controllers on a single rigid body take."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, real_number, whole_number
from surefoot.base.spatial import rotation_about, rotation_from_normal, unit


@dataclass(frozen=True)
class BodyState:
    """The body now, world axes.

    Attributes
    ----------
    rotation
        (3, 3) rotation_world_body.
    position
        (3,) centre of mass [m].
    linear_velocity
        (3,) velocity of the centre of mass [m/s].
    angular_velocity
        (3,) [rad/s], world axes.
    """

    rotation: FloatArray
    position: FloatArray
    linear_velocity: FloatArray
    angular_velocity: FloatArray


@dataclass(frozen=True)
class BodyReference:
    """Where the body should be at the times 0, dt, ..., N dt from now; world axes.

    Attributes
    ----------
    rotation
        (N + 1, 3, 3) rotation_world_body.
    position, linear_velocity
        (N + 1, 3) of the centre of mass [m], [m/s].
    angular_velocity
        (N + 1, 3) [rad/s].
    """

    rotation: FloatArray
    position: FloatArray
    linear_velocity: FloatArray
    angular_velocity: FloatArray

    @staticmethod
    def cruise(
        position: ArrayLike,
        yaw: float,
        velocity: ArrayLike = (0.0, 0.0),
        yaw_rate: float = 0.0,
        *,
        horizon: int = 10,
        dt: float = 0.03,
        normal: ArrayLike = (0.0, 0.0, 1.0),
    ) -> BodyReference:
        """Return the reference of a body that moves and turns steadily, level with a surface.

        Parameters
        ----------
        position
            (3,) of the centre of mass at the start [m].
        yaw
            Heading at the start [rad], about the world's z.
        velocity
            (2,) forward and to the left, along the surface [m/s].
        yaw_rate
            Turn about the surface normal [rad/s].
        horizon, dt
            As in `ConvexMpc`.
        normal
            (3,) unit normal of the surface.

        Examples
        --------
        >>> BodyReference.cruise([0, 0, 0.3], yaw=0.0, velocity=(0.5, 0), horizon=2, dt=0.1).position
        array([[0.  , 0.  , 0.3 ],
               [0.05, 0.  , 0.3 ],
               [0.1 , 0.  , 0.3 ]])
        """
        n, horizon = unit("normal", normal), whole_number("horizon", horizon, low=1)
        yaw, yaw_rate = (real_number(*p, low=-1e9, high=1e9) for p in (("yaw", yaw), ("yaw_rate", yaw_rate)))
        start = rotation_from_normal(n, [math.cos(yaw), math.sin(yaw), 0.0])
        v = finite_array("velocity", velocity, (2,))
        turns = [rotation_about(n, yaw_rate * dt * 0.5 * k) @ start for k in range(2 * horizon + 1)]
        rotation = np.array(turns[::2])
        moves = dt * np.array([R[:, :2] @ v for R in turns[1::2]])  # by the heading at mid-step
        positions = finite_array("position", position, (3,)) + np.vstack(
            [np.zeros(3), np.cumsum(moves, axis=0)]
        )
        spin = np.tile(yaw_rate * n, (horizon + 1, 1))
        return BodyReference(rotation, positions, np.asarray(rotation[:, :, :2] @ v), spin)
