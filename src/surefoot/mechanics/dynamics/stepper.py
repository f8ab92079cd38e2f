"""One step of a robot with hard or soft contacts and exact Coulomb friction, as a function of the state.

Near the ground a step is free motion for half of it, all forces at once, free motion for the other half::

    (q, v) moves dt/2 under no forces;    v⁺ = v + M⁻¹ (dt (τ - g) + Jᵀ λ),    u = J v⁺;    (q, v⁺) moves dt/2

with M, J and gravity g at the middle, and with (λ, u) obeying Signorini, Coulomb and maximum dissipation
exactly (`surefoot.solve`), after Moreau and Jean [1]_. Motion under no forces, with all that whirling limbs
do to each other, is integrated to a tolerance (`motion`): it keeps momentum and kinetic energy. Forces
change momentum by just what they carry, and kinetic energy by their work on the mean of v and v⁺. A robot at
rest does not move. Far from the ground the whole step is free motion under gravity and torques.

The order in dt is two where forces are smooth, one where contacts close, open or turn with a flat sole.

An open contact enters with u_n + gap / dt >= 0, so that a foot that would hit the ground before the next
impulses stops at the surface and does not go below it. Impulses never do positive work where the restitution
is zero and positions are not pulled by velocities.

Soft laws (`soft_impacts`) take the place of Signorini's at the same point of the step.

Joints are ideal torque sources without friction, rotor inertia or stops; only the feet's spheres touch
the ground, or with a `Geometry` all of a robot and other bodies, and each other (`pair_detection`). A sphere
on curved ground sees the tangent plane below its centre.

References
----------
.. [1] J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; M. Jean, "The
   non-smooth contact dynamics method", CMAME 177, 1999.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError, SimulationError
from surefoot.base.numerics.vectors import finite_vector, largest
from surefoot.contact import ContactProblem, ContactSolution, solve
from surefoot.mechanics.collision import Geometry
from surefoot.mechanics.dynamics.arithmetic import FASTEST
from surefoot.mechanics.dynamics.detection import Contacts, Surfaces
from surefoot.mechanics.dynamics.free_bodies import bodies_of
from surefoot.mechanics.dynamics.free_motion import moved
from surefoot.mechanics.dynamics.impacts import LostMotion, Meeting, Tally, finite_problem
from surefoot.mechanics.dynamics.located_impacts import touching_step
from surefoot.mechanics.dynamics.options import StepOptions
from surefoot.mechanics.dynamics.pair_impacts import PairMeeting
from surefoot.mechanics.dynamics.soft_impacts import SoftMeeting
from surefoot.mechanics.dynamics.state import Impact, State, Step, StepRemainder, grown
from surefoot.mechanics.robot import Robot
from surefoot.mechanics.terrain import FlatTerrain, Terrain

REACH = 1e-3
"""Contacts that free motion brings closer than this enter the contact problem [m]."""
SLOP = 1e-6
"""Penetration that the projection leaves alone [m]."""
NUDGE = 1e-6
"""Half of the difference of the ground's friction that says what the rule of two surfaces makes of it."""
PROJECTIONS = 10
"""Most projections of one step; each is a Newton step on the gaps."""


