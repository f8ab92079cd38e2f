"""Several bodies in one world: free ones, fixed ones and a robot, with their shapes and surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, positive_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.libraries import import_pinocchio
from surefoot.mechanics import Geometry, Robot, Shape, Solid, StepSettings, Terrain, robot_geometry
from surefoot.worlds.rigid.rigid_world import RigidWorld


@dataclass(frozen=True)
class Body:
    """A homogeneous body of simple shape; a value.

    Attributes
    ----------
    name
        Its name.
    shape
        `Sphere`, `Box` or `Capsule` of `surefoot.mechanics.collision`, about the body's centre of mass.
    mass
        [kg].
    position, orientation
        (3,) centre of mass [m], and the quaternion (x, y, z, w) of its axes, at the start; world axes.
    velocity, spin
        (3,) velocity of the centre of mass [m/s] and angular velocity [rad/s] at the start, world axes.
    friction, restitution
        Coefficients of its surface [-]; None for those of the ground.
    fixed
        Whether it stays where it is, whatever touches it.

    Raises
    ------
    ProblemError
        For a mass that is not positive, or a value that is not finite.
    """

    name: str
    shape: Shape
    mass: float = 1.0
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    friction: float | None = None
    restitution: float | None = None
    fixed: bool = False

    def __post_init__(self) -> None:
        positive_number("mass", self.mass)
        for name, size in (("position", 3), ("orientation", 4), ("velocity", 3), ("spin", 3)):
            finite_array(name, getattr(self, name), (size,))
        length = float(np.linalg.norm(self.orientation))
        if abs(length - 1.0) > 1e-3:
            raise ProblemError(
                f"orientation of {self.name} must be a unit quaternion (x, y, z, w), its length is {length:g}"
            )
        if self.fixed and (any(self.velocity) or any(self.spin)):
            raise ProblemError(f"{self.name} is fixed and cannot move")

    @property
    def rotation(self) -> FloatArray:
        """The (3, 3) rotation rotation_world_body at the start."""
        quaternion = import_pinocchio().Quaternion(np.array(self.orientation, dtype=np.float64))
        return np.array(quaternion.normalized().matrix())


class Scene(Robot):
    """Bodies, and a robot if there is one, as one multibody system: a `Robot` to whoever steps it.

    q and v are the robot's, then for each free body in their order position, quaternion (x, y, z, w), and
    linear and angular velocity in its own axes. Motors are the robot's alone. Without a robot the first free
    body is the base.

    Parameters
    ----------
    bodies
        With names of their own.
    robot
        With all its collision geometry, in its nominal pose at the start.
    combine
        How two surfaces' coefficients make a contact's, see `translation.combination_rules`; of
        two surfaces with the ground's the ground's.

    Attributes
    ----------
    bodies
        As given.
    geometry
        What touches, for `Stepper`.

    Raises
    ------
    ProblemError
        For names that are not unique, or nothing that can move.

    Examples
    --------
    >>> from surefoot.mechanics.collision import Box
    >>> cube = Box((0.2, 0.2, 0.2))
    >>> scene = Scene([Body("lower", cube, 2.0, (0, 0, 0.1)), Body("upper", cube, 1.0, (0, 0, 0.3))])
    >>> scene.mass, scene.pose("upper").position
    (3.0, array([0. , 0. , 0.3]))
    """

    def __init__(
        self,
        bodies: Sequence[Body],
        robot: Robot | None = None,
        *,
        combine: str = "physx-min",
    ) -> None:
        pinocchio = import_pinocchio()
        of_kind("bodies", bodies, Sequence)
        self.bodies, self._robot = tuple(bodies), robot
        for k, body in enumerate(self.bodies):
            of_kind(f"bodies[{k}]", body, Body)
        names = [body.name for body in self.bodies]
        if len(set(names)) != len(names):
            raise ProblemError(f"bodies must have names of their own, got {', '.join(names)}")
        own = None if robot is None else robot_geometry(robot)
        taken = {"ground"} | (set() if own is None else {solid.name for solid in own.solids})
        for name in names:
            if name in taken:
                raise ProblemError(f"a body cannot be called {name!r}: something else is")
        if robot is None and all(body.fixed for body in self.bodies):
            raise ProblemError("a scene needs something that can move")
        model: Any = pinocchio.Model() if robot is None else robot.model.copy()
        start = [] if robot is None else [robot.nominal]
        solids = [] if own is None else list(own.solids)
        self._joint: dict[str, int] = {}
        for body in self.bodies:
            joint = 0 if body.fixed else _add(model, body)
            self._joint[body.name] = joint
            place = Pose(np.array(body.position, dtype=np.float64), body.rotation)
            # Joint 0 is the world: a fixed body's shape lies in it where the body is. A free one's lies at
            # the origin of its own joint, which is its centre of mass.
            here = place if body.fixed else Pose(np.zeros(3), np.eye(3))
            at = here.rotation, here.position, body.friction, body.restitution
            solids.append(Solid(body.name, body.shape, joint, *at))
            if not body.fixed:
                start.append(np.array([*body.position, *body.orientation], dtype=np.float64))
        apart = frozenset() if own is None else own.apart
        self.geometry = Geometry(tuple(solids), apart, combine)
        collision, visual = (
            (_no_shapes(), _no_shapes)
            if robot is None
            else (robot.collision, partial(getattr, robot, "visual"))
        )
        # Where the free bodies' quaternions lie in q, behind three of the place each.
        free = [model.joints[joint].idx_q for joint in self._joint.values() if joint]
        self._quaternions = np.array(free, dtype=np.int64).reshape(-1, 1) + np.arange(3, 7)
        floating = True if robot is None else robot.floating
        super().__init__("scene", model, collision, visual, (), np.concatenate(start), floating)
        if robot is not None:
            self.feet = robot.feet
            if robot.file is not None:
                self.keep_file(robot.file, partial(getattr, robot, "collision"))
        self.nominal = self.configuration(self.nominal)

    @property
    def joints(self) -> int:
        """Number of the robot's actuated velocity components, 0 without one."""
        return 0 if self._robot is None else self._robot.joints

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the robot's actuated joints."""
        return () if self._robot is None else self._robot.joint_names

    @property
    def effort_limits(self) -> FloatArray:
        """(joints,) torque limits of the robot [N m]."""
        return np.zeros(0) if self._robot is None else self._robot.effort_limits

    def configuration(self, q: ArrayLike | None = None) -> FloatArray:
        """Return q checked (nominal for None), its quaternions normalised: (nq,) [m, -, rad]."""
        out = super().configuration(q)
        turns = out[self._quaternions]
        lengths = np.linalg.norm(turns, axis=1)
        if (wrong := np.flatnonzero(np.abs(lengths - 1.0) > 1e-3)).size:
            name = [body.name for body in self.bodies if not body.fixed][int(wrong[0])]
            told = f"the quaternion (x, y, z, w) of {name} must have length 1"
            raise ProblemError(f"{told}, its length is {lengths[wrong[0]]:g}")
        out[self._quaternions] = turns / lengths[:, None]
        return out

    def start(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad], v (nv,) [m/s, rad/s] of the bodies as given; the robot is at rest."""
        v = np.zeros(self.model.nv)
        for body in self.bodies:
            if not body.fixed:
                # Bodies say both velocities in world axes, a free flyer's are in its own: Rᵀ v, Rᵀ ω.
                first = self.model.joints[self._joint[body.name]].idx_v
                v[first : first + 3] = body.rotation.T @ np.array(body.velocity)
                v[first + 3 : first + 6] = body.rotation.T @ np.array(body.spin)
        return self.nominal.copy(), v

    def pose(self, name: str, q: FloatArray | None = None) -> Pose:
        """Return where a body is at (nq,) q [m, -, rad], None for the start.

        Raises
        ------
        ProblemError
            If there is no such body; the message lists them.
        """
        joint = self._find_joint(name)
        if joint == 0:
            body = next(b for b in self.bodies if b.name == name)
            return Pose(np.array(body.position, dtype=np.float64), body.rotation)
        first, at = self.model.joints[joint].idx_q, self.nominal if q is None else q
        turn = import_pinocchio().Quaternion(np.array(at[first + 3 : first + 7]))
        return Pose(np.array(at[first : first + 3]), np.array(turn.normalized().matrix()))

    def twist(self, name: str, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return velocity of a body's centre [m/s] and angular velocity [rad/s], (3,) each, world axes."""
        joint = self._find_joint(name)
        if joint == 0:
            return np.zeros(3), np.zeros(3)
        first, turn = self.model.joints[joint].idx_v, self.pose(name, q).rotation
        return turn @ v[first : first + 3], turn @ v[first + 3 : first + 6]

    def _find_joint(self, name: str) -> int:
        """Return the joint of a body."""
        check_name("body", name, self._joint)
        return self._joint[name]


class Pose(NamedTuple):
    """Where a body is: `position` (3,) of its centre of mass [m], `rotation` (3, 3) rotation_world_body."""

    position: FloatArray
    rotation: FloatArray


def _no_shapes() -> Any:
    """Return Pinocchio's geometry model of nothing."""
    return import_pinocchio().GeometryModel()


def _add(model: Any, body: Body) -> int:
    """Add a free body to a Pinocchio model and return its joint."""
    pinocchio = import_pinocchio()
    here = pinocchio.SE3.Identity()
    joint = model.addJoint(0, pinocchio.JointModelFreeFlyer(), here, f"body:{body.name}")
    inertia = pinocchio.Inertia(float(body.mass), np.zeros(3), np.diag(body.shape.moments(body.mass)))
    model.appendBodyToJoint(joint, inertia, here)
    return int(joint)


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
    >>> from surefoot.mechanics.collision import Box
    >>> from surefoot.worlds.rigid.scene import Body
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
