"""One knot of a plan: a first-order step and its dense derivative, as values.

The same step as `Stepper.step` with `StepOptions(order=1)` and the same derivative as `step_derivative`,
without the objects about them: a straight line of Pinocchio's calls and compiled ones (`knot_kernels`).
A step is a `KnotStep`, which holds all that its derivative needs: a derivative may be taken at any time, and
of any of the steps that a knot has taken.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, real_number
from surefoot.base.errors import NoSolution, ProblemError
from surefoot.base.numerics.vectors import finite_vector
from surefoot.contact import COMPILED_CONTACTS, ContactProblem
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics import knot_kernels as kernels
from surefoot.mechanics.dynamics.derivative.contact_problem import Response
from surefoot.mechanics.dynamics.derivative.flow import ordered
from surefoot.mechanics.dynamics.derivative.points import ground_turn
from surefoot.mechanics.dynamics.derivative.rate_kernels import velocity_rates
from surefoot.mechanics.dynamics.detection import Contacts, GroundBelow, TerrainDetection
from surefoot.mechanics.dynamics.impacts import LostMotion
from surefoot.mechanics.dynamics.state import State
from surefoot.mechanics.dynamics.stepper import REACH, Stepper

Outputs = tuple[FloatArray, FloatArray]
"""A (2nv, 2nv) and B (2nv, joints)."""
Linearisation = tuple[IntArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Contacts that take part, Y, derivatives of their impulses by g and mu; impulses and v⁺ where they hold."""
Rates = tuple[FloatArray, FloatArray]
"""Two derivatives (nv, nv)."""


class BaseMomentum(NamedTuple):
    """Momentum of the whole robot at a step's start, world axes about the centre of mass; see `MomentumKnot`.

    Attributes
    ----------
    map
        (6, nv) centroidal momentum matrix A_G [kg, kg m].
    motion
        (6, n) velocity of the centre of mass and rate of rotation by the base's n velocities.
    arriving
        (6,) momentum at the start of the way that led to q [N s, N m s].
    effort
        (n,) generalised forces in place of the base's rate of momentum [N, N m].
    com, mass
        (3,) centre of mass [m], and mass [kg].
    """

    map: FloatArray
    motion: FloatArray
    arriving: FloatArray
    effort: FloatArray
    com: FloatArray
    mass: float


class KnotStep(NamedTuple):
    """A first-order step: where it leads, and what its derivative needs.

    Attributes
    ----------
    q, v
        (nq,) and (nv,) after the step; NaN where the motion is lost.
    impulses
        (p, 3) of the ground, in contact axes [N s].
    solved
        Whether its contact problem was solved to the tolerance.
    start
        (nq,) and (nv,) before the step.
    mu
        Friction of the ground [-].
    contacts
        The p contact points at the step's start.
    twists, L
        (nv, 6) of the joints, linear at the world's origin, world axes, and (nv, nv) lower factor of the mass
        matrix, both at the step's start.
    free
        (nv,) velocity without the ground's forces.
    near, problem
        (k,) contacts of the problem, and the problem with its solution.
    momentum
        Of a step that keeps it; None for a plain one.
    """

    q: FloatArray
    v: FloatArray
    impulses: FloatArray
    solved: bool
    start: tuple[FloatArray, FloatArray]
    mu: float
    contacts: Contacts
    twists: FloatArray
    L: FloatArray
    free: FloatArray
    near: IntArray
    problem: kernels.Problem
    momentum: BaseMomentum | None

    @property
    def gaps(self) -> FloatArray:
        """(p,) distances to the ground at the step's start [m]."""
        return self.contacts.gaps

    @property
    def residual(self) -> float:
        """Velocity error of the contact problem, see `Residuals`."""
        record = self.problem[3]
        return float(record[len(record) - 3, 0])


class KnotDerivative(NamedTuple):
    """Derivatives of (q, v) after a step.

    Attributes
    ----------
    A, B
        (2nv, 2nv) by (q, v) before the step, and (2nv, joints) by torques.
    mu
        (2nv,) by the friction of the ground.
    """

    A: FloatArray
    B: FloatArray
    mu: FloatArray


