"""A rigid world: hard contacts with exact Coulomb friction, one contact problem per time step.

Near the ground a step is free motion for half of it, all forces at once, free motion for the other half::

    (q, v) moves dt/2 under no forces;    v⁺ = v + M⁻¹ (dt (τ - g) + Jᵀ λ),    u = J v⁺;    (q, v⁺) moves dt/2

with M, J and gravity g at the middle, and with (λ, u) obeying Signorini, Coulomb and maximum dissipation
exactly (`surefoot.solve`), after Moreau and Jean [1]_. Motion under no forces, with all that whirling limbs
do to each other, is integrated to a tolerance (`rigid_motion`): it keeps momentum and kinetic energy. Forces
change momentum by just what they carry, and kinetic energy by their work on the mean of v and v⁺. A robot at
rest does not move. Far from the ground the whole step is free motion under gravity and torques.

The order in dt is two where forces are smooth, one where contacts close, open or turn with a flat sole.

An open contact enters with u_n + gap / dt >= 0, so that a foot that would hit the ground before the next
impulses stops at the surface and does not go below it. Impulses never do positive work where the restitution
is zero and positions are not pulled by velocities.

Joints are ideal torque sources without friction, rotor inertia or stops; only the feet's spheres touch
the ground; a sphere on curved ground sees the tangent plane below its centre.

References
----------
.. [1] J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; M. Jean, "The
   non-smooth contact dynamics method", CMAME 177, 1999.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from surefoot.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.contact import ContactProblem, ContactSolution
from surefoot.contact.laws import LAWS
from surefoot.errors import ProblemError, SimulationError, unknown_name
from surefoot.robot import Robot
from surefoot.simulation import rigid_step
from surefoot.simulation.rigid_bodies import RigidBodies, finite_vector
from surefoot.simulation.rigid_feet import FeetOnGround
from surefoot.simulation.rigid_motion import FreeMotion
from surefoot.simulation.world import ContactReading
from surefoot.solvers import solve
from surefoot.spatial import GRAVITY
from surefoot.stance import FlatTerrain, Terrain

Stabilisation = Literal["projection", "baumgarte", "none"]
STABILISATIONS: tuple[Stabilisation, ...] = get_args(Stabilisation)

REACH = 1e-3
"""Contacts that free motion brings closer than this enter the contact problem [m]."""
SLOP = 1e-6
"""Penetration that the projection leaves alone [m]."""
PULL = 0.2
"""Share of a penetration that Baumgarte's term takes back per step."""
SWERVE = 1e-6
"""Change of a contact's velocity from impulses to impulses that is worth a guess [m/s]."""
GAIN = 1e-3
"""Energy that this guess may make in a step, as a share of what their load gains in a fall over dt."""
FASTEST = 1e12
"""Velocities beyond this count as lost [m/s, rad/s]."""
PROJECTIONS = 3
"""Most projections of one step; each is a Newton step on the gaps."""


