"""A Drake world made from the Pinocchio model itself, in a process of Drake's own.

Drake's conventions stop in this file: quaternions (w, x, y, z) before places, base velocity [angular;
linear] in world axes. Joints are ideal torque sources without friction or rotor inertia; only the feet's
spheres touch the ground, in Drake's point contact.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, real_number
from surefoot.base.errors import ModelError, ProblemError, check_name, shown
from surefoot.base.numerics.vectors import finite_vector
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot, Terrain
from surefoot.worlds.drake.drake_python import Worker
from surefoot.worlds.interface.engine_world import HIGHEST, LARGEST, EngineWorld

WORKER = Path(__file__).with_name("drake_worker.py")
APPROXIMATIONS = ("sap", "lagged", "similar", "tamsi")
STEPS_OF_GROUND = 4.0
"""Period of the robot's whole mass on one contact, in steps: as stiff as keeps Drake's iterations quick."""
SLIP = 0.1
"""Speed below which friction counts as sticking, over the step [m/s²]; Drake's own, 1e-4 m/s, at 1 ms."""
STICTION = 1e-4
"""Drake's stiction tolerance [m/s]."""
MATERIAL = ("point_contact_stiffness", "hunt_crossley_dissipation", "relaxation_time")
"""Drake's proximity properties that its point contact reads."""


def near_rigid(mass: float, dt: float) -> dict[str, Any]:
    """Return contact parameters in Drake's words for ground as hard as a step of `dt` [s] takes well.

    A `mass` [kg] on one contact would swing with `STEPS_OF_GROUND` steps a period, damped within a step.
    The approximation is SAP, whose forces stay in their cones; "lagged", Drake's own choice, takes the normal
    force of the step before, and feet that chatter then pull with several times mu.
    """
    stiffness = mass * (2.0 * np.pi / (STEPS_OF_GROUND * dt)) ** 2
    return {
        "discrete_contact_approximation": "sap",
        "each_body": {"point_contact_stiffness": 2.0 * stiffness, "relaxation_time": 0.5 * dt},
        "stiction_tolerance": SLIP * dt,
    }


