"""Ipopt on a scheduled motion, and the motion through the exact step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import build_nlp
from surefoot.planning.direct.search import QUIET
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.planning.schedule.transcribe import row_bounds, transcribe, variable_bounds
from surefoot.planning.transcription.forms import import_casadi

TOLERANCE = 1e-8
"""Of Ipopt."""
ACCEPTED = 1e-6
"""Largest violation of a row or bound, in its own scale, of a motion that counts as found."""


@dataclass(frozen=True, eq=False)
class ScheduledMotion:
    """What the optimiser found.

    Attributes
    ----------
    q, v
        (N + 1, nq), (N + 1, nv).
    torques
        (N, joints) [N m].
    forces
        (N, p, 3) in contact axes [N].
    cost, violation
        Objective, and the largest violation of a row or bound.
    found
        Whether the violation is within `ACCEPTED`: the motion keeps to dynamics, modes and limits.
    iterations
        Ipopt's.
    said
        Its return status.
    variables
        To start the next search from.
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    forces: FloatArray
    cost: float
    violation: float
    found: bool
    iterations: int
    said: str
    variables: FloatArray


def start_from(
    problem: ScheduleProblem, v: FloatArray | None = None, motion: ScheduledMotion | None = None
) -> FloatArray:
    """Return variables to start from: the reference with the weight on the feet that stand, or a motion.

    Parameters
    ----------
    problem
        Whose reference it is.
    v
        (knots + 1, nv) velocities; None for those between the references.
    motion
        A motion of the same robot with other knots, stretched to those of the problem.
    """
    import pinocchio

    robot, n, p = problem.robot, problem.knots, len(problem.robot.contact_points)
    if motion is not None:
        return _stretched(problem, motion)
    speeds = np.zeros((n + 1, robot.model.nv))
    for k in range(n):
        speeds[k + 1] = (
            pinocchio.difference(robot.model, problem.reference[k], problem.reference[k + 1]) / problem.dt
        )
    speeds = speeds if v is None else v
    forces = np.zeros((n, p, 3))
    standing = problem.stance.sum(axis=1, keepdims=True)
    forces[:, :, 2] = problem.stance / np.maximum(standing, 1)
    states = np.hstack([problem.reference, speeds])
    u = np.hstack([np.zeros((n, robot.joints)), forces.reshape(n, -1)])
    return np.concatenate([np.hstack([states[:-1], u]).ravel(), states[-1]])


def _stretched(problem: ScheduleProblem, motion: ScheduledMotion) -> FloatArray:
    """Return the variables of a motion at the times of another problem's knots."""
    have, want = np.linspace(0.0, 1.0, len(motion.q)), np.linspace(0.0, 1.0, problem.knots + 1)

    def at(values: FloatArray, places: FloatArray, of: FloatArray) -> FloatArray:
        flat = values.reshape(len(values), -1)
        return np.column_stack([np.interp(of, places, column) for column in flat.T])

    q, v = at(motion.q, have, want), at(motion.v, have, want)
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    torques = at(motion.torques, have[:-1], want[:-1]) / problem.torque_limits
    forces = at(motion.forces, have[:-1], want[:-1]) / problem.weight
    forces *= np.repeat(problem.stance, 3, axis=1)
    states = np.hstack([q, v])
    return np.concatenate([np.hstack([states[:-1], torques, forces]).ravel(), states[-1]])