class RigidWorld:
    """A robot or a simple body on a terrain; see `surefoot.simulation.world.World` for the methods.

    Parameters
    ----------
    robot
        From `load_robot`, or a body of `simulation.bodies`.
    terrain
        None for flat ground.
    mu
        Friction of the ground.
    dt
        Length of a step [s].
    payload
        Point mass fixed to the base's origin [kg], unknown to any controller.
    restitution
        Newton's coefficient of restitution of impacts, 0 to 1.
    stabilisation
        What undoes penetration: "projection" moves the robot out by the least motion in the metric of M and
        leaves its velocity alone, "baumgarte" asks for a separating velocity (which adds energy), "none"
        lets it be.
    law
        "coulomb", or "convex" to see what that relaxation does: a sliding contact then separates with
        mu ||u_t||, and floats at dt mu ||u_t|| over the ground.
    solver, tol
        For `surefoot.solve`.

    Attributes
    ----------
    solution
        `ContactSolution` of the last step (impulses [N s]), None before the first and without contacts.
    unsolved
        Steps so far whose contact problem was left above the tolerance.
    worst_residual
        Largest velocity error so far, see `Residuals`.

    Raises
    ------
    ProblemError
        For a value out of range or an unknown stabilisation.
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        mu: float = 0.6,
        dt: float = 1e-3,
        payload: float = 0.0,
        *,
        restitution: float = 0.0,
        stabilisation: Stabilisation = "projection",
        law: str = "coulomb",
        solver: str = "auto",
        tol: float = 1e-8,
    ) -> None:
        if stabilisation not in STABILISATIONS:
            raise ProblemError(unknown_name("stabilisation", stabilisation, STABILISATIONS))
        if law not in LAWS:
            raise ProblemError(unknown_name("law", law, LAWS))
        self.robot, self.dt = robot, real_number("dt", dt, low=1e-6)
        self.terrain = FlatTerrain() if terrain is None else terrain
        self.restitution = real_number("restitution", restitution, low=0.0, high=1.0)
        self.stabilisation, self.law, self.solver, self.tol = stabilisation, law, solver, tol
        self.set_friction(mu)
        self._body = RigidBodies(robot, real_number("payload", payload, low=0.0))
        self.model, self.data, self._L = self._body.model, self._body.data, self._body.L
        self._feet = FeetOnGround(self._body.spheres, self.terrain, self.model, self.data)
        self.contact_foot, self._count = self._body.spheres.foot, len(self._body.spheres.foot)
        self._J, self._frames = self._feet.J, self._feet.frames
        self.reset(robot.nominal)

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._steps * self.dt

    def reset(self, q: FloatArray, v: FloatArray | None = None) -> None:
        """Put the robot at (nq,) q and (nv,) v in Pinocchio's order, at time 0."""
        self._q = self.robot.configuration(q)
        self._v = np.zeros(self.model.nv) if v is None else finite_array("v", v, (self.model.nv,))
        self._steps = self.unsolved = 0
        self.worst_residual = 0.0
        self.solution: ContactSolution | None = None
        self._impulses = np.zeros((self._count, 3))
        self._before = self._q, self._v
        self._place()
        self._airborne = True
        self._seen = self._gaps, self._points
        self._velocities = self._leaving = (self._J @ self._v).reshape(-1, 3)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) and v (nv,) in Pinocchio's order."""
        return self._q.copy(), self._v.copy()

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground everywhere, from the next step on."""
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
        effort = self._effort(torques)
        if push is not None:
            push = finite_vector("push", push, 3)
        before = self._q, self._v, self._impulses.copy(), self._velocities, self._seen, self.solution
        self._before = before[:2]
        try:
            if not (self._airborne and push is None and self._fly(effort)):
                self._meet_ground(effort, push)
        except SimulationError:
            self._q, self._v, self._impulses, self._velocities, self._seen, self.solution = before
            self._airborne = self._placed = False
            raise
        self._steps += 1

    def contacts(self) -> ContactReading:
        """Return what the ground did during the last step.

        Forces are impulses over dt; velocities are the means until the next impulses, which the contact laws
        tie to the forces; gaps and positions are those at the impulses, the middle of the step. For a step
        without contacts velocities, gaps and positions are those at its start.
        """
        gaps, points = self._seen
        return ContactReading(self._impulses / self.dt, gaps.copy(), self._velocities.copy(), points.copy())

    def energy(self) -> float:
        """Return kinetic plus potential energy [J], zero potential at z = 0."""
        return self._body.energy(self._q, self._v)

    def contact_work(self) -> float:
        """Return the work of the ground's impulses during the last step [J].

        λᵀ (u⁺ + u⁻) / 2 with u⁻ the velocity without them; never positive without restitution and
        Baumgarte's term.
        """
        if self.solution is None:
            return 0.0
        impulses = self.solution.forces.ravel()
        power = float(np.sum(self._impulses * self._velocities))
        return power - 0.5 * float(impulses @ self.solution.problem.G @ impulses)

    def _effort(self, torques: FloatArray) -> FloatArray:
        """Return the motors' generalised forces (nv,)."""
        base, out = self.robot.base_dof, np.zeros(self.model.nv)
        out[base:] = finite_vector("torques", torques, self.robot.joints)
        return out

    def _fly(self, effort: FloatArray) -> bool:
        """Take the step through the air; False, with nothing changed, if a foot may touch the ground."""
        if not self._placed:
            self._place()
        v = self._v
        if rigid_step.near_ground(self._J, v, v, self._gaps, 2.0 * self.dt, REACH).size:
            return False
        start, seen, velocities = self._q, (self._gaps, self._points), (self._J @ v).reshape(-1, 3)
        self._move(self._body.flight, self.dt, effort)
        self._place()
        still = np.zeros_like(v)
        if rigid_step.near_ground(self._J, self._v, still, self._gaps, 0.5 * self.dt, 0.0).size:
            self._q, self._v, self._placed = start, v, False
            return False
        self._seen, self._velocities, self.solution = seen, velocities, None
        self._impulses[:] = 0.0
        return True

    def _meet_ground(self, effort: FloatArray, push: FloatArray | None) -> None:
        """Take the step with the forces of gravity, motors, push and ground in its middle."""
        arrival = self._arrive() if self._steps == 0 else None
        self._move(self._body.coasting, 0.5 * self.dt)
        self._place()
        self._weigh()
        if self.stabilisation == "projection":
            self._project()
        free = self._free_velocity(effort, push)
        near = rigid_step.near_ground(self._J, self._v, free, self._gaps, self.dt, REACH)
        self._collide(free, near, self.dt)
        if arrival is not None:
            self._impulses += arrival
        self._seen, self._airborne = (self._gaps, self._points), not near.size
        self._move(self._body.coasting, 0.5 * self.dt)

    def _arrive(self) -> FloatArray | None:
        """Stop what would hit the ground before the first impulses of a run; return the impulses (p, 3)."""
        v, still, soon = self._v, np.zeros(self.model.nv), 0.5 * self.dt
        if not self._placed:
            self._place()
        near = rigid_step.near_ground(self._J, v, still, self._gaps, soon, 0.0)
        if not near.size:
            return None
        self._weigh()
        self._collide(v, near, soon)
        impulses, self._impulses = self._impulses, np.zeros((self._count, 3))
        return impulses

    def _move(self, motion: FreeMotion, seconds: float, effort: FloatArray | None = None) -> None:
        """Move without contacts."""
        ahead = motion.advance(self._q, self._v, seconds, effort)
        if ahead is None or not rigid_step.largest(ahead[0]) < np.inf:
            raise self._lost("motion")
        self._q, self._v = ahead
        self._placed = False

    def _free_velocity(self, effort: FloatArray, push: FloatArray | None) -> FloatArray:
        """Return the velocity after all forces but the ground's."""
        free = self._body.free_velocity(self._q, self._v, effort, push, self.dt)
        if not rigid_step.largest(free) < FASTEST:
            raise self._lost("velocity under the given torques")
        return free

    def _place(self) -> None:
        """Bring placements, gaps and the contact Jacobian up to the present configuration."""
        self._gaps = self._feet.gaps(self._q)
        if not rigid_step.largest(self._gaps) < np.inf:
            raise self._lost("gap between feet and ground")
        self._points = self._feet.points()
        self._placed = True

    def _weigh(self) -> None:
        """Bring the factor of the mass matrix up to the present configuration."""
        self._body.weigh(self._q)

    def _collide(self, free: FloatArray, near: IntArray, horizon: float) -> None:
        """Set v⁺, impulses and contact velocities; `horizon` is the time to the next impulses [s].

        The laws hold for the mean velocity of a contact until then. Of one that holds on, half of what it
        changed by since the last impulses is expected to come again: so impulses work on a mean velocity
        that obeys the laws, to second order. Where that guess would make energy, the mean velocity over the
        impulses themselves takes its place.
        """
        before = self._v
        feet = self.contact_foot, self._frames
        guess = rigid_step.swerves(self._J, before, self._leaving, self._impulses, *feet, SWERVE)
        if guess is None:
            self._solve(before, free, near, horizon, None)
            return
        arriving, swerve = guess
        warm = self._impulses.copy()
        self._solve(before, free, near, horizon, swerve)
        work, push = rigid_step.mean_work(self._impulses, arriving, self._leaving)
        if work > GAIN * push * GRAVITY * self.dt:
            self._impulses = warm
            guess = rigid_step.swerves(self._J, before, -arriving, warm, *feet, 0.0)
            self._solve(before, free, near, horizon, None if guess is None else guess[1])

    def _solve(
        self, before: FloatArray, free: FloatArray, near: IntArray, horizon: float, swerve: FloatArray | None
    ) -> None:
        """Solve the contact problem; contacts that the impulses push into the ground join in."""
        while True:
            self._v = self._after_impulses(before, free, near, horizon, swerve)
            self._leaving = self._velocities = (self._J @ self._v).reshape(-1, 3)
            if swerve is not None:
                self._velocities = self._leaving + swerve
            more = rigid_step.with_missed(self._velocities, self._gaps, horizon, near)
            if more.size == near.size:
                return
            near = more

    def _after_impulses(
        self, before: FloatArray, free: FloatArray, near: IntArray, horizon: float, swerve: FloatArray | None
    ) -> FloatArray:
        """Return v⁺ after the impulses of the near contacts, all others without."""
        warm = self._impulses[near]
        self._impulses[:] = 0.0
        if not near.size:
            self.solution = None
            return free
        pull = PULL if self.stabilisation == "baumgarte" else 0.0
        Y, G, g = rigid_step.assemble(
            self._J, self._L, before, free, self._gaps, near, horizon, self.restitution,
            2.0 * self.dt * GRAVITY, pull,
        )  # fmt: skip
        if swerve is not None:
            g += swerve[near].ravel()
        problem = self._problem(G, g, self.mu, self.law)
        self.solution = solve(problem, self.solver, self.tol, warm_start=warm)
        residual = self.solution.residuals.velocity_error
        self.unsolved += not self.solution.solved
        self.worst_residual = max(self.worst_residual, residual)
        self._impulses[near] = self.solution.forces
        after = rigid_step.apply_impulses(self._L, Y, self.solution.forces.ravel(), free)
        if not rigid_step.largest(after) < FASTEST:
            raise self._lost("velocity under the ground's impulses")
        return after

    def _project(self) -> None:
        """Move the robot out of the ground where it is in by more than `SLOP`.

        Minimises ||dq||_M subject to gap + J_n dq >= 0: a frictionless contact problem in positions.
        """
        for _ in range(PROJECTIONS):
            if self._gaps.min(initial=0.0) >= -SLOP:
                return
            rest = np.zeros(self.model.nv)
            near = np.flatnonzero(self._gaps < REACH)
            Y, G, g = rigid_step.assemble(
                self._J, self._L, rest, rest, self._gaps, near, 1.0, 0.0, np.inf, 1.0
            )
            pushes = solve(self._problem(G, g, 0.0), self.solver, 1e-6).forces
            step = rigid_step.apply_impulses(self._L, Y, pushes.ravel(), rest)
            self._q = self._body.moved(self._q, step)
            self._place()
            self._weigh()

    def _problem(self, G: FloatArray, g: FloatArray, mu: float, law: str = "coulomb") -> ContactProblem:
        """Return the contact problem of finite numbers."""
        if not max(rigid_step.largest(g), rigid_step.largest(G.ravel())) < np.inf:
            raise self._lost("contact problem")
        return ContactProblem(G, g, mu, law=law)

    def _lost(self, what: str) -> SimulationError:
        """Return the error for a state that cannot go on; it names the joint that moved fastest before."""
        joint, speed = self._body.fastest_joint(self._before[1])
        return SimulationError(what, self.time, self.dt, joint, speed)
