"""One knot of a plan: a first-order step and its dense derivative, in arrays that are made once.

The same step as `Stepper.step` with `StepOptions(order=1)` and the same derivative as `step_derivative`,
without the objects about them: a straight line of Pinocchio's calls and compiled ones (`knot_kernels`).
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray, real_number
from surefoot.base.errors import NoSolution, ProblemError
from surefoot.contact import COMPILED_CONTACTS, ContactProblem
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics import knot_kernels as kernels
from surefoot.mechanics.dynamics.bodies import finite_vector
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


class Knot:
    """Takes first-order steps and differentiates them; one per thread, since it keeps its arrays.

    Parameters
    ----------
    stepper
        With `StepOptions(order=1)`.

    Attributes
    ----------
    q, v
        (nq,) and (nv,) after the last step.
    impulses
        (p, 3) of the ground, in contact axes [N s]; an array that the next step fills anew.
    gaps
        (p,) at the step's start [m]; likewise.
    solved
        Whether its contact problem was solved to the tolerance.
    residual
        Its velocity error, see `Residuals`.

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
    >>> knot.step(place(robot), np.zeros(18), np.zeros(12))
    True
    >>> A, B = knot.derivative()
    >>> A.shape, B.shape, knot.impulses.shape
    ((36, 36), (36, 12), (4, 3))
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
        n, p = model.nv, len(points)
        self._first = np.concatenate([np.full(j.nv, j.idx_v, dtype=np.int64) for j in list(model.joints)[1:]])
        self._crba, self._bias, self._place = (
            pinocchio.crba,
            pinocchio.nonLinearEffects,
            pinocchio.updateFramePlacements,
        )
        self._inverse, self._world = pinocchio.computeRNEADerivatives, pinocchio.Convention.WORLD
        self._integrate, self._d_integrate = pinocchio.integrate, pinocchio.dIntegrate
        # Pinocchio's own arrays, seen from here: they hold what its last call left
        self._upper, self._twists = data.M, data.J.T
        self._by_q, self._by_v = data.dtau_dq, data.dtau_dv
        self._seen = [data.oMf[k].translation for k in contacts.spheres]
        self._support, self._radii = points.support, points.radii
        self._centres, self._positions = np.zeros((p, 3)), np.zeros((p, 3))
        self.gaps, self._frames = ground.below(self._centres)
        self._above, self._curved = ground.above, not stepper.terrain.planar
        self._turns, self._slopes = np.zeros((2, p, 3, 3)), np.ascontiguousarray(self._frames[:, :, 2])
        self._J, self._L, self.impulses = np.zeros((3 * p, n)), np.zeros((n, n)), np.zeros((p, 3))
        self._settings = np.array(
            [
                options.dt,
                options.restitution,
                options.rest_speed,
                options.pull,
                options.solver_tol,
                REACH,
                0.0,
            ]
        )
        self._convex = options.problem_law == "convex"
        self._quick = options.solver == "auto" and p <= COMPILED_CONTACTS
        self._effort, self._base = np.zeros(n), stepper.robot.base_dof
        self.solved = False

    def step(
        self,
        q: FloatArray,
        v: FloatArray,
        torques: FloatArray,
        mu: float = 0.6,
    ) -> bool:
        """Take the step from (nq,) q and (nv,) v; return whether its contact problem is solved.

        Parameters
        ----------
        torques
            (joints,) [N m].
        mu
            Friction of the ground.

        Returns
        -------
        bool
            False also where the motion is lost: q and v are NaN then.

        Raises
        ------
        ProblemError
            For an argument of the wrong shape, or not finite.
        """
        model, data = self._model, self._data
        # copies: the derivative wants them when the caller may have gone on in place
        self._q = finite_vector("q", q, model.nq).copy()
        self._v = finite_vector("v", v, model.nv).copy()
        effort, self._mu = self._effort, mu
        effort[self._base :] = finite_vector("torques", torques, self.stepper.robot.joints)
        if not 0.0 <= mu < np.inf:
            real_number("mu", mu, low=0.0)
        self._crba(model, data, self._q, self._world)
        self._place(model, data)
        effort = self._less_bias(effort)
        for k, centre in enumerate(self._seen):
            self._centres[k] = centre
        if self._curved:
            self.gaps, self._frames = self._ground.below(self._centres)
        self._settings[kernels.MU] = mu if self._quick else 0.0
        after = np.empty(model.nv)
        code, self._free, self._near, self._problem = kernels.first_order_step(
            (self._upper, self._twists, self._support, self._radii),
            (self._centres, self._frames, self.gaps, self._above, self._positions),
            self._v, effort, self._settings, self._convex, self._J, self._L, self.impulses, after,
        )  # fmt: skip
        self.v = self._reached = after
        self.solved = code == kernels.SOLVED
        try:
            if code == kernels.LOST:
                raise LostMotion("velocity")
            if not (self.solved and self._quick):
                self._solve_again()
        except LostMotion:
            self.q, self.v, self.solved = np.full(model.nq, np.nan), np.full(model.nv, np.nan), False
            return False
        self.q = self._configuration_after()
        return self.solved

    def _less_bias(self, effort: FloatArray) -> FloatArray:
        """Return an effort (nv,) less what keeps the velocity of the start as it is."""
        return np.asarray(effort - self._bias(self._model, self._data, self._q, self._v))

    def _configuration_after(self) -> FloatArray:
        """Return where the velocity after the step leads (nq,)."""
        return np.asarray(self._integrate(self._model, self._q, self._dt * self.v))

    @property
    def residual(self) -> float:
        """Velocity error of the contact problem, see `Residuals`."""
        record = self._problem[3]
        return float(record[len(record) - 3, 0])

    @property
    def jacobian(self) -> FloatArray:
        """(3p, nv) of the contact points at the step's start, contact axes; filled anew by the next step."""
        return self._J

    @property
    def moved(self) -> tuple[FloatArray, FloatArray]:
        """(nv, nv) derivatives of q ⊕ dt v⁺ by q and by dt v⁺, of the last call of `derivative`."""
        return self._moved

    def contact_rates(self) -> FloatArray:
        """Return the derivative (3p, nv) of the contact velocities J(q) v at the step's start by q."""
        if self._curved:
            self._look_below()
        return velocity_rates(
            self._twists, self._first, self._support, self._positions, self._radii, self._frames, self._turns,
            self._v,
        )  # fmt: skip

    def _solve_again(self) -> None:
        """Take the step by all of `surefoot.solve`: the compiled solver failed, or another is asked for."""
        step = self.stepper.take_first_order(State(self._q, self._v), self._effort, None, self._mu)
        impact = step.impact
        assert impact is not None
        self.solved, self._near, self._free = step.unsolved == 0, impact.near, impact.free
        self.v = self._reached = impact.after
        self.impulses[:] = impact.impulses
        if impact.solution is not None and impact.rows is not None:
            p, s = impact.solution.problem, impact.solution
            numbers = np.zeros((3, 3))
            numbers[0, 0] = s.residuals.velocity_error
            self._problem = impact.rows, p.G, p.g, np.vstack([s.forces, s.velocities, numbers])

    def derivative(self, smoothing: float = 0.0, out: Outputs | None = None) -> Outputs:
        """Return A (2nv, 2nv) and B (2nv, joints): (q, v) after the last step by that before and by torques.

        Parameters
        ----------
        smoothing
            See `step_derivative`.
        out
            Arrays to be filled and returned, float64 and C-contiguous; None for new ones.

        Raises
        ------
        NoSolution
            If the step is not solved, or the central path not reached.
        ProblemError
            For arrays that do not fit, or a smoothing out of range.
        """
        if not self.solved:
            raise NoSolution("no derivative of a step whose contact problem is not SOLVED")
        n = self._first.size
        A, B = _outputs(out, (2 * n, 2 * n), (2 * n, n - self._base))
        near, Y, by_g, impulses, after = (
            self._answer() if smoothing == 0.0 else self._exchange_on_path(smoothing)
        )
        dt, data = self._dt, self._data
        if self._curved:
            self._look_below()
        self._inverse(self._model, data, self._q, self._v, (after - self._v) / dt)
        self._correct_rates(after)
        self._moved = self._way_rates(after)
        self.by_mu = kernels.first_order_blocks(
            (self._twists, self._first, self._support, self._positions, self._radii, self._frames,
             self._turns),
            (self.gaps, self._slopes, self._J), (self._v, self._free, after),
            near, Y, by_g, impulses, self._settings, self._L, (self._by_q, self._by_v), self._moved, A, B,
        )  # fmt: skip
        return A, B

    def _correct_rates(self, after: FloatArray) -> None:
        """Leave the derivatives of inverse dynamics as they are: the plain step's."""

    def _way_rates(self, after: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the derivatives (nv, nv) of the way by q and by the way that (nv,) `after` goes."""
        by_q, by_way = self._d_integrate(self._model, self._q, self._dt * after)
        return by_q, by_way

    def _answer(self) -> Linearisation:
        """Return the ground's answer under the laws themselves."""
        problem, near = self._problem, self._near
        Y, G, g, record = problem
        k = len(near)
        by_g = np.empty((3 * k, 4 * k))
        if k and not kernels.answer(problem, self._mu, self._convex, by_g):  # redundant contacts
            contacts = ContactProblem(G, g, self._mu, law=self.stepper.options.problem_law)
            solution = self.stepper.solve(contacts, record[:k])
            by_g[:, : 3 * k], by_g[:, 3 * k :] = Response(solution, 0.0).blocks
        return near, Y, by_g, self.impulses, self._reached

    def _exchange_on_path(self, kappa: float) -> Linearisation:
        """Return the ground's answer on the central path."""
        kappa = real_number("smoothing", kappa, low=0.0, high=1e300)
        impulses, after = self.impulses.copy(), np.empty_like(self.v)
        self._settings[kernels.MU] = self._mu
        given = self._J, self._L, self._v, self._free, self.gaps, self._settings, self._convex
        found, Y, by_g = kernels.smooth_step(*given, kappa, impulses, after)
        every = np.arange(len(self.gaps))
        if not found:  # the slower way, which says so where it fails
            dt, e, slow, pull = self._settings[: kernels.TOL]
            law = dt, np.full(len(every), e), slow, pull
            _, G, g = arithmetic.assemble(self._J, self._L, self._v, self._free, self.gaps, every, *law)
            contacts = ContactProblem(G, g, self._mu, law=self.stepper.options.problem_law)
            response = Response(self.stepper.solve(contacts, self.impulses), kappa)
            impulses, d = response.forces, response.derivative
            by_g = np.hstack([d.dforces_dg, d.dforces_dmu])
            after = arithmetic.apply_impulses(self._L, Y, impulses.ravel(), self._free)
        return every, Y, by_g, impulses, after

    def _look_below(self) -> None:
        """Find how curved ground turns below the contacts."""
        contacts = Contacts(self.gaps, self._positions, self._frames, self._J)
        self._turns, self._slopes = ground_turn(self.stepper.terrain, contacts, self._radii)


def _outputs(out: Outputs | None, *shapes: tuple[int, int]) -> Outputs:
    """Return A and B to be filled."""
    if out is None:
        return np.empty(shapes[0]), np.empty(shapes[1])
    for name, array, shape in zip("AB", out, shapes, strict=True):
        if not (array.shape == shape and array.dtype == np.float64 and array.flags.c_contiguous):
            raise ProblemError(f"{name} of out must be a C-contiguous float64 array of shape {shape}")
    return out
