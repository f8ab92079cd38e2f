"""Moving a plan on in time, and reading it between its knots, compiled."""

from __future__ import annotations

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.kernels import inline_kernel, kernel
from surefoot.planning.shooting.state_space import difference, feedback, retract


@inline_kernel
def _between(
    floating: bool, a: FloatArray, b: FloatArray, share: float, out: FloatArray, way: FloatArray
) -> None:
    """Fill out (nq,) with the configuration a share of the way from a to b; `way` (nv,) is scratch."""
    difference(floating, a, b, way)
    for i in range(way.size):
        way[i] *= share
    retract(floating, a, way, out)


@kernel
def move_on(
    floating: bool, q: FloatArray, v: FloatArray, torques: FloatArray, share: float, dt: float
) -> None:
    """Let a plan begin a share of a knot later, in place: states and torques between those of the knots.

    The last state goes on at its velocity, the last torques stay.

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    q, v, torques
        (N + 1, nq), (N + 1, nv) and (N, m).
    share
        0 to 1.
    dt
        Length of a knot [s].
    """
    N, m, n = torques.shape[0], torques.shape[1], v.shape[1]
    way, place = np.empty(n), np.empty(q.shape[1])
    for k in range(N):
        _between(floating, q[k], q[k + 1], share, place, way)
        q[k] = place
        for i in range(n):
            v[k, i] += share * (v[k + 1, i] - v[k, i])
        if k + 1 < N:
            for i in range(m):
                torques[k, i] += share * (torques[k + 1, i] - torques[k, i])
    for i in range(n):
        way[i] = share * dt * v[N, i]
    retract(floating, q[N], way, place)
    q[N] = place


@kernel
def torques_between(
    floating: bool, here: tuple[FloatArray, FloatArray], plan: tuple[FloatArray, FloatArray, FloatArray],
    gains: FloatArray, knot: int, share: float, limits: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill out (m,) with a knot's torques and its feedback on the state planned for now, within limits.

    Parameters
    ----------
    floating
        Whether the configuration begins with a free flyer.
    here
        (nq,) and (nv,) of the state.
    plan
        q (N + 1, nq), v (N + 1, nv) and torques (N, m).
    gains
        (N, m, 2nv).
    knot, share
        Which one, and how much of its time has passed.
    limits
        (2, m) lower and upper bounds [N m].
    out
        (m,) to be filled.
    """
    q, v, torques = plan
    n = v.shape[1]
    way, place, speed = np.empty(n), np.empty(q.shape[1]), np.empty(n)
    _between(floating, q[knot], q[knot + 1], share, place, way)
    for i in range(n):
        speed[i] = v[knot, i] + share * (v[knot + 1, i] - v[knot, i])
    still = np.zeros(out.size)
    feedback(floating, here, (place, speed), torques[knot], still, 0.0, gains[knot], limits, out)