class DrakeWorld(EngineWorld):
    """A robot on a terrain in Drake; see `surefoot.worlds.interface.world.World` for the methods.

    Parameters
    ----------
    robot
        Who stands.
    terrain
        None for flat ground; planes and boxes (steps) only.
    mu
        Friction of the ground.
    dt
        Length of a step [s].
    payload, payload_position
        Point mass fixed to the base [kg], unknown to any controller, and where: (3,) base axes [m].
    contact
        Softness in Drake's own words, as `surefoot.translate(law, "drake", mass).parameters` has them:
        "discrete_contact_approximation" and the proximity properties of "each_body", and "stiction_tolerance"
        [m/s] if it is not to be Drake's own. None for ground as hard as
        a step of `dt` takes well, see `near_rigid`.

    Raises
    ------
    MissingExtra
        If Drake is neither here nor in an interpreter that SUREFOOT_DRAKE_PYTHON names.
    ProblemError
        For a contact that Drake does not have, or numbers out of range.
    ModelError
        For a terrain or a joint that this world does not build, or Drake's own complaint.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        contact: Mapping[str, Any] | None = None,
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self._worker, self._closed = Worker(WORKER), False
        super().__init__(robot, terrain, dt, payload, payload_position)
        self.mu = real_number("mu", mu, low=0.0, high=HIGHEST)
        chosen = near_rigid(robot.mass + self.payload, self.dt) if contact is None else contact
        scene = self._scene | {"dt": self.dt, "mu": self.mu, **contact_words(chosen)}
        scene["near_rigid"] = None if contact is None else 0.0
        self._worker.ask(["scene", scene])
        self.reset(robot.nominal)

    def close(self) -> None:
        """End Drake's process; the world can be asked where it is, but takes no further step."""
        self._closed = True
        self._worker.close()

    def _ask(self, task: list[Any]) -> dict[str, Any]:
        """Return Drake's answer."""
        if self._closed:
            raise ModelError("this drake world is closed; make another one")
        return self._worker.ask(task)

    def _place(self) -> None:
        """See `EngineWorld`."""
        self._ask(["reset", *self._drakes()])

    def _drakes(self) -> tuple[list[float], list[float]]:
        """Return the state in Drake's order."""
        q, v = self._q.copy(), self._v.copy()
        if self.robot.floating:
            x, y, z, *turn, w = self._q[:7].tolist()
            q[:7] = (w, *turn, x, y, z)
            R = rotation_from_quaternion(self._q[3:7])
            v[:3], v[3:6] = R @ self._v[3:6], R @ self._v[:3]
        return q.tolist(), v.tolist()

    def _ours(self, answer: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
        """Return q and v of an answer in Pinocchio's order."""
        q, v = np.array(answer["q"]), np.array(answer["v"])
        if self.robot.floating:
            w, *turn = (q[:4] / np.linalg.norm(q[:4])).tolist()
            q[:7] = (*answer["q"][4:7], *turn, w)
            R = rotation_from_quaternion(q[3:7])
            v[:3], v[3:6] = R.T @ answer["v"][3:6], R.T @ answer["v"][:3]
        return q, v

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) force on the base [N], world axes.

        Raises
        ------
        ProblemError
            For torques or a push of the wrong shape, or not finite. Nothing has moved.
        SimulationError
            Where Drake's solver fails, or the state is lost. The world stays in the state before the step.
        """
        effort = np.zeros(self.robot.model.nv)
        effort[self.robot.base_dof :] = finite_vector("torques", torques, self.robot.joints)
        if push is not None and self.robot.floating:
            force = finite_vector("push", push, 3)
            lever = rotation_from_quaternion(self._q[3:7]) @ self._stepper.bodies.lever
            effort[:3], effort[3:6] = np.cross(lever, force), force
        try:
            answer = self._ask(["step", effort.tolist()])
        except ModelError as error:
            if self._closed:
                raise
            raise self._undo_step() from error
        q, v = self._ours(answer)
        if not np.abs(v).max(initial=0.0) < LARGEST:
            raise self._undo_step()
        self._q, self._v, self._steps = q, v, self._steps + 1
        # all is of the step's end, to which Drake's implicit step ties its forces
        self._seen = self._stepper.contacts(self._stepper.start(q))
        self._rates, self._forces = self._seen.velocities(v), self._read(answer["contacts"])

    def _read(self, contacts: list[list[float]]) -> FloatArray:
        """Return forces (p, 3) in the terrain's frames: normal parts are those along Drake's own normals."""
        forces = np.zeros((len(self.contact_foot), 3))
        frames = self._seen.frames
        for row, *numbers in contacts:
            k, force, normal = int(row), np.array(numbers[:3]), np.array(numbers[3:])
            along = float(force @ normal)
            forces[k] += frames[k].T @ (force - along * normal)
            forces[k, 2] += along
        return forces

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-] everywhere, from the next step on."""
        wanted = real_number("mu", mu, low=0.0, high=HIGHEST)
        if wanted != self.mu:
            self._ask(["friction", wanted])
            self.mu = wanted


def contact_words(contact: Mapping[str, Any]) -> dict[str, Any]:
    """Return a contact's approximation and material as the worker takes them."""
    if not isinstance(contact, Mapping) or not isinstance(contact.get("each_body"), Mapping):
        raise ProblemError(f"contact must be a mapping with one named each_body, got {shown(contact)}")
    approximation = str(contact.get("discrete_contact_approximation"))
    check_name("discrete_contact_approximation", approximation, APPROXIMATIONS)
    material = contact["each_body"]
    for name in material:
        check_name("proximity property", str(name), MATERIAL)  # Drake would take it, and never look at it
    numbers = {name: real_number(name, value, low=0.0) for name, value in material.items()}
    if not 0.0 < numbers.get("point_contact_stiffness", 1.0) < np.inf:
        raise ProblemError(
            f"point_contact_stiffness must be positive and finite, got {numbers['point_contact_stiffness']:g}"
        )
    slip = real_number("stiction_tolerance", contact.get("stiction_tolerance", STICTION), low=1e-12)
    return {"approximation": approximation, "material": numbers, "stiction": slip}
