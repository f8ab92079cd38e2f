"""A Bullet world made from the Pinocchio model itself, through PyBullet.

Bullet's conventions stop in this file: a base is where its centre of mass is, in its principal axes, and its
velocity is that point's, in world axes. Joints are ideal torque sources without friction or rotor inertia;
only the feet's spheres touch the ground.
"""

from __future__ import annotations

import importlib
import tempfile
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ModelError, ProblemError, check_name, needs
from surefoot.base.numerics.vectors import finite_vector
from surefoot.base.spatial import quaternion_from_rotation, rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.interface.engine_world import HIGHEST, LARGEST, EngineWorld

GROUND = {"contactStiffness": 1e18, "contactDamping": 0.0, "restitution": 1.0}
"""What `changeDynamics` takes of a contact, as the ground has it where the foot's alone is to count.

Bullet puts stiffnesses in series, adds dampings and multiplies restitutions.
"""
SPHERE = '<collision><origin xyz="{place}"/><geometry><sphere radius="{radius!r}"/></geometry></collision>'
LINK = (
    '<link name="body{k}"><inertial><origin xyz="{com}"/><mass value="{mass!r}"/><inertia {moments}/>'
    "</inertial>{spheres}</link>"
)
JOINT = (
    '<joint name="joint{k}" type="{kind}"><parent link="body{parent}"/><child link="body{k}"/>'
    '<origin xyz="{place}" rpy="{turn}"/><axis xyz="{axis}"/>'
    '<limit lower="{low!r}" upper="{high!r}" effort="1e9" velocity="1e9"/></joint>'
)
MOMENTS = (("ixx", 0, 0), ("iyy", 1, 1), ("izz", 2, 2), ("ixy", 0, 1), ("ixz", 0, 2), ("iyz", 1, 2))
"""Moments of inertia by URDF's names, with their row and column."""


