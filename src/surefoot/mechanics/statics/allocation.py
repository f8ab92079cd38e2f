"""Sharing a wrench among the feet of a standing robot, step by step, on exact friction cones.

The forces keep away from the cones' edges in two ways. The least forces that give a wrench have the same
tangential force at every foot, so that a foot with little weight on it is asked for more than its friction;
forces parallel to the wanted one use the same share of every foot's friction, which on plane ground is the
least that is possible. So the tangential forces are drawn to those: the wanted force, shared as the normal
forces of the step before were. And the wrench is first sought within a share of the friction; only what
that cannot give takes the whole cones.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.kernels import MATRIX, VECTOR, entry_point, kernel
from surefoot.base.memory import Memory, Remembering
from surefoot.contact import Status
from surefoot.mechanics.statics.force_distribution import ForceDistributor

SHARES = 0.9, 1.0
"""Shares of the friction: forces use the first as long as it gives the wanted wrench."""
MARGIN_COST = 5e-3
"""A wrench counts as given within the first share of friction if no more than so much of it is missing."""


@kernel
def draw_to_parallel(
    grasp_map: FloatArray,
    wrench: FloatArray,
    weights: FloatArray,
    last: FloatArray,
    normal_max: FloatArray,
    out: FloatArray,
) -> float:
    """Write the tangential parts of forces parallel to the wanted one; return the wrench's squared size.

    Parameters
    ----------
    grasp_map, wrench, weights
        (6, 3n), (6,) and (6,); the first three rows of the map are the axes of the contact frames.
    last
        (n, 3) forces of the step before [N], whose normal parts say how the wanted force is shared; equally
        where none pushed.
    normal_max
        (n,) zero for contacts that are off [N].
    out
        (n, 3) [N]; its normal parts become zero.
    """
    total, count = 0.0, 0
    for k in range(last.shape[0]):
        if normal_max[k] > 0.0:
            total += last[k, 2]
            count += 1
    for k in range(last.shape[0]):
        # Of the wanted force, which the first three rows give in contact axes, each foot takes the share of
        # the weight that it had: all then use the same share of their friction.
        part = 0.0
        if normal_max[k] > 0.0:
            part = last[k, 2] / total if total > 0.0 else 1.0 / count
        for j in range(2):
            c = 3 * k + j
            axis = grasp_map[0, c] * wrench[0] + grasp_map[1, c] * wrench[1] + grasp_map[2, c] * wrench[2]
            out[k, j] = part * axis
        out[k, 2] = 0.0
    size = 0.0
    for i in range(6):
        size += weights[i] * wrench[i] * wrench[i]
    return size


@cache
def _draw() -> Callable[..., float]:
    """Return `draw_to_parallel` itself, for the only types that are passed here."""
    strided = MATRIX.copy(layout="A")
    return entry_point(draw_to_parallel, MATRIX, VECTOR, VECTOR, MATRIX, VECTOR, strided)


class ExactAllocation(Remembering):
    """Exact friction cones through `ForceDistributor`.

    Parameters
    ----------
    mu
        (n,) friction coefficients.
    wrench_weights
        (6,) weights of the wrench's components.
    force_weight
        Weight of the square of the forces' distance from parallel ones.

    Attributes
    ----------
    status
        How the last `share` ended.
    """

    MEMORY = ("_within", "_whole", "_bounds", "_last")

    def __init__(self, mu: FloatArray, wrench_weights: FloatArray, force_weight: float) -> None:
        self._within, self._whole = (
            ForceDistributor(part * mu, 0.0, np.inf, wrench_weights, force_weight) for part in SHARES
        )
        self._bounds = b"", b""
        self._known: tuple[FloatArray, FloatArray] | None = None  # arrays that hold the bounds
        self._weights = np.ascontiguousarray(wrench_weights, dtype=np.float64)
        self._zero = np.zeros((len(mu), 3))
        self.reset()

    def reset(self) -> None:
        """Forget the forces of the step before."""
        self._last = self._zero
        self.status = Status.SOLVED
        self._within.reset()
        self._whole.reset()

    def resume(self, memory: Memory) -> None:
        """See `Remembering`."""
        super().resume(memory)
        self._known = None

    def share(
        self, grasp_map: FloatArray, wrench: FloatArray, normal_min: FloatArray, normal_max: FloatArray
    ) -> FloatArray:
        """Return (n, 3) forces [N] in contact frames, inside every cone and bound.

        Parameters
        ----------
        grasp_map, wrench
            (6, 3n) map from forces to their wrench; (6,) what they should give [N, N m].
        normal_min, normal_max
            (n,) bounds on the normal forces [N]; the same arrays are taken to hold the same numbers.
        """
        if self._known is None or self._known[0] is not normal_min or self._known[1] is not normal_max:
            self._set_bounds(normal_min, normal_max)
        draw = _draw()
        for distributor in (self._within, self._whole):
            size = draw(grasp_map, wrench, self._weights, self._last, normal_max, distributor.reference)
            forces = distributor.solve(grasp_map, wrench)
            if distributor.wrench_error**2 <= MARGIN_COST**2 * size or distributor.status is Status.INVALID:
                break
        if distributor.status is Status.INVALID:  # hold the last command, whoever found it
            distributor.reset(self._last)
            forces = distributor.solve(grasp_map, wrench)
        self.status, self._last = distributor.status, forces
        return forces

    def _set_bounds(self, low: FloatArray, high: FloatArray) -> None:
        """Take other bounds, (n,) each [N]: where the numbers are those of before, nothing begins anew."""
        self._known, bounds = (low, high), (low.tobytes(), high.tobytes())
        if bounds != self._bounds:
            self._bounds = bounds
            self._within.set_bounds(low, high)
            self._whole.set_bounds(low, high)
