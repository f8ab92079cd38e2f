"""The package's own model of a tossed cube: the compiled simulator under one of its contact laws."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from surefoot.arrays import FloatArray, whole_number
from surefoot.errors import check_name
from surefoot.estimation import cube_contact as layout
from surefoot.estimation.cube_motion import simulate
from surefoot.estimation.toss_model import TossParameter, TossScene

LONGEST_STEP = 1e-3
"""Of a simulation [s]."""
FRICTION = TossParameter("mu", 0.02, 1.5, logarithmic=True)
PARAMETERS = {
    "rigid": (
        FRICTION,
        TossParameter("restitution", 0.0, 0.9),
        TossParameter("rounding", 0.0, 0.2, "half sides"),
    ),
    "spring-damper": (
        FRICTION,
        TossParameter("stiffness", 1e2, 1e6, "N/m", logarithmic=True),
        TossParameter("damping", 1e-1, 1e3, "N s/m", logarithmic=True),
    ),
    "hunt-crossley": (
        FRICTION,
        TossParameter("stiffness", 1e2, 1e6, "N/m", logarithmic=True),
        TossParameter("dissipation", 1e-2, 1e2, "s/m", logarithmic=True),
    ),
}
"""Contact laws by name, and what each of them leaves open.

Stiffness and damping are those of one corner. Rounding is the radius of the corners: a rigid cube has no
other way of letting its corners go below the ground.
"""
_NUMBER = {
    "rigid": layout.RIGID,
    "spring-damper": layout.SPRING_DAMPER,
    "hunt-crossley": layout.HUNT_CROSSLEY,
}


@dataclass(frozen=True)
class CubeModel:
    """A cube with eight corners on a plane, exact Coulomb friction, under a contact law.

    Attributes
    ----------
    law
        A name of `PARAMETERS`.
    steps
        Steps between frames; None for as many as keep a step within a millisecond.

    Raises
    ------
    ProblemError
        If there is no such law, or a number is out of range.
    """

    law: str = "rigid"
    steps: int | None = None

    def __post_init__(self) -> None:
        check_name("contact law", self.law, PARAMETERS)
        if self.steps is not None:
            whole_number("steps", self.steps, low=1)

    @property
    def name(self) -> str:
        """The law's."""
        return self.law

    @property
    def parameters(self) -> tuple[TossParameter, ...]:
        """Those of the law."""
        return PARAMETERS[self.law]

    def rollout(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return (sum of frames, 7) positions [m] and quaternions."""
        model, axes = self._model(values, scene), scene.plane.rotation
        origin = np.array([0.0, 0.0, scene.plane.height - self._sink(values, scene)])
        starts = np.empty((len(scene.starts), 13))
        back = axes.inv()
        starts[:, :3] = back.apply(scene.starts[:, :3] - origin)
        starts[:, 3:7] = (back * Rotation.from_quat(scene.starts[:, 3:7])).as_quat()
        starts[:, 7:10] = back.apply(scene.starts[:, 7:10])
        starts[:, 10:] = back.apply(scene.starts[:, 10:])
        poses = np.empty((int(scene.frames.sum()), 7))
        steps = self.steps or max(1, math.ceil(scene.dt / LONGEST_STEP - 1e-9))
        simulate(starts, scene.frames, scene.dt, steps, model, poses)
        poses[:, :3] = axes.apply(poses[:, :3]) + origin
        poses[:, 3:] = (axes * Rotation.from_quat(poses[:, 3:])).as_quat()
        return poses

    def _sink(self, values: FloatArray, scene: TossScene) -> float:
        """Return how deep a soft contact lets the cube sink at rest: the plane was found with it at rest."""
        return 0.0 if self.law == "rigid" else -scene.cube.mass * scene.gravity / (4.0 * values[1])

    def _model(self, values: FloatArray, scene: TossScene) -> FloatArray:
        """Return the kernel's model, in the plane's axes and per unit of mass."""
        cube, model = scene.cube, np.zeros(layout.SIZE)
        model[layout.MU], model[layout.HALF] = values[0], cube.half_side
        model[layout.GYRATION] = cube.inertia / cube.mass
        down = np.array([0.0, 0.0, -scene.gravity])
        model[layout.GRAVITY : layout.GRAVITY + 3] = scene.plane.rotation.inv().apply(down)
        model[layout.LAW] = _NUMBER[self.law]
        if self.law == "rigid":
            model[layout.RESTITUTION], model[layout.RADIUS] = values[1], values[2] * cube.half_side
        else:
            model[layout.STIFFNESS] = values[1] / cube.mass
            model[layout.DAMPING] = values[2] / (cube.mass if self.law == "spring-damper" else 1.0)
        return model
