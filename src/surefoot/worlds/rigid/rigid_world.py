"""A world of rigid bodies: hard or soft contacts with exact Coulomb friction, a contact problem per step.

A run of steps of `mechanics.dynamics`; the scheme and what it keeps are described in `dynamics/stepper.py`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import NamedTuple, Unpack

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.memory import Remade
from surefoot.base.numerics.vectors import finite_vector
from surefoot.contact import ContactSolution, stopping_depth
from surefoot.mechanics import (
    Actuators,
    ErrorControl,
    Geometry,
    Robot,
    State,
    Step,
    StepDerivative,
    StepOptions,
    Stepper,
    StepSettings,
    Terrain,
    robot_geometry,
    step_derivative,
)
from surefoot.records import Log
from surefoot.worlds.interface.actuated import JointFriction, equipped
from surefoot.worlds.interface.world import ContactReading
from surefoot.worlds.interface.world_state import WorldState
from surefoot.worlds.rigid.resuming import read_rigid_state, rigid_state
from surefoot.worlds.rigid.rollout_record import RECORDER

COLLISIONS: dict[str, Callable[[Robot], Geometry | None]] = {
    "feet": lambda robot: None,
    "full": robot_geometry,
}
"""What may touch, by name."""


class BodyTouch(NamedTuple):
    """A contact that carries a force.

    Attributes
    ----------
    body, other
        Names of what is touched: feet, links' solids, bodies; "ground" for the terrain.
    gap
        Distance [m], negative in penetration.
    position
        (3,) place of the contact [m], world axes.
    normal
        (3,) unit normal out of `other` into `body`, world axes.
    force
        (3,) on `body`, world axes [N]; the other has it the other way round.
    """

    body: str
    other: str
    gap: float
    position: FloatArray
    normal: FloatArray
    force: FloatArray


def chosen_geometry(robot: Robot, collision: str | Geometry) -> Geometry | None:
    """Return what may touch besides feet and ground, None for nothing; a scene knows its own.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    own = getattr(robot, "geometry", None) if isinstance(collision, str) else collision
    if own is not None or not isinstance(collision, str):
        return own
    check_name("collision", collision, COLLISIONS)
    return COLLISIONS[collision](robot)


