"""What a controller and a log need of a world: state in, torques out, contact forces as measured."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.errors import ProblemError, shown
from surefoot.mechanics import FlatTerrain, Robot, Terrain


class ContactReading(NamedTuple):
    """What the ground did to the robot's contact points during the last step.

    One row per contact sphere of the feet, in the order of `World.contact_foot`; all of the same
    instant, the start of the step. Frames are contact frames (tangent, tangent, normal) of the ground at
    each point.

    Attributes
    ----------
    forces
        (p, 3) force on the robot [N]; zero where there is no contact.
    gaps
        (p,) distance to the ground [m], negative in penetration.
    velocities
        (p, 3) velocity of the foot's material at the contact [m/s].
    positions
        (p, 3) contact points in world axes [m].
    others
        (nv,) generalised force of all other contacts: of other links, bodies, the robot with itself
        [N, N m]; None in a world that has the feet's alone.
    normals
        (p, 3) normals of the ground where it is nearest, world axes [-]; None for those of the terrain under
        the positions.
    """

    forces: FloatArray
    gaps: FloatArray
    velocities: FloatArray
    positions: FloatArray
    others: FloatArray | None = None
    normals: FloatArray | None = None

    def normals_on(self, terrain: Terrain) -> FloatArray:
        """Return the normals (p, 3) of the ground at the contact points, world axes [-]."""
        return terrain.normal(self.positions[:, :2]) if self.normals is None else self.normals


class World(Protocol):
    """A robot on a terrain that obeys some physics.

    Attributes
    ----------
    robot, terrain
        Who stands where.
    dt
        Length of a step [s].
    time
        Simulated time [s].
    contact_foot
        (p,) index into `robot.feet` of every contact point.
    """

    robot: Robot
    terrain: Terrain
    dt: float
    contact_foot: IntArray

    @property
    def time(self) -> float:
        """Simulated time [s]."""

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] (None: zero), at time 0."""

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) force [N] in world axes.

        The force acts at the centre of mass of the base's link.
        """

    def contacts(self) -> ContactReading:
        """Return what the ground did during the last step."""

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-] everywhere, from the next step on."""


def kind_of(world: World) -> str:
    """Return what kind of world one is: its class, or what it says of itself as `kind`."""
    return str(getattr(world, "kind", type(world).__name__))


def ground_of(terrain: Terrain | None) -> Terrain:
    """Return the terrain that a world is given, flat ground for None.

    Raises
    ------
    ProblemError
        For what is no terrain, as the name of one.
    """
    if terrain is None:
        return FlatTerrain()
    if not isinstance(terrain, Terrain):
        raise ProblemError(
            f"terrain must be a Terrain, as sf.SlopeTerrain(10.0) is one, got {shown(terrain)}"
        )
    return terrain
