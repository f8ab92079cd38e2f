"""A rigid world: hard contacts with exact Coulomb friction, one contact problem per time step.

Semi-implicit Euler on velocities with impulses, after Moreau and Jean [1]_::

    v⁺ = v + M⁻¹ (dt (τ - h) + Jᵀ λ),      u = J v⁺,      q⁺ = q ⊕ dt v⁺

with a floating base's linear velocity in world axes, whatever axes v has, and with (λ, u) obeying Signorini,
Coulomb and maximum dissipation exactly (`surefoot.solve`). The order in dt is one. An open contact enters
with u_n + gap / dt >= 0, so that a foot that would hit the ground within the step stops at the surface and
does not go below it. Impulses never do positive work where the restitution is zero and positions are not
pulled by velocities. Coriolis terms are taken at the mean velocity of the step (implicit midpoint), so that a
spinning body keeps its energy.

Joints are ideal torque sources without friction, rotor inertia or stops; only the feet's spheres touch
the ground; a sphere on curved ground sees the tangent plane below its centre.

References
----------
.. [1] J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; M. Jean, "The
   non-smooth contact dynamics method", CMAME 177, 1999.
"""

from __future__ import annotations

import math
from typing import Any, Literal, get_args

import numpy as np

from surefoot.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.contact import ContactProblem, ContactSolution
from surefoot.contact.problem import LAWS, Law
from surefoot.errors import ProblemError, unknown_name
from surefoot.robot import Robot
from surefoot.simulation import rigid_step
from surefoot.simulation.world import ContactReading
from surefoot.solvers import solve
from surefoot.spatial import GRAVITY
from surefoot.stance import FlatTerrain, SlopeTerrain, Terrain

Stabilisation = Literal["projection", "baumgarte", "none"]
STABILISATIONS: tuple[Stabilisation, ...] = get_args(Stabilisation)

