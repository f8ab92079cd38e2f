"""Ipopt on a scheduled motion, and the motion through the exact step."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.direct.blocks import Block, build_nlp, pack, unpack
from surefoot.planning.direct.search import QUIET
from surefoot.planning.schedule.problem import ScheduleProblem
from surefoot.planning.schedule.transcribe import row_bounds, transcribe, variable_bounds
from surefoot.planning.transcription.forms import import_casadi

TOLERANCE = 1e-8
"""Of Ipopt."""
Tell = Callable[[int, float, float], None]
"""Who hears of the number of an iteration, its cost and its violation."""
ACCEPTED = 1e-6
"""Largest violation of a row or bound, in its own scale, of a motion that counts as found."""


Sides = tuple[FloatArray, FloatArray]
"""Least and largest values."""


class Search(NamedTuple):
    """How Ipopt searches: most iterations, who hears of them, its options without their prefix."""

    max_iterations: int = 500
    tell: Tell | None = None
    options: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Found:
    """What Ipopt found.

    Attributes
    ----------
    variables
        (V,) in their own units: to start the next search from.
    cost, violation
        Objective, and the largest violation of a row or bound in its own scale [-].
    iterations
        Ipopt's.
    said
        Its return status.
    """

    variables: FloatArray
    cost: float
    violation: float
    iterations: int
    said: str

    @property
    def found(self) -> bool:
        """Whether the violation is within `ACCEPTED`: the motion keeps to dynamics, modes and limits."""
        return bool(self.violation <= ACCEPTED)


@dataclass(frozen=True, eq=False)
class ScheduledMotion(Found):
    """What the optimiser found, and the motion that it means.

    Attributes
    ----------
    q, v
        (N + 1, nq), (N + 1, nv).
    torques
        (N, joints) [N m].
    forces
        (N, p, 3) in contact axes [N].
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    forces: FloatArray


def start_from(problem: ScheduleProblem) -> FloatArray:
    """Return (size,) variables to start from: the reference with the weight on the feet that stand."""
    import pinocchio

    robot, n, stance = problem.robot, problem.knots, problem.stance
    speeds = np.zeros((n + 1, robot.model.nv))
    for k in range(n):
        way = pinocchio.difference(robot.model, problem.reference[k], problem.reference[k + 1])
        speeds[k + 1] = way / problem.dt
    forces = np.zeros((n, *stance.shape[1:], 3))
    forces[:, :, 2] = stance / np.maximum(stance.sum(axis=1, keepdims=True), 1)
    inputs = np.hstack([np.zeros((n, robot.joints)), forces.reshape(n, -1)])
    return pack(np.hstack([problem.reference, speeds]), inputs)