class RigidWorld(Remade):
    """A robot or a simple body on a terrain; see `surefoot.worlds.interface.world.World` for the methods.

    Parameters
    ----------
    robot
        From `load_robot`, or a body of `worlds.rigid.bodies`.
    terrain
        None for flat ground.
    mu
        Friction of the ground [-]; None for that of a soft law, else 0.6.
    dt
        Length of a step [s].
    payload, payload_position
        Point mass fixed to the base [kg], unknown to any controller, and where: (3,) base axes [m].
    collision
        What may touch: "feet" on the ground alone, or "full", all of the robot's collision geometry with the
        ground and with itself; or a `Geometry` of `surefoot.mechanics.collision`.
    actuators
        Its motors: "ideal", "real", or a value; see `surefoot.mechanics.robot.actuators`.
    tol
        Error of the state [m, rad] and [m/s, rad/s] for which each step of `dt` is divided as often as that
        takes, see `surefoot.mechanics.dynamics.error_control`; None for steps of `dt`.
    **settings
        ``restitution``, ``stabilisation``, ``law``, ``solver``, ``solver_tol``, ``order`` and
        ``impacts`` of `dynamics.StepOptions`; a law of `surefoot.laws` makes the ground soft,
        None is rigid.

    Attributes
    ----------
    stepper
        What takes the steps.
    control
        What divides them, with the error that it estimates; None without a `tol`.
    applied
        (joints,) torques that the motors gave in the last step [N m].
    model
        Pinocchio's Model of what is simulated, the payload included.
    last
        `Step` taken last, None before the first.
    unsolved
        Steps so far whose contact problem was left above the tolerance.
    worst_residual
        Largest velocity error so far, see `Residuals`.
    law_error
        Largest distance of normal forces from a soft law so far, as a share of the largest force.

    Raises
    ------
    ProblemError
        For a value out of range, an unknown stabilisation or collision, and soft ground under a whole robot.

    Examples
    --------
    >>> from surefoot.laws import SpringDamper
    >>> from surefoot.worlds.rigid.bodies import ball
    >>> world = RigidWorld(ball(4.0, 0.1), law=SpringDamper(2e4, 400.0))
    >>> for _ in range(1000):
    ...     world.step(np.zeros(0))
    >>> round(-1e3 * float(world.contacts().gaps[0]), 6)  # rest depth [mm], m g / k
    1.962
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float | None = None,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        collision: str | Geometry = "feet",
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
        actuators: str | Actuators = "ideal",
        tol: float | None = None,
        **settings: Unpack[StepSettings],
    ) -> None:
        if not hasattr(robot, "model"):
            of_kind("robot", robot, Robot)
        self.actuators: Actuators | None = None
        if actuators != "ideal":  # a body of `worlds.rigid.bodies` has no joints to ask about
            robot, self.actuators = equipped(robot, actuators)
        options = StepOptions.of(dt, settings)
        own = 0.6 if options.soft is None else options.soft.friction.mu
        self.set_friction(own if mu is None else mu)
        recorder = RECORDER.get()
        parts = robot, terrain, options, payload, collision, payload_position
        known = None if recorder is None else recorder.find_stepper(*parts)
        # while a gradient is taken, later rollouts take its stepper and its states: see `RolloutRecorder`
        self.stepper = known or Stepper(
            robot, terrain, options, payload, chosen_geometry(robot, collision), payload_position
        )
        self.control = None if tol is None else ErrorControl(self.stepper, tol)
        self.robot, self.terrain, self.dt = robot, self.stepper.terrain, options.dt
        self.model = self.stepper.bodies.model
        self.payload = payload if robot.floating else 0.0
        self.payload_position = finite_array("payload_position", payload_position, (3,))
        self.contact_foot = robot.contact_points.foot
        self.applied = np.zeros(robot.joints)
        self._friction = None if self.actuators is None else JointFriction(robot, self.actuators, self.dt)
        self.reset(robot.nominal)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._state.steps * self.dt

    @property
    def solution(self) -> ContactSolution | None:
        """Solution of the last step (impulses [N s]); None before the first and without contacts."""
        return None if self.last is None else self.last.solution

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q [m, -, rad], (nv,) v [m/s, rad/s] in Pinocchio's order, at time 0."""
        self._state: State = self.stepper.start(q, v)
        if (recorder := RECORDER.get()) is not None:
            self._state = recorder.place_start(self._state)
        if self.control is not None:
            self.control.restart()
        self._start = self.stepper.contacts(self._state)
        self._resumed: WorldState | None = None
        self.last: Step | None = None
        self.unsolved, self.worst_residual, self.law_error = 0, 0.0, 0.0

    @property
    def state(self) -> WorldState:
        """A copy of all that lasts from one step to the next, the solver's warm start included."""
        return rigid_state(self, self._state)

    def resume(self, state: WorldState) -> None:
        """Go on from a state of a world that was made in the same way.

        What the ground did in the last step can be read; its single contacts (`touches`) and its derivative
        are gone.

        Raises
        ------
        ProblemError
            For a state of another world; nothing has changed.
        """
        read = read_rigid_state(self, self._state, state)
        own = state.own
        self.set_friction(own["mu"])
        if self.control is not None:
            self.control.resume(own["control"])
        self._state, self.last, self._resumed = read, None, copy.deepcopy(state)
        self._start, self.applied = self.stepper.contacts(read), state.applied.copy()
        self.unsolved, self.worst_residual, self.law_error = own["found"]

    def q_v(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) [m, -, rad] and v (nv,) [m/s, rad/s] in Pinocchio's order."""
        return self._state.q.copy(), self._state.v.copy()

    def softness(self, log: Log) -> dict[str, float]:
        """Return how deep a soft law lets feet sink in a run [m], as `sinking`; nothing on rigid ground.

        As deep as the law alone, undamped, stops the whole mass on one contact at the speed of the hardest
        touchdown, under its weight.
        """
        law = self.stepper.options.soft
        if law is None:
            return {}
        mass = self.robot.mass + self.payload
        # Touchdowns: a foot gets a load that it had not in the row before, where it still had its speed.
        loaded = np.asarray(log["forces"])[..., 2] > 0.0
        landing = loaded & ~np.concatenate([loaded[:1], loaded[:-1]])
        before = np.concatenate([np.asarray(log["contact_velocities"])[:1], log["contact_velocities"][:-1]])
        speed = float(np.max(-before[..., 2], where=landing, initial=0.0))
        return {"sinking": stopping_depth(law, mass, speed)}

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground [-] everywhere, from the next step on."""
        self.mu = real_number("mu", mu, low=0.0)

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) push on the base [N], world axes.

        The push goes through the centre of mass of the base's own link.

        Raises
        ------
        ProblemError
            For torques or a push of the wrong shape, or not finite. Nothing has moved.
        SimulationError
            Where the motion cannot be resolved or stops being finite. The world stays in the state before
            the step.
        """
        if (recorder := RECORDER.get()) is not None:
            known = recorder.before(self, torques, push)
            if known is not None:
                self._state = known
                return
        torques = self._net(torques)
        self.last = step = (self.control or self.stepper).step(self._state, torques, push, self.mu)
        self._resumed = None
        pushed = None if push is None else np.array(push, dtype=np.float64)
        # What `derivative` differentiates: copies, as callers may write into their arrays between steps.
        self._given = self._state, np.array(torques, dtype=np.float64), pushed, self.mu
        if recorder is not None:
            recorder.after(self._state, step)
        self._state = step.state
        self.unsolved += step.unsolved
        self.worst_residual = max(self.worst_residual, step.worst_residual)
        self.law_error = max(self.law_error, step.law_error)

    def _net(self, torques: FloatArray) -> FloatArray:
        """Return the torques that move the joints, of those asked for; note what the motors give."""
        self.applied = torques
        if self.actuators is None or self._friction is None:
            return torques
        speed = self._state.v[self.robot.base_dof :]
        self.applied = self.actuators.given(finite_vector("torques", torques, self.robot.joints), speed)
        # Friction of the joints is no torque of the motors: `applied` is without.
        return self.applied + self._friction.torques(speed)

    def contacts(self) -> ContactReading:
        """Return what the ground did to the feet during the last step, and the sum of all else.

        All contacts one by one are in `touches`.

        Forces are impulses over dt; velocities are the means until the next impulses, which the contact laws
        tie to the forces; gaps and positions are those at the impulses, the middle of the step. For a step
        without contacts velocities, gaps and positions are those at its start.
        """
        p, step, start = len(self.contact_foot), self.last, self._start
        if self._resumed is not None:
            return copy.deepcopy(self._resumed.reading)
        if step is None:
            velocities = start.velocities(self._state.v)
            seen = np.zeros(velocities.shape), start.gaps, velocities, start.positions
        else:
            seen = step.forces, step.gaps, step.velocities, step.positions
        forces, gaps, velocities, positions = (a[:p].copy() for a in seen)
        return ContactReading(forces, gaps, velocities, positions, self._others())

    def _others(self) -> FloatArray | None:
        """Return the generalised force (nv,) of contacts that are not feet on the ground [N, N m]."""
        step, p = self.last, len(self.contact_foot)
        if self.stepper.geometry is None:
            return None
        if step is None or step.impact is None or not step.impulses[p:].any():
            return np.zeros(self.model.nv)
        # Impulses act where the impact was, in the frames of there: Σ Jᵀ f of what is not a foot on the
        # ground.
        contacts = self.stepper.contacts(State(step.impact.q, step.impact.after))
        forces = np.zeros((len(contacts.gaps), 3))
        forces[p : len(step.forces)] = step.forces[p:]
        return contacts.effort(forces)

    def touches(self) -> list[BodyTouch]:
        """Return every contact that carried a force in the last step: feet, other links, bodies."""
        step, contacts = self.last, self.stepper.bodies.contacts
        if step is None or step.impact is None:
            return []
        frames = self.stepper.contacts(State(step.impact.q, step.impact.after)).frames
        out = []
        for k in np.flatnonzero(np.abs(step.impulses).max(axis=1, initial=0.0)).tolist():
            body, other = contacts.names[contacts.group[k]]
            force, normal = frames[k] @ step.impulses[k] / step.dt, frames[k, :, 2].copy()
            out.append(BodyTouch(body, other, float(step.gaps[k]), step.positions[k].copy(), normal, force))
        return out

    def touching(self) -> list[tuple[str, str]]:
        """Return names of bodies, feet or ground that touched in the last step, without feet on ground."""
        if self._resumed is not None:
            return list(self._resumed.touching)
        feet = set(self.robot.foot_names)
        pairs = [(touch.body, touch.other) for touch in self.touches()]
        return [(a, b) for a, b in pairs if not (a.split(":")[0] in feet and b == "ground")]

    def derivative(self, smoothing: float = 0.0) -> StepDerivative:
        """Return the derivative of the last step, see `StepDerivative` and `stepping.step_derivative`.

        Raises
        ------
        ProblemError
            Before the first step, with a `tol` or actuators; with smoothing where more than feet may touch.
        NoSolution
            If the step's contact problem is not SOLVED.
        """
        if self.last is None:
            raise ProblemError("there is no step to differentiate before the first step")
        self.check_differentiable()
        return step_derivative(self.stepper, *self._given, smoothing, step=self.last)

    def check_differentiable(self) -> None:
        """Refuse a world whose steps have no derivative: with a `tol`, or real motors."""
        if self.control is not None:
            raise ProblemError("steps are differentiated at a length of their own, not with a tol")
        if self.actuators is not None:
            raise ProblemError(
                'steps are differentiated with actuators="ideal", not with motors and friction'
            )

    def energy(self) -> float:
        """Return kinetic plus potential energy [J], zero potential at z = 0, and what soft contacts store.

        See `Stepper.stored`; before the first step soft contacts store what their overlap does.
        """
        if self._resumed is not None:
            return float(self._resumed.own["energy"])
        energy, law = self.stepper.energy(self._state), self.stepper.options.soft
        if law is None:
            return energy
        start = law.energy(self._start.gaps).sum() if self.last is None else self.stepper.stored(self.last)
        return energy + float(start)

    def contact_work(self) -> float:
        """Return the work of the ground's impulses during the last step [J], see `Step.contact_work`."""
        if self._resumed is not None:
            return float(self._resumed.own["work"])
        return 0.0 if self.last is None else self.last.contact_work