def import_bullet() -> Any:
    """Return PyBullet.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    with needs("PyBullet", "bullet"):
        return importlib.import_module("pybullet")


class BulletWorld(EngineWorld):
    """A robot on a terrain in Bullet; see `surefoot.worlds.interface.world.World` for the methods.

    Parameters
    ----------
    robot
        Who stands; with a floating base.
    terrain
        None for flat ground; planes and boxes (steps) only.
    mu
        Friction of the ground.
    dt
        Length of a step [s].
    payload, payload_position
        Point mass fixed to the base [kg], unknown to any controller, and where: (3,) base axes [m].
    contact
        ``contactStiffness`` [N/m], ``contactDamping`` [N s/m] and ``restitution`` [-] of feet on rigid
        ground, as `surefoot.translate(law, "bullet", mass).parameters` has them; None for Bullet's own.
    engine
        Of `setPhysicsEngineParameter`, as ``numSolverIterations``; None for Bullet's own.

    Raises
    ------
    MissingExtra
        If PyBullet is not installed.
    ProblemError
        For a contact that Bullet does not have, or numbers out of range.
    ModelError
        For a terrain or a joint that this world does not build.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        contact: Mapping[str, float] | None = None,
        engine: Mapping[str, float] | None = None,
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._bullet = import_bullet()
        if not robot.floating:
            raise ModelError("the bullet world takes robots with a floating base")
        super().__init__(robot, terrain, dt, payload, payload_position)
        client = self._bullet.connect(self._bullet.DIRECT)
        self._end = weakref.finalize(self, self._bullet.disconnect, client)
        self._here = {"physicsClientId": client}
        self._setup(self._scene, contact or {}, engine or {})
        self.set_friction(mu)
        self.reset(robot.nominal)

    def _setup(
        self, scene: dict[str, Any], contact: Mapping[str, float], engine: Mapping[str, float]
    ) -> None:
        """Build the ground and the robot."""
        values = contact_numbers(contact)
        bullet, client = self._bullet, self._here
        slop = {"contactSlop": 0.0} if values else {}  # a depth at which its springs do not yet push
        steps = {"fixedTimeStep": self.dt, "numSubSteps": 0}
        try:
            bullet.setPhysicsEngineParameter(**{**steps, **slop, **engine}, **client)
        except TypeError as error:
            raise ProblemError(f"engine = {dict(engine)} does not suit Bullet: {error}") from error
        bullet.setGravity(*scene["gravity"], **client)
        self._ground = [self._add_ground(shape) for shape in scene["ground"]]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(urdf_of(scene), encoding="utf8")
            flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_MAINTAIN_LINK_ORDER
            self._body = bullet.loadURDF(str(path), flags=flags, **client)
        self._links = list(range(len(scene["joints"]) - 1))
        spring = {name: values[name] for name in values if name != "restitution"}
        bounce = {name: values[name] for name in values if name == "restitution"}
        free: list[dict[str, float]] = [{"linearDamping": 0.0, "angularDamping": 0.0}, {"jointDamping": 0.0}]
        free += [{"maxJointVelocity": LARGEST}, spring, bounce, {"lateralFriction": 1.0}]
        for link in (-1, *self._links):
            for given in free:  # one by one: friction that comes with joint damping is dropped
                bullet.changeDynamics(self._body, link, **given, **client)
        for ground in self._ground:
            bullet.changeDynamics(ground, -1, **{name: GROUND[name] for name in values}, **client)
        self._command(bullet.VELOCITY_CONTROL, [0.0] * len(self._links))  # its own motors hold joints
        info = bullet.getDynamicsInfo(self._body, -1, **client)
        self._centre, self._principal = np.array(info[3]), rotation_from_quaternion(np.array(info[4]))

    def _command(self, mode: int, forces: list[float]) -> None:
        """Give the joints' motors their forces [N m] in one of Bullet's modes."""
        if self._links:
            self._bullet.setJointMotorControlArray(self._body, self._links, mode, forces=forces, **self._here)

    def _add_ground(self, shape: dict[str, Any]) -> int:
        """Return a body of the ground that never moves."""
        bullet, client = self._bullet, self._here
        if "size" in shape:
            half = [0.5 * length for length in shape["size"]]
            made = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half, **client)
        else:
            made = bullet.createCollisionShape(bullet.GEOM_PLANE, **client)
        turn = quaternion_from_rotation(np.array(shape["rotation"])).tolist()
        return int(bullet.createMultiBody(0.0, made, -1, shape["place"], turn, **client))

    def close(self) -> None:
        """Free Bullet's memory; the world takes no further step."""
        self._end()

    def _place(self) -> None:
        """See `EngineWorld`."""
        bullet, client = self._bullet, self._here
        R = rotation_from_quaternion(self._q[3:7])
        turn = quaternion_from_rotation(R @ self._principal).tolist()
        place = (self._q[:3] + R @ self._centre).tolist()
        bullet.resetBasePositionAndOrientation(self._body, place, turn, **client)
        speed = R @ (self._v[:3] + np.cross(self._v[3:6], self._centre))
        bullet.resetBaseVelocity(self._body, speed.tolist(), (R @ self._v[3:6]).tolist(), **client)
        for link, angle, rate in zip(self._links, self._q[7:], self._v[6:], strict=True):
            bullet.resetJointState(self._body, link, float(angle), float(rate), **client)

    def _read_state(self) -> tuple[FloatArray, FloatArray]:
        """Return q and v out of Bullet."""
        bullet, client = self._bullet, self._here
        place, turn = bullet.getBasePositionAndOrientation(self._body, **client)
        speed, spin = (np.array(x) for x in bullet.getBaseVelocity(self._body, **client))
        states = bullet.getJointStates(self._body, self._links, **client) if self._links else ()
        joints = np.array([x[:2] for x in states]).reshape(-1, 2)
        R = rotation_from_quaternion(np.array(turn)) @ self._principal.T
        base, rates = R.T @ speed, R.T @ spin
        q = np.concatenate([place - R @ self._centre, quaternion_from_rotation(R), joints[:, 0]])
        return q, np.concatenate([base - np.cross(rates, self._centre), rates, joints[:, 1]])

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) force on the base [N], world axes.

        Raises
        ------
        ProblemError
            For torques or a push of the wrong shape, or not finite. Nothing has moved.
        SimulationError
            Where the state is lost. The world stays in the state before the step.
        """
        bullet, client = self._bullet, self._here
        given = finite_vector("torques", torques, self.robot.joints).tolist()
        if push is not None:
            force = finite_vector("push", push, 3).tolist()
            R = rotation_from_quaternion(self._q[3:7])
            place = (self._q[:3] + R @ self._stepper.bodies.lever).tolist()
            bullet.applyExternalForce(self._body, -1, force, place, bullet.WORLD_FRAME, **client)
        self._command(bullet.TORQUE_CONTROL, given)
        bullet.stepSimulation(**client)
        q, v = self._read_state()
        if not max(np.abs(v).max(initial=0.0), np.abs(self._v).max(initial=0.0)) < LARGEST:
            raise self._undo_step()
        self._seen = self._stepper.contacts(self._stepper.start(self._q))  # Bullet's contacts are the start's
        self._rates = self._seen.velocities(v)  # and its impulses are of the velocities after them
        self._forces = self._read_forces()
        self._q, self._v, self._steps = q, v, self._steps + 1

    def _read_forces(self) -> FloatArray:
        """Return forces (p, 3) in the terrain's frames, each at the sphere that is nearest on its link."""
        seen, forces = self._seen, np.zeros((len(self.contact_foot), 3))
        joints = self.robot.contact_points.joints
        for found in self._bullet.getContactPoints(bodyA=self._body, **self._here):
            link, place, normal = found[3], np.array(found[5]), np.array(found[7])
            force = found[9] * normal + found[10] * np.array(found[11]) + found[12] * np.array(found[13])
            rows = np.flatnonzero(joints == link + 2)
            k = rows[np.argmin(np.linalg.norm(seen.positions[rows] - place, axis=1))]
            forces[k] += seen.frames[k].T @ force
        return forces

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-] everywhere, from the next step on."""
        self.mu = real_number("mu", mu, low=0.0, high=HIGHEST)
        for ground in self._ground:  # Bullet takes the product; the feet have 1
            self._bullet.changeDynamics(ground, -1, lateralFriction=self.mu, **self._here)


def contact_numbers(contact: Mapping[str, Any]) -> dict[str, float]:
    """Return a contact's parameters by Bullet's names; what `translate` says of each body is left out."""
    numbers = {}
    for name, value in contact.items():
        if name == "each_body":  # of two equal bodies: here the foot has all of it
            continue
        check_name("contact parameter", name, GROUND)
        numbers[name] = real_number(name, value, low=0.0)
    return numbers


def urdf_of(scene: dict[str, Any]) -> str:
    """Return the URDF of a scene's joints and contact spheres, with full inertias and no other shapes."""
    import pinocchio

    spheres = [""] * (len(scene["joints"]) + 1)
    for body, place, radius in scene["spheres"]:
        spheres[body] += SPHERE.format(place=_words(place), radius=radius)
    parts = []
    for k, joint in enumerate(scene["joints"], start=1):
        inertia, moments = np.array(joint["inertia"]), ""
        for name, row, column in MOMENTS:
            moments += f'{name}="{float(inertia[row, column])!r}" '
        words = {"k": k, "spheres": spheres[k], "moments": moments, "com": _words(joint["com"])}
        parts.append(LINK.format(mass=joint["mass"], **words))
        if joint["kind"] == "free":
            continue
        low, high = joint["low"], joint["high"]
        words = {"k": k, "kind": joint["kind"], "parent": joint["parent"]}
        words |= {"low": low, "high": high} if low > -np.inf else {"low": 1.0, "high": -1.0}  # no limit
        turn = pinocchio.rpy.matrixToRpy(np.array(joint["rotation"]))
        words |= {"turn": _words(turn), "place": _words(joint["place"]), "axis": _words(joint["axis"])}
        parts.append(JOINT.format(**words))
    text = f'<robot name="robot">{"".join(parts)}</robot>'
    return text.replace("><", ">\n<")  # Bullet reads lines of a thousand characters


def _words(numbers: Any) -> str:
    """Return numbers to the last digit, with blanks between."""
    return " ".join(repr(float(x)) for x in numbers)