def optimise(
    problem: ScheduleProblem,
    start: FloatArray | None = None,
    max_iterations: int = 500,
    tell: Tell | None = None,
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
    block, parts = transcribe(problem)
    search = Search(max_iterations, tell, options)
    begin = start_from(problem) if start is None else start
    found = solve_blocks(
        block, problem.reference[1:], row_bounds(problem, parts), variable_bounds(problem), begin, search
    )
    return _read(problem, found)


def solve_blocks(
    block: Block, data: FloatArray, rows: Sides, variables: Sides, begin: FloatArray, search: Search
) -> Found:
    """Return what Ipopt finds for blocks in a row.

    Parameters
    ----------
    block
        Of every knot.
    data
        (knots, nd) numbers of every knot, in their own units.
    rows, variables
        Least and largest values of the rows (knots, m), and of all variables, in their own units. Rows that
        nothing bounds are left out.
    begin
        Variables to start from, in the unit of each.
    search
        See `Search`.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    ca = import_casadi()
    nlp, derivatives = build_nlp(block, len(data))
    low, high = rows
    kept = np.flatnonzero((np.isfinite(low) | np.isfinite(high)).ravel())
    nlp, derivatives = _only(nlp, derivatives, kept)
    given = {
        **QUIET, "ipopt.tol": TOLERANCE, "ipopt.max_iter": search.max_iterations,
        "ipopt.mu_strategy": "adaptive", **{f"ipopt.{name}": value for name, value in search.options.items()},
        **derivatives,
    }  # fmt: skip
    row_low, row_high = low.ravel()[kept], high.ravel()[kept]
    watch = _Watch(search.tell, row_low, row_high)
    listener = _callback(nlp, watch)
    given["iteration_callback"] = listener
    solver = ca.nlpsol("schedule", "ipopt", nlp, given)
    below, above = variables
    out = solver(
        x0=np.clip(begin, below, above), p=data.ravel(), lbx=below, ubx=above, lbg=row_low, ubg=row_high
    )
    said = solver.stats()
    x, g = np.array(out["x"]).ravel(), np.array(out["g"]).ravel()
    beyond = [below - x, x - above, row_low - g, g - row_high]
    violation = float(max(np.max(b, initial=0.0) for b in beyond))
    told = "interrupted" if watch.interrupted else str(said["return_status"])
    return Found(x, float(out["f"]), violation, int(said["iter_count"]), told)


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


class _Watch:
    """Hears of every iteration, keeps the last one, and ends the search after Ctrl-C.

    Attributes
    ----------
    last
        Variables, rows and cost of the last iteration.
    interrupted
        Whether someone stopped it.
    """

    def __init__(self, tell: Tell | None, low: FloatArray, high: FloatArray) -> None:
        self._tell, self._low, self._high = tell, low, high
        self.count, self.interrupted = 0, False
        self.last: tuple[FloatArray, FloatArray, float] | None = None

    def heard(self, x: Any, g: Any, cost: float) -> bool:
        """Return whether to go on."""
        try:
            self.count += 1
            self.last = np.array(x).ravel(), np.array(g).ravel(), cost
            beyond = np.maximum(self._low - self.last[1], self.last[1] - self._high)
            if self._tell is not None:
                self._tell(self.count, cost, float(beyond.max(initial=0.0)))
        except KeyboardInterrupt:
            self.interrupted = True
        return not self.interrupted


def _callback(nlp: dict[str, Any], watch: _Watch) -> Any:
    """Return what CasADi calls at every iteration."""
    ca = import_casadi()
    variables, rows, parameters = (int(nlp[name].shape[0]) for name in ("x", "g", "p"))
    lengths = {
        "x": variables, "lam_x": variables, "g": rows, "lam_g": rows, "p": 0, "lam_p": parameters, "f": 1,
    }  # fmt: skip

    class Callback(ca.Callback):  # type: ignore[misc, name-defined]
        """Passes iterations on; CasADi asks for its sizes by these names."""

        def __init__(self) -> None:
            ca.Callback.__init__(self)
            self.construct("watch", {})

        def get_n_in(self) -> int:
            """Return the number of Ipopt's outputs."""
            return int(ca.nlpsol_n_out())

        def get_n_out(self) -> int:
            """Return 1: whether to stop."""
            return 1

        def get_sparsity_in(self, i: int) -> Any:
            """Return the shape of an output."""
            return ca.Sparsity.dense(lengths.get(ca.nlpsol_out(i), 0), 1)

        def eval(self, arguments: Any) -> list[float]:
            """Return 0 to go on, 1 to stop."""
            told = {ca.nlpsol_out(i): argument for i, argument in enumerate(arguments)}
            return [0.0 if watch.heard(told["x"], told["g"], float(told["f"])) else 1.0]

    return Callback()


def _read(problem: ScheduleProblem, found: Found) -> ScheduledMotion:
    """Return the motion that variables mean."""
    robot, model = problem.robot, problem.robot.model
    states, inputs = unpack(found.variables, int(model.nq + model.nv), problem.knots)
    q, v = np.split(states, [int(model.nq)], axis=1)
    torques = inputs[:, : robot.joints] * problem.torque_limits
    forces = inputs[:, robot.joints :].reshape(-1, len(robot.contact_points), 3) * problem.weight
    return ScheduledMotion(**vars(found), q=q.copy(), v=v.copy(), torques=torques, forces=forces)