class Knot:
    """Takes first-order steps and differentiates them; one per thread, since Pinocchio's data is its own.

    Parameters
    ----------
    stepper
        With `StepOptions(order=1)`.

    Raises
    ------
    ProblemError
        For a stepper of order 2, and for joints out of depth-first order.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot, place
    >>> from surefoot.mechanics.dynamics import StepOptions
    >>> robot = load_robot("go2")
    >>> knot = Knot(Stepper(robot, options=StepOptions(dt=0.02, order=1)))
    >>> step = knot.step(place(robot), np.zeros(18), np.zeros(12))
    >>> A, B, by_mu = knot.derivative(step)
    >>> step.solved, step.impulses.shape, A.shape, B.shape
    (True, (4, 3), (36, 36), (36, 12))
    """

    def __init__(self, stepper: Stepper) -> None:
        import pinocchio

        if stepper.options.order != 1:
            raise ProblemError(f"a knot takes StepOptions(order=1), got order={stepper.options.order}")
        contacts = stepper.bodies.contacts
        assert isinstance(contacts, TerrainDetection)  # order 1 is of feet on the ground
        self.stepper, bodies, options = stepper, stepper.bodies, stepper.options
        points = stepper.robot.contact_points
        self._ground = ground = GroundBelow(stepper.terrain, points.radii)
        self._model = model = bodies.model
        self._dt = options.dt
        ordered(model)
        self._data = data = model.createData()
        self._first = np.concatenate([np.full(j.nv, j.idx_v, dtype=np.int64) for j in list(model.joints)[1:]])
        self._crba, self._bias = pinocchio.crba, pinocchio.nonLinearEffects
        self._place = pinocchio.updateFramePlacements
        self._inverse, self._world = pinocchio.computeRNEADerivatives, pinocchio.Convention.WORLD
        self._integrate, self._d_integrate = pinocchio.integrate, pinocchio.dIntegrate
        # Pinocchio's own arrays, seen from here: they hold what its last call left, so that no result is one
        self._upper, self._twists = data.M, data.J.T
        self._by_q, self._by_v = data.dtau_dq, data.dtau_dv
        self._spheres = [data.oMf[k].translation for k in contacts.spheres]
        self._support, self._radii = points.support, points.radii
        # a plane's are the same at every step
        self._curved, self._frames = not stepper.terrain.planar, ground.below(np.zeros((len(points), 3)))[1]
        self._turns = np.zeros((2, *self._frames.shape))
        self._slopes = np.ascontiguousarray(self._frames[:, :, 2])
        self._settings = kernels.KnotSettings(
            options.dt, options.restitution, options.rest_speed, options.pull, options.solver_tol, REACH
        )
        self._convex = options.problem_law == "convex"
        self._quick = options.solver == "auto" and len(points) <= COMPILED_CONTACTS
        self._base = stepper.robot.base_dof

    def step(self, q: FloatArray, v: FloatArray, torques: FloatArray, mu: float = 0.6) -> KnotStep:
        """Return the step from (nq,) q and (nv,) v.

        Parameters
        ----------
        torques
            (joints,) [N m].
        mu
            Friction of the ground.

        Returns
        -------
        KnotStep
            In arrays of its own.

        Raises
        ------
        ProblemError
            For an argument of the wrong shape, or not finite.
        """
        model, data = self._model, self._data
        # copies: the derivative wants them when the caller may have gone on in place
        q = finite_vector("q", q, model.nq).copy()
        v = finite_vector("v", v, model.nv).copy()
        effort = np.zeros(model.nv)
        effort[self._base :] = finite_vector("torques", torques, self.stepper.robot.joints)
        if not 0.0 <= mu < np.inf:
            real_number("mu", mu, low=0.0)
        self._crba(model, data, q, self._world)
        self._place(model, data)
        net = np.asarray(effort - self._bias(model, data, q, v))
        momentum = self._momentum_at(q, v)
        if momentum is not None:
            n = len(momentum.effort)
            net[:n] += momentum.effort
            effort[:n] += momentum.effort
        return self._meet_ground((q, v), effort, net, mu, momentum)

    def _meet_ground(
        self, start: tuple[FloatArray, FloatArray], effort: FloatArray, net: FloatArray, mu: float,
        momentum: BaseMomentum | None,
    ) -> KnotStep:  # fmt: skip
        """Return the step under generalised forces (nv,), without and with those of bias."""
        p, n = len(self._radii), len(net)
        centres, J, L = np.empty((p, 3)), np.zeros((3 * p, n)), np.zeros((n, n))
        for k, centre in enumerate(self._spheres):
            centres[k] = centre
        gaps, frames = np.empty(p), self._frames  # over a plane the kernel fills the gaps
        if self._curved:
            gaps, below = self._ground.below(centres)
            frames = below.copy()  # a work array of the ground's
        contacts = Contacts(gaps, np.empty((p, 3)), frames, J)
        impulses, after = np.empty((p, 3)), np.empty(n)
        code, free, near, problem = kernels.first_order_step(
            (self._upper, self._twists, self._support, self._radii),
            (centres, frames, gaps, self._ground.above, contacts.positions),
            start[1], net, self._settings, mu if self._quick else 0.0, self._convex, J, L, impulses, after,
        )  # fmt: skip
        solved = code == kernels.SOLVED
        q = self._end(start[0], after, momentum) if solved and self._quick else np.full_like(start[0], np.nan)
        step = KnotStep(
            q, after, impulses, solved, start, mu, contacts, self._twists.copy(), L, free, near, problem,
            momentum,
        )  # fmt: skip
        if solved and self._quick:
            return step
        try:
            if code == kernels.LOST:
                raise LostMotion("velocity")
            return self._solve_again(step, effort)
        except LostMotion:
            return step._replace(v=np.full(n, np.nan), solved=False)

    def _momentum_at(self, q: FloatArray, v: FloatArray) -> BaseMomentum | None:
        """Return the momentum that a step is to keep; none of the plain step, whose base has rows of M."""
        del q, v
        return None

    def _end(self, q: FloatArray, after: FloatArray, momentum: BaseMomentum | None) -> FloatArray:
        """Return where (nv,) `after` leads from (nq,) q: (nq,)."""
        del momentum
        return np.asarray(self._integrate(self._model, q, self._dt * after))

    def contact_rates(self, step: KnotStep) -> FloatArray:
        """Return the derivative (3p, nv) of the contact velocities J(q) v at a step's start by q."""
        contacts, (turns, _) = step.contacts, self._ground_rates(step)
        return velocity_rates(
            step.twists, self._first, self._support, contacts.positions, self._radii, contacts.frames, turns,
            step.start[1],
        )  # fmt: skip

    def _solve_again(self, step: KnotStep, effort: FloatArray) -> KnotStep:
        """Return a step by all of `surefoot.solve`: the compiled solver failed, or another is asked for."""
        taken = self.stepper.take_first_order(State(*step.start), effort, None, step.mu)
        impact, problem = taken.impact, step.problem
        assert impact is not None
        if impact.solution is not None and impact.rows is not None:
            p, s = impact.solution.problem, impact.solution
            numbers = np.zeros((3, 3))
            numbers[0, 0] = s.residuals.velocity_error
            problem = impact.rows, p.G, p.g, np.vstack([s.forces, s.velocities, numbers])
        return step._replace(
            q=self._end(step.start[0], impact.after, step.momentum), v=impact.after,
            impulses=np.array(impact.impulses), solved=taken.unsolved == 0, free=impact.free,
            near=impact.near, problem=problem,
        )  # fmt: skip

    def derivative(
        self, step: KnotStep, smoothing: float = 0.0, out: Outputs | None = None
    ) -> KnotDerivative:
        """Return the derivative of (q, v) after a step by that before, by torques and by friction.

        Parameters
        ----------
        step
            A step of this knot, or of another one for the same robot, ground and options.
        smoothing
            See `step_derivative`.
        out
            Arrays A and B to be filled and returned, float64 and C-contiguous; None for new ones.

        Raises
        ------
        NoSolution
            If the step is not solved, or the central path not reached.
        ProblemError
            For arrays that do not fit, or a smoothing out of range.
        """
        if not step.solved:
            raise NoSolution("no derivative of a step whose contact problem is not SOLVED")
        n, contacts = self._first.size, step.contacts
        A, B = _outputs(out, (2 * n, 2 * n), (2 * n, n - self._base))
        near, Y, by_g, impulses, after = (
            self._answer(step) if smoothing == 0.0 else self._exchange_on_path(step, smoothing)
        )
        turns, slopes = self._ground_rates(step)
        dynamics, moved = self._rates(step, after)
        by_mu = kernels.first_order_blocks(
            (step.twists, self._first, self._support, contacts.positions, self._radii, contacts.frames,
             turns),
            (contacts.gaps, slopes, contacts.J), (step.start[1], step.free, after),
            near, Y, by_g, impulses, self._settings, step.L, dynamics, moved, A, B,
        )  # fmt: skip
        return KnotDerivative(A, B, by_mu)

    def _rates(self, step: KnotStep, after: FloatArray) -> tuple[Rates, Rates]:
        """Return the derivatives of inverse dynamics by q and v, and of the way by q and by itself.

        Both for the way that (nv,) `after` goes; the first two are Pinocchio's arrays, until its next call.
        """
        q, v = step.start
        self._inverse(self._model, self._data, q, v, (after - v) / self._dt)
        by_q, by_way = self._d_integrate(self._model, q, self._dt * after)
        return (self._by_q, self._by_v), (by_q, by_way)

    def _answer(self, step: KnotStep) -> Linearisation:
        """Return the ground's answer under the laws themselves."""
        near, (Y, G, g, record) = step.near, step.problem
        k = len(near)
        by_g = np.empty((3 * k, 4 * k))
        if k and not kernels.answer(step.problem, step.mu, self._convex, by_g):  # redundant contacts
            contacts = ContactProblem(G, g, step.mu, law=self.stepper.options.problem_law)
            solution = self.stepper.solve(contacts, record[:k])
            by_g[:, : 3 * k], by_g[:, 3 * k :] = Response(solution, 0.0).blocks
        return near, Y, by_g, step.impulses, step.v

    def _exchange_on_path(self, step: KnotStep, kappa: float) -> Linearisation:
        """Return the ground's answer on the central path."""
        kappa = real_number("smoothing", kappa, low=0.0, high=1e300)
        impulses, after = step.impulses.copy(), np.empty_like(step.v)
        v, settings = step.start[1], self._settings
        gaps, J = step.contacts.gaps, step.contacts.J
        found, Y, by_g = kernels.smooth_step(
            J, step.L, v, step.free, gaps, settings, step.mu, self._convex, kappa, impulses, after
        )
        every = np.arange(len(gaps))
        if not found:  # the slower way, which says so where it fails
            law = settings.dt, np.full(len(every), settings.restitution), settings.rest_speed, settings.pull
            _, G, g = arithmetic.assemble(J, step.L, v, step.free, gaps, every, *law)
            contacts = ContactProblem(G, g, step.mu, law=self.stepper.options.problem_law)
            response = Response(self.stepper.solve(contacts, step.impulses), kappa)
            impulses, d = response.forces, response.derivative
            by_g = np.hstack([d.dforces_dg, d.dforces_dmu])
            after = arithmetic.apply_impulses(step.L, Y, impulses.ravel(), step.free)
        return every, Y, by_g, impulses, after

    def _ground_rates(self, step: KnotStep) -> tuple[FloatArray, FloatArray]:
        """Return how curved ground turns below the contacts, and the slopes of its distance."""
        if not self._curved:
            return self._turns, self._slopes
        return ground_turn(self.stepper.terrain, step.contacts, self._radii)


def _outputs(out: Outputs | None, *shapes: tuple[int, int]) -> Outputs:
    """Return A and B to be filled."""
    if out is None:
        return np.empty(shapes[0]), np.empty(shapes[1])
    for name, array, shape in zip("AB", out, shapes, strict=True):
        if not (array.shape == shape and array.dtype == np.float64 and array.flags.c_contiguous):
            raise ProblemError(f"{name} of out must be a C-contiguous float64 array of shape {shape}")
    return out
