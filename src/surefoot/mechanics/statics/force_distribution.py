"""Contact forces for a wanted wrench, with exact friction cones, in a few microseconds."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import BoolArray, FloatArray, finite_array, numbers, real_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.base.kernels import MATRIX, VECTOR, entry_point
from surefoot.base.memory import Remembering
from surefoot.contact import RowsWork, Status, distribute_with_rows, distribute_wrench, rows_work
from surefoot.contact import distribution_memory as layout
from surefoot.mechanics.statics.force_parameters import (
    contact_count,
    force_weights,
    friction,
    normal_bounds,
    torque_limits,
    wrench_metric,
)

_STATUS = (Status.SOLVED, Status.ALMOST, Status.MAX_ITERATIONS, Status.INVALID, Status.INFEASIBLE)
"""By the codes of `layout`, which are places in this tuple."""
_WRENCH = (6,)
NOT_NUMBERS = "grasp_map and wrench must be arrays of numbers"
# `solve` takes about a microsecond, of which every attribute lookup is a few per cent
_empty = np.empty
_distribute: Callable[[FloatArray, FloatArray, FloatArray, FloatArray], int] = distribute_wrench


@cache
def _call_directly() -> None:
    """Let `solve` call the compiled function itself, for the only types that it passes."""
    global _distribute
    _distribute = entry_point(distribute_wrench, MATRIX, VECTOR, MATRIX, MATRIX)


class ForceDistributor(Remembering):
    """Find the contact forces that give a wanted wrench best, again and again.

    Minimises ``||A f - w||²_W + r ||f - f_ref||² + s ||f - f_last||²`` over the truncated friction
    cones ``||f_t|| <= mu f_z``, ``normal_min <= f_z <= normal_max``, exactly: no facets. The method is
    Newton's in the six dimensions of the wrench, see
    `surefoot.contact.solvers.dual_newton.wrench_distribution`.

    `solve` starts from the last solution, allocates nothing but the array that it returns, and always
    returns forces inside every cone and bound; `status` tells whether they are also optimal.

    Parameters
    ----------
    mu
        Friction coefficient [-], a number or (n,), finite and >= 0.
    normal_min, normal_max
        Bounds on the normal forces [N], numbers or (n,).
    wrench_weights
        W: a number or (6,), >= 0, for [force; moment] [-, 1/m²].
    force_weight
        r: a number or (n,), > 0; or (n, 2) with a tangential and a normal weight per contact [-].
    smoothness
        s: a number >= 0 [-], weight on the change of the forces since the last call. Before the first
        call, and after `reset`, the last forces are zero.
    tol
        `status` is SOLVED when no force is further than this from the optimum [N] (or when double
        precision can tell no better).
    max_iterations
        Bound on the Newton iterations of the wrench; rows, as torque limits, may take 1,000 over all turns.
    torque_limit
        (joints,) largest joint torques [N·m], for calls of `solve` with a Jacobian.

    Attributes
    ----------
    work
        (4n + 2, 50) memory of the compiled calls, for loops of their own; see `dual_newton.work`.

    Raises
    ------
    ProblemError
        If a parameter has the wrong shape or is out of range.

    Examples
    --------
    >>> from surefoot.mechanics.stance import PointContact, Stance
    >>> feet = [[0.2, 0.15, 0], [0.2, -0.15, 0], [-0.2, 0.15, 0], [-0.2, -0.15, 0]]
    >>> stance = Stance([PointContact(p, mu=0.6) for p in feet])
    >>> distributor = ForceDistributor(mu=0.6, normal_min=5.0, normal_max=250.0, force_weight=1e-4)
    >>> forces = distributor.solve(stance.grasp_map([0, 0, 0.3]), [20.0, 0, 160.0, 0, 0, 0])
    >>> forces.shape, distributor.status.value
    ((4, 3), 'solved')
    """

    def __repr__(self) -> str:
        return f"ForceDistributor(contacts={self._forces_shape[0]}, status={self.status.value!r})"

    MEMORY = ("work", "_bounds", "_code", "_rows")

    def __init__(
        self,
        mu: ArrayLike,
        normal_min: ArrayLike = 0.0,
        normal_max: ArrayLike = math.inf,
        wrench_weights: ArrayLike = 1.0,
        force_weight: ArrayLike = 1e-4,
        *,
        smoothness: float = 0.0,
        tol: float = 1e-7,
        max_iterations: int = 200,
        torque_limit: ArrayLike | None = None,
    ) -> None:
        given = {
            "mu": mu, "normal_min": normal_min, "normal_max": normal_max, "force_weight": force_weight,
        }  # fmt: skip
        self._given = tuple(real_array(name, value) for name, value in given.items())
        self._roots = np.sqrt(wrench_metric(wrench_weights))
        self._smoothness = real_number("smoothness", smoothness, low=0.0, high=1e300)
        self.tol = real_number("tol", tol, low=0.0)
        self._limit = int(real_number("max_iterations", max_iterations, low=1, high=10**9))
        self._torque_limit = None if torque_limit is None else torque_limits(torque_limit)
        count = contact_count(self._given)
        self._build(1 if count is None else count)  # one contact, until the first grasp map says how many

    def _build(self, count: int) -> None:
        """Check the per-contact parameters for a number of contacts and make the work space."""
        _call_directly()
        mu, low, high, weight = self._given
        self._bounds = normal_bounds(low, high, count)
        self._shape, self._forces_shape = (6, 3 * count), (count, 3)
        self._code = layout.INVALID
        self.work = work = layout.new_work(count)
        rows, results = work[:count], work[count + 1]
        work[count, layout.ROOT : layout.ROOT + 6] = self._roots
        # the solver's forces are in units in which every weight is one: r ||f - f_ref||² + s ||f - f_last||²
        weights = force_weights(weight, count)
        units = 1.0 / np.sqrt(weights + self._smoothness)
        rows[:, layout.TANGENT], rows[:, layout.NORMAL] = units.T
        rows[:, layout.PULL : layout.PULL + 2] = weights * units
        rows[:, layout.DRAG : layout.DRAG + 2] = self._smoothness * units
        rows[:, layout.MU] = friction(mu, count) * units[:, 1] / units[:, 0]
        results[layout.TOLERANCE] = self.tol * (1.0 / units.max() if count else 1.0)
        results[layout.LIMIT] = self._limit
        self._rows: RowsWork | None = None
        self.set_active(np.ones(count, dtype=np.bool_))

    @property
    def _results(self) -> FloatArray:
        """The row of the work space with what the last call found, and what the next starts from."""
        return np.asarray(self.work[self._forces_shape[0] + 1])

    def solve(
        self,
        grasp_map: ArrayLike,
        wrench: ArrayLike,
        reference: ArrayLike | None = None,
        active: ArrayLike | None = None,
        jacobian: ArrayLike | None = None,
        torque_offset: ArrayLike | None = None,
    ) -> FloatArray:
        """Return the optimal contact forces.

        Parameters
        ----------
        grasp_map
            (6, 3n) map from stacked contact forces (contact frames) to [force; moment] [-, m].
        wrench
            (6,) wanted [force; moment] on the robot [N, N·m].
        reference
            (n, 3) wanted forces [N]; kept until the next reference. Zero at first.
        active
            (n,) mask of the contacts that may carry force; kept until the next mask: `active` tells it.
        jacobian
            (3n, joints) map from joint velocities to contact velocities in contact frames [m]. With it
            the joint torques obey ``|jacobian.T @ f + torque_offset| <= torque_limit``. If no
            admissible force does, `status` is INFEASIBLE and the forces come close to the least
            sum of squared excess.
        torque_offset
            (joints,) torques that the contact forces are added to [N·m]; zero if not given.

        Returns
        -------
        FloatArray
            (n, 3) [N] in contact frames, inside every cone and bound. For NaN or infinite input, be it of a
            contact that is off, the last command, brought into the cones; `status` is then INVALID.

        Raises
        ------
        ProblemError
            For a wrong shape or input that is not numbers, and for nothing else.
        """
        try:
            A, w = numbers("grasp_map", grasp_map), numbers("wrench", wrench)
        except ProblemError as error:
            raise ProblemError(NOT_NUMBERS) from error
        if A.shape != self._shape or w.shape != _WRENCH:
            self._fit(A, w)
        if active is not None:
            self.set_active(active)
        if reference is not None:
            self.set_reference(reference)
        if jacobian is not None:
            return self.solve_with_rows(A, w, *self._torque_rows(jacobian, torque_offset))
        forces = _empty(self._forces_shape)
        self._code = _distribute(A, w, self.work, forces)
        return forces

    def _torque_rows(
        self, jacobian: ArrayLike, offset: ArrayLike | None
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the limits on joint torques as rows on the forces."""
        if self._torque_limit is None:
            raise ProblemError("a Jacobian was given, but ForceDistributor was built without torque_limit")
        J, limit = numbers("jacobian", jacobian), self._torque_limit
        shift = np.zeros_like(limit) if offset is None else numbers("torque_offset", offset)
        if J.shape != (self._shape[1], limit.size) or shift.shape != limit.shape:
            raise ProblemError(
                f"jacobian must have shape ({self._shape[1]}, {limit.size}) and torque_offset "
                f"({limit.size},), got {J.shape} and {shift.shape}"
            )
        return J.T, -limit - shift, limit - shift

    def solve_with_rows(
        self,
        grasp_map: ArrayLike,
        wrench: ArrayLike,
        rows: ArrayLike,
        low: ArrayLike,
        high: ArrayLike,
    ) -> FloatArray:
        """Return the optimal forces that also keep ``low <= rows @ f <= high``.

        For linear limits of any kind, as the bounds on the sum of a sole's corner forces; `status` and
        `torque_excess` speak of these rows as they do of joint torques.

        Parameters
        ----------
        grasp_map, wrench
            As for `solve`.
        rows
            (k, 3n) acting on the stacked forces [-, or m where a row is a moment].
        low, high
            (k,) in the unit of rows @ f [N, or N m], infinite where there is no bound.

        Returns
        -------
        FloatArray
            (n, 3) [N] in contact frames.

        Raises
        ------
        ProblemError
            For a wrong shape.
        """
        A, w = numbers("grasp_map", grasp_map), numbers("wrench", wrench)
        if A.shape != self._shape or w.shape != _WRENCH:
            self._fit(A, w)
        C, lower, upper = numbers("rows", rows), numbers("low", low), numbers("high", high)
        if C.ndim != 2 or C.shape[1] != self._shape[1] or not lower.shape == upper.shape == C.shape[:1]:
            raise ProblemError(
                f"rows must have shape (k, {self._shape[1]}) and low and high (k,), "
                f"got {C.shape}, {lower.shape} and {upper.shape}"
            )
        forces = np.empty(self._forces_shape)
        if self._rows is None or len(self._rows[-1]) != len(C):  # anew only for another number of rows
            self._rows = rows_work(len(forces), len(C))
            self._results[layout.ROWS_WARM] = 0.0
        J = np.ascontiguousarray(C.T)
        self._code = distribute_with_rows(A, w, J, lower, upper, self.work, *self._rows, forces)
        return forces

    def _fit(self, grasp_map: FloatArray, wrench: FloatArray) -> None:
        """Take the number of contacts from the first grasp map, or say which shape is wrong."""
        if wrench.shape != _WRENCH:
            raise ProblemError(f"wrench must have shape (6,), got {wrench.shape}")
        columns = grasp_map.shape[-1] if grasp_map.ndim == 2 else -1
        fixed = contact_count(self._given) is not None
        if grasp_map.shape != (6, columns) or columns % 3 or fixed:
            wanted = f"(6, {self._shape[1]})" if fixed else "(6, 3n)"
            raise ProblemError(f"grasp_map must have shape {wanted}, got {grasp_map.shape}")
        self._build(columns // 3)

    def set_active(self, active: ArrayLike) -> None:
        """Switch contacts on and off: (n,) mask. A contact that is off carries exactly zero.

        Raises
        ------
        ProblemError
            For a wrong shape, or a mask that is not finite.
        """
        on = np.ascontiguousarray(finite_array("active", active) != 0.0)
        if on.shape != self._forces_shape[:1]:
            raise ProblemError(f"active must have shape {self._forces_shape[:1]}, got {on.shape}")
        layout.set_limits(self.work, *self._bounds, on)

    def set_bounds(
        self, normal_min: ArrayLike, normal_max: ArrayLike, active: BoolArray | None = None
    ) -> None:
        """Change the bounds on the normal forces, (n,) or numbers [N]; contacts are on, or as (n,) `active`.

        A contact whose upper bound is zero carries exactly zero.

        Raises
        ------
        ProblemError
            For a wrong shape, a negative bound, or bounds out of order.
        """
        low, high = numbers("normal_min", normal_min), numbers("normal_max", normal_max)
        shape = self._forces_shape[:1]
        on = np.ones(shape, dtype=np.bool_) if active is None else active
        wrong = not low.shape == high.shape == on.shape == shape
        if wrong or layout.set_limits(self.work, low, high, on) >= 0:
            self._bounds = normal_bounds(normal_min, normal_max, shape[0])
            self.set_active(on)
        else:
            self._bounds[0][:], self._bounds[1][:] = low, high

    def set_friction(self, mu: ArrayLike) -> None:
        """Change the friction [-], (n,) or a number."""
        rows = self.work[: self._forces_shape[0]]
        rows[:, layout.MU] = friction(mu, len(rows)) * rows[:, layout.NORMAL] / rows[:, layout.TANGENT]

    def set_reference(self, forces: ArrayLike) -> None:
        """Set the wanted forces: (n, 3) [N]."""
        wanted = numbers("reference", forces)
        if wanted.shape != self._forces_shape:
            raise ProblemError(f"reference must have shape {self._forces_shape}, got {wanted.shape}")
        self.work[: len(wanted), layout.REFERENCE : layout.REFERENCE + 3] = wanted

    @property
    def reference(self) -> FloatArray:
        """The wanted forces: (n, 3) [N], to be written in place by loops that cannot wait."""
        return self.work[: self._forces_shape[0], layout.REFERENCE : layout.REFERENCE + 3]

    def reset(self, forces: ArrayLike | None = None) -> None:
        """Forget the warm start; the last command becomes `forces`, (n, 3) [N], or none."""
        results = self._results
        results[layout.WARM] = results[layout.ROWS_WARM] = 0.0
        results[layout.HAS_LAST] = 0.0 if forces is None else 1.0
        last = np.zeros(self._forces_shape) if forces is None else finite_array("forces", forces)
        if last.shape != self._forces_shape:
            raise ProblemError(f"forces must have shape {self._forces_shape}, got {last.shape}")
        self.work[: len(last), layout.LAST : layout.LAST + 3] = last

    @property
    def active(self) -> BoolArray:
        """(n,) which contacts could carry force in the last `solve`, and can in the next without a mask.

        A copy; those with an upper bound of zero are off. Before the first `solve` without (n,) parameters,
        the one contact that there is until a grasp map says how many.
        """
        return np.asarray(self.work[: self._forces_shape[0], layout.CEILING] > 0.0)

    @property
    def status(self) -> Status:
        """How the last `solve` ended; the forces are feasible whatever it says."""
        return _STATUS[self._code]

    @property
    def iterations(self) -> int:
        """Newton iterations of the last `solve`."""
        return int(self._results[layout.ITERATIONS])

    @property
    def force_error(self) -> float:
        """Upper bound on the distance from the last forces to the optimum, over all contacts [N].

        By the duality gap. Rows that bind are kept 1e-9 of their unit inside their limits, which the gap
        counts: the bound is then about the root of that, far above the true error. Infinite if the optimum
        was not reached, where the input was not finite, and before the first `solve`.
        """
        return float(self._results[layout.FORCE_ERROR])

    @property
    def torque_excess(self) -> float:
        """By how much the worst joint torque of the last `solve` with a Jacobian exceeds its limit [N·m].

        Negative or zero if all are within, infinite where the input was not finite.
        """
        return float(self._results[layout.ROW_VIOLATION])

    @property
    def wrench_error(self) -> float:
        """``||A f - w||_W`` of the last forces [N], weights included. Infinite if that is unknown."""
        return float(self._results[layout.WRENCH_ERROR])
