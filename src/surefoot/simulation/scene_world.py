"""A rigid world of several bodies that touch each other."""

from __future__ import annotations

from typing import Unpack

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.simulation.rigid import RigidWorld
from surefoot.simulation.scene import Pose, Scene
from surefoot.stepping.options import StepSettings
from surefoot.terrain import Terrain


class SceneWorld(RigidWorld):
    """A `Scene` on a terrain; it starts as the bodies say.

    Parameters
    ----------
    scene
        The bodies.
    terrain, mu, dt, tol, **settings
        See `RigidWorld`; `mu` and `restitution` are those of the ground and of bodies without their own.

    Examples
    --------
    >>> from surefoot.collision import Box
    >>> from surefoot.simulation.scene import Body
    >>> cube = Box((0.2, 0.2, 0.2))
    >>> bodies = [Body("lower", cube, 2.0, (0, 0, 0.1)), Body("upper", cube, 1.0, (0, 0, 0.3))]
    >>> world = SceneWorld(Scene(bodies))
    >>> for _ in range(10):
    ...     world.step()
    >>> upper = sum(t.force for t in world.touches() if t.body == "upper")
    >>> np.round(upper, 6) + 0.0  # the weight of the upper one [N]
    array([0.  , 0.  , 9.81])
    """

    robot: Scene

    def __init__(
        self,
        scene: Scene,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        *,
        tol: float | None = None,
        **settings: Unpack[StepSettings],
    ) -> None:
        super().__init__(scene, terrain, mu, dt, tol=tol, **settings)
        self.reset(*scene.start())

    @property
    def scene(self) -> Scene:
        """The bodies."""
        return self.robot

    def step(self, torques: FloatArray | None = None, push: FloatArray | None = None) -> None:
        """Advance by `dt`; torques are the robot's, see `RigidWorld.step`, None for none."""
        super().step(np.zeros(self.robot.joints) if torques is None else torques, push)

    def pose(self, name: str) -> Pose:
        """Return where a body is now."""
        return self.robot.pose(name, self._state.q)

    def twist(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return velocity of a body's centre [m/s] and angular velocity [rad/s], (3,) each, world axes."""
        return self.robot.twist(name, self._state.q, self._state.v)
