"""Solve a softened problem again and again, each time less soft, from the last answer."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.planning.transcription.forms import Form, import_casadi
from surefoot.planning.transcription.judge import Outcome, judge
from surefoot.planning.transcription.problem import Motion
from surefoot.planning.transcription.program import Program, transcribe

MODES_HELD = Form("modes held", "of every pair one side is zero, the other >= 0", True)
"""No softening: `polish` says which side."""


@dataclass(frozen=True)
class Stage:
    """One solve of a continuation.

    Attributes
    ----------
    eps
        The smoothing.
    iterations
        Of Ipopt.
    ended
        What Ipopt says.
    outcome
        The motion judged by the laws.
    steps, regularised
        Of its iterations, how far each went along its direction, 1 a full step; and how many needed a
        Hessian made convex by a multiple of the identity.
    """

    eps: float
    iterations: int
    ended: str
    outcome: Outcome
    steps: tuple[float, ...] = ()
    regularised: int = 0


@dataclass(frozen=True)
class Answer:
    """What a continuation found.

    Attributes
    ----------
    motion
        In the coordinates of the problem's system.
    outcome
        Judged by the laws alone.
    stages
        One per smoothing.
    seconds
        CPU time [s].
    """

    motion: Motion
    outcome: Outcome
    stages: tuple[Stage, ...]
    seconds: float

    @property
    def iterations(self) -> int:
        """Of Ipopt, all stages together."""
        return sum(stage.iterations for stage in self.stages)


@dataclass(frozen=True)
class Settings:
    """How Ipopt is used.

    Attributes
    ----------
    iterations, total
        The most of one stage, and of all together.
    first_barrier, barrier
        Ipopt's own barrier parameter at the start of the first stage, and of the later ones: not more than
        the smoothing.
    strategy
        Ipopt's `mu_strategy`.
    tol, row_tol
        Of Ipopt, and of its rows. A row a b = eps is flat where both are small: with rows right to 1e-10 a
        pair may be off by 1e-5, so rows are asked for to rounding.
    push
        Ipopt's `bound_push` and `bound_frac` in the first stage: how far a start is moved inside its bounds.
    more
        Further options of Ipopt, as they are.
    """

    iterations: int = 200
    total: int = 2000
    first_barrier: float = 0.1
    barrier: float = 1e-3
    strategy: str = "monotone"
    tol: float = 1e-9
    row_tol: float = 1e-13
    push: float = 1e-2
    more: tuple[tuple[str, Any], ...] = ()

    def ipopt(self, first: bool, eps: float, most: int) -> dict[str, Any]:
        """Return the options of a stage."""
        out: dict[str, Any] = {
            "print_level": 0,
            "sb": "yes",
            "max_iter": most,
            "tol": self.tol,
            "constr_viol_tol": self.row_tol,
            "bound_relax_factor": 0.0,
            "mu_strategy": self.strategy,
        }
        if first:
            out |= {"mu_init": self.first_barrier, "bound_push": self.push, "bound_frac": self.push}
        else:
            out |= {
                "warm_start_init_point": "yes",
                "mu_init": min(self.barrier, eps),
                **dict.fromkeys(_PUSHES, min(1e-6, eps)),
            }
        return out | dict(self.more)


_QUIET = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False}
_DERIVATIVES = {"grad_f": "grad_f", "jac_g": "jac_g", "hess_lag": "hess_l"}
_PUSHES = (
    "warm_start_bound_push",
    "warm_start_bound_frac",
    "warm_start_slack_bound_push",
    "warm_start_slack_bound_frac",
    "warm_start_mult_bound_push",
)


def polish(program: Program, motion: Motion, settings: Settings | None = None) -> tuple[Motion, Stage]:
    """Return a motion with its contacts' modes held: of every pair the smaller side is zero, nothing is soft.

    What is left is a smooth NLP without complementarity, whose answer obeys the laws to rounding, provided
    that the modes are right.

    Returns
    -------
    tuple
        The motion as Ipopt left it, and how that went; its `Stage.eps` is 0.
    """
    casadi = import_casadi()
    settings = settings or Settings()
    held = transcribe(program.problem, MODES_HELD, program.units)
    z, high = held.pack(motion), held.high.copy()
    a, b = held.sides()
    zero = np.where(z[a] <= z[b], a, b)
    z[zero], high[zero] = 0.0, 0.0
    options = settings.ipopt(False, 1e-9, settings.iterations) | {
        "fixed_variable_treatment": "make_parameter"
    }
    solver = casadi.nlpsol("held", "ipopt", held.nlp, {"ipopt": options, **_QUIET})
    found = solver(x0=z, p=1.0, lbx=held.low, ubx=high, lbg=held.row_low, ubg=held.row_high)
    told, better = solver.stats(), held.unpack(np.array(found["x"]).ravel())
    return better, _stage(0.0, told, judge(program.problem, better))


def _stage(eps: float, told: dict[str, Any], outcome: Outcome) -> Stage:
    """Return what Ipopt's statistics say of a stage."""
    record = told.get("iterations") or {}
    steps = tuple(record.get("alpha_pr", ())[1:])  # its first row is the start
    made = sum(size > 0.0 for size in record.get("regularization_size", ()))
    return Stage(eps, int(told["iter_count"]), str(told["return_status"]), outcome, steps, made)


def follow(
    program: Program,
    start: Motion,
    smoothings: Sequence[float],
    settings: Settings | None = None,
    polished: bool = False,
    tell: Callable[[Stage], None] | None = None,
) -> Answer:
    """Return what Ipopt makes of a start with each smoothing in turn.

    A stage that fails hands on what it reached: the next may do better, and the laws judge the last. With
    `polished` a last stage holds the modes that were found, see `polish`; its answer is taken if the laws
    like it better.

    Raises
    ------
    MissingExtra
        If CasADi is not installed.
    """
    casadi = import_casadi()
    settings = settings or Settings()
    begun, z = time.process_time(), program.pack(start)
    multipliers: dict[str, FloatArray] = {}
    stages: list[Stage] = []
    left = settings.total
    known: dict[str, Any] = {}  # derivatives, which all stages share
    for eps in smoothings:
        options = settings.ipopt(not stages, eps, min(settings.iterations, left))
        solver = casadi.nlpsol("softened", "ipopt", program.nlp, {"ipopt": options, **_QUIET, **known})
        known = known or {name: solver.get_function(f"nlp_{of}") for name, of in _DERIVATIVES.items()}
        found = solver(
            x0=z, p=eps, lbx=program.low, ubx=program.high, lbg=program.row_low, ubg=program.row_high,
            **multipliers,
        )  # fmt: skip
        told = solver.stats()
        z = np.array(found["x"]).ravel()
        multipliers = {name: np.array(found[name[:-1]]).ravel() for name in ("lam_x0", "lam_g0")}
        motion = program.unpack(z)
        stage = _stage(eps, told, judge(program.problem, motion))
        stages.append(stage)
        if tell is not None:
            tell(stage)
        left -= stage.iterations
        if left <= 0 or not np.isfinite(z).all():
            break
    outcome = stages[-1].outcome
    if polished and np.isfinite(z).all():
        better, stage = polish(program, motion, settings)
        stages.append(stage)
        if tell is not None:
            tell(stage)
        if stage.outcome.reached and stage.outcome.error < outcome.error:
            motion, outcome = better, stage.outcome
    return Answer(motion, outcome, tuple(stages), time.process_time() - begun)