def optimise(
    problem: ScheduleProblem,
    start: FloatArray | None = None,
    max_iterations: int = 500,
    tell: Callable[[int, float, float], None] | None = None,
    **options: Any,
) -> ScheduledMotion:
    """Return the best motion that Ipopt finds over a problem's schedule.

    Parameters
    ----------
    problem
        See `ScheduleProblem`.
    start
        Variables to start from, see `start_from`; None for the reference.
    max_iterations
        Of Ipopt.
    tell
        Called with the number of every iteration, cost and violation.
    options
        Ipopt's, without their prefix.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    ca = import_casadi()
    block, parts = transcribe(problem)
    nlp, derivatives = build_nlp(block, problem.knots)
    low, high = row_bounds(problem, parts)
    kept = np.flatnonzero((np.isfinite(low) | np.isfinite(high)).ravel())
    nlp, derivatives = _only(nlp, derivatives, kept)
    given = {
        **QUIET, "ipopt.tol": TOLERANCE, "ipopt.max_iter": max_iterations, "ipopt.mu_strategy": "adaptive",
        **{f"ipopt.{name}": value for name, value in options.items()}, **derivatives,
    }  # fmt: skip
    if tell is not None:
        given["iteration_callback"] = _listener(nlp, tell)
    solver = ca.nlpsol("schedule", "ipopt", nlp, given)
    below, above = variable_bounds(problem)
    begin = start_from(problem) if start is None else start
    row_low, row_high = low.ravel()[kept], high.ravel()[kept]
    out = solver(
        x0=np.clip(begin, below, above), p=problem.reference[1:].ravel(), lbx=below, ubx=above, lbg=row_low,
        ubg=row_high,
    )  # fmt: skip
    said = solver.stats()
    x, g = np.array(out["x"]).ravel(), np.array(out["g"]).ravel()
    beyond = [below - x, x - above, row_low - g, g - row_high]
    violation = float(max(np.max(b, initial=0.0) for b in beyond))
    ended = float(out["f"]), violation, int(said["iter_count"]), str(said["return_status"])
    return _read(problem, x, *ended)


def _only(
    nlp: dict[str, Any], derivatives: dict[str, Any], kept: Any
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return an NLP without the rows that nothing bounds."""
    ca, x, p = import_casadi(), nlp["x"], nlp["p"]
    rows = [int(k) for k in kept]
    g, jacobian = derivatives["jac_g"](x, p)
    lam_f, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", len(rows))
    total = int(nlp["g"].shape[0])
    spread = ca.DM(ca.Sparsity.triplet(total, len(rows), rows, list(range(len(rows)))), 1.0)
    curved = derivatives["hess_lag"](x, p, lam_f, ca.mtimes(spread, lam))
    names = ["x", "p"]
    fewer = {
        "grad_f": derivatives["grad_f"],
        "jac_g": ca.Function("nlp_jac_g", [x, p], [g[rows], jacobian[rows, :]], names, ["g", "jac:g:x"]),
        "hess_lag": ca.Function(
            "nlp_hess_l", [x, p, lam_f, lam], [curved], [*names, "lam:f", "lam:g"], ["triu:hess:gamma:x:x"]
        ),
    }
    return {**nlp, "g": nlp["g"][rows]}, fewer


def _listener(nlp: dict[str, Any], tell: Callable[[int, float, float], None]) -> Any:
    """Return what CasADi calls at every iteration."""
    ca = import_casadi()
    sizes = {"x": nlp["x"].shape[0], "g": nlp["g"].shape[0], "p": nlp["p"].shape[0]}
    lengths = {"x": sizes["x"], "lam_x": sizes["x"], "g": sizes["g"], "lam_g": sizes["g"],
               "p": 0, "lam_p": sizes["p"], "f": 1}  # fmt: skip

    class Listener(ca.Callback):  # type: ignore[misc]
        """Counts iterations and passes on the cost."""

        def __init__(self) -> None:
            ca.Callback.__init__(self)
            self.count = 0
            self.construct("listener", {})

        def get_n_in(self) -> int:
            return int(ca.nlpsol_n_out())

        def get_n_out(self) -> int:
            return 1

        def get_sparsity_in(self, i: int) -> Any:
            return ca.Sparsity.dense(lengths.get(ca.nlpsol_out(i), 0), 1)

        def eval(self, arguments: Any) -> list[float]:
            self.count += 1
            told = {ca.nlpsol_out(i): arguments[i] for i in range(len(arguments))}
            tell(self.count, float(told["f"]), float("nan"))
            return [0.0]

    return Listener()


def _read(
    problem: ScheduleProblem, x: FloatArray, cost: float, violation: float, iterations: int, said: str
) -> ScheduledMotion:
    """Return the motion that variables mean."""
    model, joints = problem.robot.model, problem.robot.joints
    nq, nx, p = int(model.nq), int(model.nq + model.nv), len(problem.robot.contact_points)
    table = x[:-nx].reshape(problem.knots, -1)
    states = np.vstack([table[:, :nx], x[-nx:]])
    torques = table[:, nx : nx + joints] * problem.torque_limits
    forces = table[:, nx + joints :].reshape(-1, p, 3) * problem.weight
    found = bool(violation <= ACCEPTED)
    return ScheduledMotion(
        states[:, :nq].copy(),
        states[:, nq:].copy(),
        torques,
        forces,
        cost,
        violation,
        found,
        iterations,
        said,
        x,
    )