REACH = 1e-3
"""Contacts that free motion brings closer than this enter the contact problem [m]."""
SLOP = 1e-6
"""Penetration that the projection leaves alone [m]."""
PULL = 0.2
"""Share of a penetration that Baumgarte's term takes back per step."""
SPIN_ITERATIONS, SPIN_TOLERANCE = 6, 1e-6
"""Most evaluations of the Coriolis terms per step, and the change of the mean velocity that ends them."""
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
        Largest natural map residual so far.

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
        law: Law = "coulomb",
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
        self.model = _loaded_model(robot, real_number("payload", payload, low=0.0))
        self._place_feet()
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
        self._kinematics()
        self._velocities = (self._J @ self._v).reshape(-1, 3)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (nq,) and v (nv,) in Pinocchio's order."""
        return self._q.copy(), self._v.copy()

    def set_friction(self, mu: float) -> None:
        """Change the friction of the ground everywhere, from the next step on."""
        self.mu = real_number("mu", mu, low=0.0)

    def step(self, torques: FloatArray, push: FloatArray | None = None) -> None:
        """Advance by `dt` under (joints,) torques [N m] and a (3,) push on the base [N], world axes.

        The push goes through the centre of mass of the base's own link.
        """
        self._kinematics()
        if self.stabilisation == "projection":
            self._project()
        free = self._free_velocity(self._applied(torques, push))
        near = rigid_step.near_ground(self._J, self._v, free, self._gaps, self.dt, REACH)
        self._collide(free, near)
        self._advance()
        self._steps += 1

    def contacts(self) -> ContactReading:
        """Return what the ground did during the last step.

        Forces are impulses over dt; velocities are those at the end of the step, which the contact laws
        tie to the impulses (and with which the contacts move during it); gaps and positions are those
        at its start.
        """
        return ContactReading(
            self._impulses / self.dt, self._gaps.copy(), self._velocities.copy(), self._points.copy()
        )

    def energy(self) -> float:
        """Return kinetic plus potential energy [J], zero potential at z = 0."""
        import pinocchio

        return float(pinocchio.computeMechanicalEnergy(self.model, self.data, self._q, self._v))

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

    def _applied(self, torques: FloatArray, push: FloatArray | None) -> FloatArray:
        """Return the generalised forces of motors and push: (nv,)."""
        base, out = self.robot.base_dof, np.zeros(self.model.nv)
        out[base:] = torques
        if push is not None and base:
            local = self.data.oMi[1].rotation.T @ push
            out[:3] = local
            out[3:6] = np.cross(self.robot.model.inertias[1].lever, local)
        return out

    def _free_velocity(self, applied: FloatArray) -> FloatArray:
        """Return the velocity after the step without contacts; Coriolis terms at the mean velocity.

        The mean is that of the motion under no forces: what motors and gravity would add without the
        ground's reaction is no part of a standing robot's motion.
        """
        gravity, middle = self._gravity(self.model, self.data, self._q), self._v.copy()
        for _ in range(SPIN_ITERATIONS):
            coriolis = self._bias(self.model, self.data, self._q, middle) - gravity
            change = rigid_step.mean_velocity(self._L, coriolis, self._v, middle, self.dt, self._floating)
            if not change > SPIN_TOLERANCE:
                break
        return rigid_step.free_velocity(self._L, applied - gravity, self._v, middle, self.dt)

    def _kinematics(self) -> None:
        """Bring placements, mass matrix, gaps and contact Jacobian up to the present configuration."""
        data = self.data
        self._jacobians(self.model, data, self._q)
        rigid_step.factorise(self._crba(self.model, data, self._q), self._L)
        self._update_frames(self.model, data)
        places = data.oMf
        centres = np.array([places[k].translation for k in self._sphere_frames]).reshape(-1, 3)
        if self._plane is not None:
            self._gaps = centres @ self._plane[:, 2] - self._radii
        else:
            self._gaps = self.terrain.gap(centres) - self._radii
            rigid_step.surface_frames(self.terrain.normal(centres[:, :2]), self._frames)
        self._points = centres - self._radii[:, None] * self._frames[:, :, 2]
        rigid_step.contact_rows(data.J, self._support, self._points, self._frames, self._J)

    def _collide(self, free: FloatArray, near: IntArray) -> None:
        """Set v⁺, impulses and contact velocities; contacts that impulses push into the ground join in."""
        while True:
            self._v = self._after_impulses(free, near)
            self._velocities = (self._J @ self._v).reshape(-1, 3)
            more = rigid_step.with_missed(self._velocities, self._gaps, self.dt, near)
            if more.size == near.size:
                return
            near = more

    def _after_impulses(self, free: FloatArray, near: IntArray) -> FloatArray:
        """Return v⁺ after the impulses of the near contacts, all others without."""
        warm = self._impulses[near]
        self._impulses[:] = 0.0
        if not near.size or not math.isfinite(float(free.sum())):  # a state that is lost stays so
            self.solution = None
            return free
        pull = PULL if self.stabilisation == "baumgarte" else 0.0
        Y, G, g = rigid_step.assemble(
            self._J, self._L, self._v, free, self._gaps, near, self.dt, self.restitution,
            2.0 * self.dt * GRAVITY, pull,
        )  # fmt: skip
        problem = ContactProblem(G, g, self.mu, law=self.law)
        self.solution = solve(problem, self.solver, self.tol, warm_start=warm)
        residual = self.solution.residuals.natural_map
        self.unsolved += not self.solution.solved
        self.worst_residual = max(self.worst_residual, residual)
        self._impulses[near] = self.solution.forces
        return rigid_step.apply_impulses(self._L, Y, self.solution.forces.ravel(), free)

    def _advance(self) -> None:
        """Move along v⁺: the base straight on in the world while it turns, the joints by their own steps."""
        step, start = self.dt * self._v, self._q[:3]
        if self._floating:
            path = rigid_step.turn_base(self.data.oMi[1].rotation, self._v, self.dt)
            step[:3] = 0.0
        self._q = np.array(self._integrate(self.model, self._q, step))
        if self._floating:
            self._q[:3] = start + path

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
            pushes = solve(ContactProblem(G, g, 0.0), self.solver, 1e-6).forces
            step = rigid_step.apply_impulses(self._L, Y, pushes.ravel(), rest)
            self._q = np.array(self._integrate(self.model, self._q, step))
            self._kinematics()

    def _place_feet(self) -> None:
        """Lay out the contact spheres: who carries them, and the arrays that every step reuses."""
        import pinocchio

        robot, model = self.robot, self.model
        self._floating = robot.floating
        self._jacobians, self._crba = pinocchio.computeJointJacobians, pinocchio.crba
        self._update_frames = pinocchio.updateFramePlacements
        self._bias, self._integrate = pinocchio.nonLinearEffects, pinocchio.integrate
        self._gravity = pinocchio.computeGeneralizedGravity
        self.contact_foot = np.array(
            [k for k, foot in enumerate(robot.feet) for _ in foot.centres], dtype=np.int64
        )
        self._count = n = len(self.contact_foot)
        self._radii = np.array([robot.feet[k].radius for k in self.contact_foot])
        self._sphere_frames: list[int] = []
        self._support = np.zeros((n, model.nv), dtype=np.bool_)
        spheres = [(foot, centre) for foot in robot.feet for centre in foot.centres]
        for k, (foot, centre) in enumerate(spheres):
            frame = model.frames[foot.frame]
            joint = int(frame.parentJoint)
            place = frame.placement * pinocchio.SE3(np.eye(3), centre)
            sphere = pinocchio.Frame(
                f"{foot.name}:sphere{k}", joint, foot.frame, place, pinocchio.FrameType.OP_FRAME
            )
            self._sphere_frames.append(model.addFrame(sphere))
            while joint > 0:
                first = model.joints[joint].idx_v
                self._support[k, first : first + model.joints[joint].nv] = True
                joint = int(model.parents[joint])
        self.data = model.createData()
        self._frames = np.zeros((n, 3, 3))
        self._plane = self.terrain.frame([0.0, 0.0]) if isinstance(self.terrain, SlopeTerrain) else None
        if self._plane is not None:
            self._frames[:] = self._plane
        self._J, self._L = np.zeros((3 * n, model.nv)), np.zeros((model.nv, model.nv))


def _loaded_model(robot: Robot, payload: float) -> Any:
    """Return a copy of the robot's model with a point mass at the base's origin."""
    import pinocchio

    model = robot.model.copy()
    if payload > 0.0 and robot.floating:
        load = pinocchio.Inertia(payload, np.zeros(3), 1e-3 * payload * np.eye(3))
        model.inertias[1] = model.inertias[1] + load
    return model