class Stepper:
    """Takes steps of a robot or a body on a terrain: a state goes in, a `Step` with the next one comes out.

    The result depends on the arguments alone, so that a step can be taken twice, from elsewhere, or to try
    something; the object only keeps models and work arrays (one per thread).

    Parameters
    ----------
    robot
        From `load_robot`, or a body of `worlds.rigid.bodies`.
    terrain
        None for flat ground.
    options
        None for the defaults of `StepOptions`.
    payload, payload_position
        Point mass fixed to the base [kg], and where: (3,) base axes [m].
    geometry
        What else may touch than feet on the ground: other links, bodies, each other; None for feet alone.

    Raises
    ------
    ProblemError
        For a payload that is negative or not a number, and a geometry together with a soft law or
        order 1.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> stepper = Stepper(load_robot("go2"))
    >>> state = stepper.start()
    >>> step = stepper.step(state, np.zeros(12))
    >>> step.state.steps, step.forces.shape, step.problem.law
    (1, (4, 3), 'coulomb')
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        options: StepOptions | None = None,
        payload: float = 0.0,
        geometry: Geometry | None = None,
        payload_position: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self.robot, self.options = robot, options or StepOptions()
        self.terrain = FlatTerrain() if terrain is None else terrain
        of_kind("terrain", self.terrain, Terrain)
        if geometry is not None and self.options.soft is not None:
            raise ProblemError("soft laws are of feet on the ground; a geometry's contacts are rigid")
        if geometry is not None and self.options.order == 1:
            raise ProblemError("order=1 is of feet on the ground, not of a geometry")
        load = real_number("payload", payload, low=0.0)
        self.bodies = bodies_of(robot, self.terrain, load, geometry, self.options.dt, payload_position)
        self.geometry = geometry
        rigid = Meeting if geometry is None else PairMeeting
        self._meeting = rigid if self.options.soft is None else SoftMeeting
        self._still = np.zeros(self.bodies.model.nv)
        self._seen: tuple[FloatArray, Contacts] | None = None
        self.kept: dict[type, Any] = {}
        """Work arrays of its derivatives, by whose they are."""

    @property
    def _foot(self) -> IntArray:
        """(p,) what each contact belongs to; pairs of many bodies join in when they come near."""
        return self.bodies.contacts.group

    @property
    def motors(self) -> slice:
        """The velocities that the torques act on."""
        first = self.robot.base_dof
        return slice(first, first + self.robot.joints)

    def start(self, q: FloatArray | None = None, v: FloatArray | None = None) -> State:
        """Return the state at q (nq,) (None: nominal) and v (nv,) [m/s, rad/s] (None: rest), no history."""
        nv = self.bodies.model.nv
        rest = np.zeros(nv) if v is None else finite_array("v", v, (nv,))
        return State(self.robot.configuration(q), rest)

    def contacts(self, state: State) -> Contacts:
        """Return the contact points at a state.

        Raises
        ------
        SimulationError
            Where a gap is not finite.
        """
        try:
            seen = self.detect(state.q)
        except LostMotion as lost:
            raise self.told(str(lost), state) from None
        return seen.kept()

    def energy(self, state: State) -> float:
        """Return kinetic plus potential energy [J], zero potential at z = 0; see also `stored`."""
        return self.bodies.energy(state.q, state.v)

    def stored(self, step: Step) -> float:
        """Return the elastic energy of soft contacts [J] after a step, where its velocities lead.

        That is the middle of the next step, the end of the span on which the step's forces act: so counted,
        implicit contacts never make energy beyond normal impulses times g dt / 2.
        """
        law = self.options.soft
        ahead = step.gaps + step.dt * step.velocities[:, 2]
        return 0.0 if law is None else float(law.energy(ahead).sum())

    def step(
        self, state: State, torques: FloatArray, push: FloatArray | None = None, mu: float = 0.6
    ) -> Step:
        """Return the step of `dt` under (joints,) torques [N m] and a (3,) push on the base [N], world axes.

        The push goes through the centre of mass of the base's own link. `mu` is the friction of the ground.

        Raises
        ------
        ProblemError
            For torques or a push of the wrong shape, or not finite.
        SimulationError
            Where the motion cannot be resolved or stops being finite.
        """
        effort = np.zeros(self.bodies.model.nv)
        effort[self.motors] = finite_vector("torques", torques, self.robot.joints)
        if push is not None:
            push = finite_vector("push", push, 3)
        try:
            first_order, located, flown = self.options.order == 1, self.locates(mu), None
            if push is None and state.airborne and (located or not first_order):
                flown = self._fly(state, effort)
                if located and flown is None:
                    flown = touching_step(self, state, effort, mu)
            take = self.take_first_order if first_order else self.meet_ground
            return flown or take(state, effort, push, mu)
        except LostMotion as lost:
            raise self.told(str(lost), state) from None

    def locates(self, mu: float) -> bool:
        """Return whether impacts are located on ground of friction `mu`, see `StepOptions.impacts`."""
        options = self.options
        if options.impacts != "auto" or options.soft is not None:
            return options.impacts == "located" and options.soft is None
        surfaces = self.surfaces(mu)
        return options.restitution > 0.0 if surfaces is None else bool(surfaces.restitution.any())

    def _fly(self, state: State, effort: FloatArray) -> Step | None:
        """Return the step through the air; None if a foot may touch the ground."""
        dt, v, still = self.options.dt, state.v, self._still
        start = self.detect(state.q)
        if start.near(v, v, 2.0 * dt, REACH).size:
            return None
        velocities = start.velocities(v)
        q, v, _ = moved(self.bodies.flight, state.q, v, dt, effort)
        end = self.detect(q)
        # The next impulses act half a step later: who would be in the ground by then needs its own impulses
        # first.
        if end.near(v, still, 0.5 * dt, 0.0).size:
            return None
        nothing = np.zeros(velocities.shape)
        after = State(q, v, state.steps + 1, StepRemainder(nothing, velocities, True))
        return Step(after, dt, nothing, velocities, start.gaps, start.positions, None, 0, 0.0)

    def take_first_order(self, state: State, effort: FloatArray, push: FloatArray | None, mu: float) -> Step:
        """Return the step of semi-implicit Euler: all forces at the start, then the way with what they leave.

        The effort is (nv,) [N, N m], the push on the base (3,) [N]. The laws hold for the gaps at its end, as
        far as these are linear: gap + dt u_n.
        """
        bodies, dt, tally, (q, v) = self.bodies, self.options.dt, Tally(), state[:2]
        contacts = self.detect(q)
        bodies.weigh(q)
        free = self._free(v, effort, push, bodies.bias(q, v), dt)
        near = contacts.near(v, free, dt, REACH)
        meeting = Meeting(q, v, free, contacts, self._foot, bodies.L, dt, mu, self.options, tally)
        nothing = np.zeros(contacts.positions.shape)
        impact = meeting.collide(near, nothing, nothing)
        ahead = bodies.moved(q, dt * impact.after)
        if not largest(ahead) < np.inf:
            raise LostMotion("motion")
        after = State(ahead, impact.after, state.steps + 1)
        return Step(after, dt, impact.impulses, impact.velocities, contacts.gaps, contacts.positions, impact,
                    tally.unsolved, tally.worst)  # fmt: skip

    def _free(
        self, v: FloatArray, effort: FloatArray, push: FloatArray | None, against: FloatArray, dt: float
    ) -> FloatArray:
        """Return the velocity (nv,) after all forces but the ground's."""
        free = self.bodies.free_velocity(v, effort, push, against, dt)
        if not largest(free) < FASTEST:
            raise LostMotion("velocity under the given torques")
        return free

    def meet_ground(
        self, state: State, effort: FloatArray, push: FloatArray | None, mu: float,
        seconds: float | None = None,
    ) -> Step:  # fmt: skip
        """Return the step with the forces of gravity, motors, push and ground in its middle.

        `effort` are the motors' generalised forces (nv,); `seconds` its length [s], None for the options'.
        """
        bodies, dt, tally = self.bodies, seconds or self.options.dt, Tally()
        v, last, leaving, arrival = self._arrive(state, mu, tally)
        # free motion up to the middle
        rate = state.rate if v is state.v else None
        q, before, _ = moved(bodies.coasting, state.q, v, 0.5 * dt, rate=rate)
        contacts = self.detect(q)
        bodies.weigh(q)
        if self.options.stabilisation == "projection":
            q, contacts = self._project_out(q, contacts)
        # all forces but the ground's
        free = self._free(before, effort, push, bodies.gravity(q), dt)
        # the ground's
        last, leaving = grown(last, len(contacts.gaps)), grown(leaving, len(contacts.gaps))
        if state.memory is not None and state.memory.pace != 1.0:  # what changed, over as much time as comes
            arriving = contacts.velocities(before)
            leaving = arriving - state.memory.pace * (arriving - leaving)
        near = contacts.near(before, free, dt, REACH)
        impact = self.meeting(q, before, free, contacts, dt, mu, tally).collide(near, last, leaving)
        impulses = impact.impulses
        if arrival is not None:
            impulses = impulses + grown(arrival, len(impulses))
        # free motion to the end
        q, v, rate = moved(bodies.coasting, q, impact.after, 0.5 * dt)
        memory = StepRemainder(impulses, impact.leaving, not near.size, rate, q, v)
        return Step(
            State(q, v, state.steps + 1, memory), dt, impulses, impact.means, contacts.gaps,
            contacts.positions, impact, tally.unsolved, tally.worst, tally.law_error,
        )  # fmt: skip

    def _arrive(
        self, state: State, mu: float, tally: Tally
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray | None]:
        """Return v, the last impulses, the velocities after them (p, 3), and impulses of a start's own.

        Of a state without history, what would hit the ground before the first impulses is stopped first.
        """
        if state.memory is not None:
            return state.v, state.memory.impulses, state.memory.leaving, None
        nothing, impact = np.zeros((len(self._foot), 3)), self.stopped(state, mu, tally)
        if impact is None:
            return state.v, nothing, nothing, None
        return impact.after, nothing, impact.leaving, impact.impulses

    def stopped(self, state: State, mu: float, tally: Tally) -> Impact | None:
        """Return what stops a start that would hit the ground before the first impulses, if it would."""
        if state.memory is not None or self.options.soft is not None:  # soft ground takes what arrives
            return None
        contacts, soon = self.detect(state.q), 0.5 * self.options.dt
        nothing = np.zeros((len(self._foot), 3))
        near = contacts.near(state.v, self._still, soon, 0.0)
        if not near.size:
            return None
        self.bodies.weigh(state.q)
        meeting = self.meeting(state.q, state.v, state.v, contacts, soon, mu, tally)
        return meeting.collide(near, nothing, nothing)

    def meeting(
        self, q: FloatArray, before: FloatArray, free: FloatArray, contacts: Contacts, horizon: float,
        mu: float, tally: Tally,
    ) -> Meeting:  # fmt: skip
        """Return who is about to exchange impulses at (nq,) q, see `Meeting`; M is of the last `weigh`."""
        options, foot, surfaces = self.options, self._foot, self.surfaces(mu)
        L, kind = self.bodies.L, self._meeting
        return kind(q, before, free, contacts, foot, L, horizon, mu, options, tally, surfaces)

    def surfaces(self, mu: float) -> Surfaces | None:
        """Return the surfaces of the contacts seen last, on ground of friction `mu`."""
        return self.bodies.contacts.surfaces(mu, self.options.restitution)

    def friction_rates(self, mu: float) -> FloatArray:
        """Return how the friction of all contacts (p,) moves with that of the ground, about `mu`."""
        low, high = (self.surfaces(m) for m in (max(mu - NUDGE, 0.0), mu + NUDGE))
        if low is None or high is None:
            return np.ones(len(self._foot))
        return np.asarray((high.friction - low.friction) / (mu + NUDGE - max(mu - NUDGE, 0.0)))

    def _project_out(self, q: FloatArray, contacts: Contacts) -> tuple[FloatArray, Contacts]:
        """Return q and contacts moved out of the ground where they are in it by more than `SLOP`.

        Minimises ||dq||_M subject to gap + J_n dq >= 0: a frictionless contact problem in positions.
        """
        for _ in range(PROJECTIONS):
            out = self.pushed_out(q, contacts)
            if out is None:
                break
            q = self.bodies.moved(q, out.after)
            contacts = self.detect(q)
            self.bodies.weigh(q)
        return q, contacts

    def pushed_out(self, q: FloatArray, contacts: Contacts) -> Impact | None:
        """Return the least motion out of the ground, as impulses from rest over a second; None if q is out.

        q is (nq,). The mass matrix is that of the last `Bodies.weigh`.
        """
        if contacts.gaps.min(initial=0.0) >= -SLOP:
            return None
        L, still, near = self.bodies.L, self._still, np.flatnonzero(contacts.gaps < REACH)
        rows, G, g = contacts.assemble(L, still, still, contacts.gaps, near, 1.0, 1.0)
        solution = solve(finite_problem(G, g, 0.0), self.options.solver, 1e-6)
        pushes = np.zeros(contacts.positions.shape)
        pushes[near] = solution.forces
        way = contacts.apply(L, rows, solution.forces, still)
        velocities = contacts.velocities(way)
        return Impact(q, still, still, way, near, rows, pushes, velocities, velocities, solution)

    def solve(self, problem: ContactProblem, warm: FloatArray) -> ContactSolution:
        """Return the solution of a contact problem as `options` ask for it, from (k, 3) impulses [N s]."""
        return solve(problem, self.options.solver, self.options.solver_tol, warm_start=warm)

    def detect(self, q: FloatArray) -> Contacts:
        """Return the contacts at (nq,) q [m, -, rad], in work arrays; the last call's where q is the same."""
        if self._seen is not None and self._seen[0] is q:
            return self._seen[1]
        self._seen = None
        contacts = self.bodies.contacts.at(q)
        if not largest(contacts.gaps) < np.inf:
            raise LostMotion("gap between feet and ground")
        self._seen = q, contacts
        return contacts

    def told(self, what: str, state: State) -> SimulationError:
        """Return the error for a state that cannot go on; it names the joint that moved fastest before."""
        joint, speed = self.bodies.fastest_joint(state.v)
        return SimulationError(what, state.steps * self.options.dt, self.options.dt, joint, speed)
