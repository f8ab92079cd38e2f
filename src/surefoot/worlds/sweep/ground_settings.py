"""What experiments with a body on the ground share: settings of both, and what they change."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from surefoot.base.errors import ProblemError
from surefoot.contact import ExactFriction, SpringDamper
from surefoot.mechanics import FlatTerrain, Robot, SlopeTerrain, Terrain, read_terrain, rough_ground
from surefoot.worlds.running.faults import scaled_robot
from surefoot.worlds.sweep.sample_experiment import SweepExperiment, number

OF_WORLDS: Mapping[str, tuple[str, ...]] = {
    "restitution": ("rigid", "mujoco-exact"), "stiffness": ("rigid",), "damping": ("rigid",),
    "time_constant": ("mujoco",), "damping_ratio": ("mujoco",),
}  # fmt: skip
"""Setting of the ground to the worlds that have it."""
SOFT_DEFAULTS = (0.004, 1.0)
"""Time constant [s] and damping ratio of MuJoCo's ground where one of the two is given."""


@dataclass(frozen=True)
class GroundExperiment(SweepExperiment):
    """An experiment with one body or robot in a world, on ground that is rigid unless it is said to be soft.

    Attributes
    ----------
    mu, restitution
        Friction of the ground; Newton's restitution, of rigid ground (worlds rigid and
        mujoco-exact).
    stiffness, damping
        Of a spring-damper ground (rigid world) [N/m], [N s/m].
    time_constant, damping_ratio
        MuJoCo's solref: [s] and a ratio.
    mass, inertia
        Scale all masses with their inertias, and inertias about the links' own centres once more.
    com_x, com_y, com_z
        Shift of the base's centre of mass: forward, left, up [m].
    slope, roughness, terrain
        A ground that rises along +x [deg], heights of rough ground (another one for each seed) [m], or a
        text of `surefoot.mechanics.terrain.TERRAINS`: one of the three.
    """

    world: ClassVar[str] = "rigid"

    mu: float = number(0.6, 0.0, 1e3)
    restitution: float | None = number(None, 0.0, 1.0)
    stiffness: float | None = number(None, 1e-3, 1e12, "N/m")
    damping: float | None = number(None, 0.0, 1e9, "N s/m")
    time_constant: float | None = number(None, 1e-6, 10.0, "s")
    damping_ratio: float | None = number(None, 1e-6, 100.0)
    mass: float = number(1.0, 1e-3, 1e3, "x nominal")
    inertia: float = number(1.0, 1e-3, 1e3, "x nominal")
    com_x: float = number(0.0, -10.0, 10.0, "m")
    com_y: float = number(0.0, -10.0, 10.0, "m")
    com_z: float = number(0.0, -10.0, 10.0, "m")
    slope: float | None = number(None, -80.0, 80.0, "deg")
    roughness: float | None = number(None, 0.0, 10.0, "m")
    terrain: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, worlds in OF_WORLDS.items():
            if self.world not in worlds and getattr(self, name) is not None:
                owners = " or ".join(worlds)
                raise ProblemError(f"{name} is of world {owners}, the settings say world {self.world}")
        if self.damping is not None and self.stiffness is None:
            raise ProblemError("damping goes with stiffness: rigid ground has none")
        if self.restitution is not None and self.stiffness is not None:
            raise ProblemError("restitution is of rigid ground, stiffness of soft: give one of the two")
        grounds = [n for n in ("terrain", "slope", "roughness") if getattr(self, n) not in (None, "")]
        if len(grounds) > 1:
            raise ProblemError(f"{' and '.join(grounds)} are each a ground of their own: give one")
        if self.terrain:
            read_terrain(self.terrain)

    def alter_masses(self, robot: Robot) -> Robot:
        """Return the robot with the masses of the settings; geometry and limits stay."""
        return scaled_robot(robot, self.mass, self.inertia, (self.com_x, self.com_y, self.com_z))

    def ground(self, seed: int) -> Terrain:
        """Return the terrain; flat if the settings name none."""
        if self.terrain:
            return read_terrain(self.terrain)
        if self.slope is not None:
            return SlopeTerrain(self.slope)
        return FlatTerrain() if self.roughness is None else rough_ground(seed, self.roughness)

    def ground_options(self) -> dict[str, Any]:
        """Return the world's options for the ground; none where the settings leave the world its own."""
        if self.world == "rigid":
            law = None
            if self.stiffness is not None:
                law = SpringDamper(self.stiffness, self.damping or 0.0, friction=ExactFriction(self.mu))
            return {"law": law, "restitution": self.restitution or 0.0}
        if self.world == "mujoco-exact":
            return {"restitution": self.restitution or 0.0}
        given = (self.time_constant, self.damping_ratio)
        if given == (None, None):
            return {}
        return {"solref": tuple(d if v is None else v for v, d in zip(given, SOFT_DEFAULTS, strict=True))}
