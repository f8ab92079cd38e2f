"""Every form on every problem from the same random starts, judged by one definition."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.motion.planning.direct.direct_planner import SMOOTHINGS, plan_direct
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.direct.textbook import PROBLEMS, SmallProblem
from surefoot.motion.planning.transcription.contact_rows import Facets, GivenModes, read_modes
from surefoot.motion.planning.transcription.initial_guess import Guess
from surefoot.motion.planning.transcription.motion_errors import complementarity, window_miss
from surefoot.motion.planning.transcription.nlp import Iterate
from surefoot.motion.planning.transcription.smoothed_complementarity import (
    FORMS,
    fischer_burmeister_eps,
    schedule,
)

MOST, EACH = 1200, 200
"""Iterations of Ipopt that a start is given, over all stages and in each."""
LAWFUL, KEPT, CLOSE = 1e-6, 1e-8, 1e-6
"""A motion is solved where min(a, b) of all pairs, its rows and bounds, and its end are off by less [SI]."""
BOOK = (0.1, 0.05, 0.01, 0.005, 0.001, 0.0005, 0.00025, 0.000125, 0.0000625)
"""A textbook's schedule: 0.1 to 0.001, then halves until below 1e-4, in its sqrt(a² + b² + eps²)."""
IPOPT: dict[str, Any] = {"tol": 1e-9, "constr_viol_tol": 1e-13, "bound_relax_factor": 0.0}
"""Of all stages. A row a b = eps is flat where both are small: with rows right to 1e-10 a pair
may be off by 1e-5."""
FIRST_STAGE: dict[str, Any] = {"mu_init": 0.1, "bound_push": 1e-2, "bound_frac": 1e-2}
"""Of the first stage."""
PUSHES = ("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac", "mult_bound_push")
"""How far a warm start is moved inside its bounds."""


@dataclass(frozen=True)
class Variant:
    """A way to soften: the form, and what else may matter.

    Attributes
    ----------
    name
        For tables.
    form
        See `forms.FORMS`.
    smoothings
        The continuation's [m N s].
    most
        Iterations over all stages.
    options, first
        Ipopt's, for all stages and for the first.
    polished
        Whether a last stage holds the modes of the contacts.
    planned
        Whether it is the method of `plan_direct`, as the tasks take it.
    """

    name: str
    form: str
    smoothings: tuple[float, ...] = schedule()
    most: int = MOST
    options: tuple[tuple[str, Any], ...] = ()
    first: tuple[tuple[str, Any], ...] = ()
    polished: bool = False
    planned: bool = False


@dataclass(frozen=True, eq=False)
class Stage:
    """One of Ipopt's runs: its smoothing, its iterate, and how far the motion is from the laws."""

    eps: float
    iterate: Iterate
    complementarity: float


@dataclass(frozen=True, eq=False)
class Answer:
    """What a continuation found: its motion, gaps at the knots' ends (N, p), stages, CPU time, cost."""

    motion: Guess
    gaps: FloatArray
    stages: tuple[Stage, ...]
    seconds: float
    cost: float
    solved: bool

    @property
    def iterations(self) -> int:
        """Of Ipopt, all stages together."""
        return sum(stage.iterate.iterations for stage in self.stages)

    @property
    def complementarity(self) -> float:
        """Of the motion: max |min(a, b)|."""
        return self.stages[-1].complementarity

    @property
    def product(self) -> float:
        """Largest gap times normal impulse [m N s]."""
        return float(np.abs(self.gaps * self.motion.impulses[..., 2]).max())


def chase(small: SmallProblem, variant: Variant, seed: int) -> Answer:
    """Return what a variant makes of a random start of a problem."""
    begun, problem = time.process_time(), small.problem
    if variant.planned:
        return _planned(small, variant, seed)
    nlp, z = DirectNlp(problem, Facets(variant.form, problem.dt)), small.guess(seed)
    variables, multipliers, stages = nlp.pack(z), None, list[Stage]()
    for eps in variant.smoothings:
        left = variant.most - sum(stage.iterate.iterations for stage in stages)
        if left <= 0:
            break
        options = IPOPT | {"max_iter": min(EACH, left)} | dict(variant.options)
        if multipliers is None:
            options |= FIRST_STAGE | dict(variant.first)
        else:
            options |= {"warm_start_init_point": "yes", "mu_init": min(1e-3, eps)}
            options |= {f"warm_start_{name}": min(1e-6, eps) for name in PUSHES}
        found = nlp.solve(variables, eps, multipliers=multipliers, **options)
        variables, multipliers, motion = found.variables, found.multipliers, nlp.unpack(found.variables)
        stages.append(Stage(eps, found, _off(nlp, motion)))
        if not found.finite:
            break
    if variant.polished and found.finite:
        motion, stage = _polished(nlp, motion)
        stages.append(stage)
    return _answer(small, nlp, motion, stages, time.process_time() - begun)


def _polished(nlp: DirectNlp, motion: Guess) -> tuple[Guess, Stage]:
    """Return a motion with its contacts' modes held, and how that went: nothing is soft."""
    problem, law = nlp.problem, GivenModes()
    modes = read_modes(motion.impulses, *nlp.contact_speeds(motion), problem.frictions)
    held, mu = DirectNlp(problem, law), problem.frictions
    found = held.solve(
        held.pack(motion), 0.0, contact_bounds=law.bounds(modes, mu),
        row_bounds=law.row_bounds(modes, mu),
        max_iter=EACH, **(IPOPT | {"mu_init": 1e-4, "bound_push": 1e-6, "bound_frac": 1e-6}),
    )  # fmt: skip
    better = held.unpack(found.variables)
    return better, Stage(0.0, found, _off(nlp, better))


def _planned(small: SmallProblem, variant: Variant, seed: int) -> Answer:
    """Return what the tasks' own method makes of a start."""
    begun, problem = time.process_time(), small.problem
    found = plan_direct(problem, guess=small.guess(seed), smoothings=variant.smoothings, total=variant.most)
    spent, nlp = time.process_time() - begun, DirectNlp(problem, GivenModes())
    off = _off(nlp, found.motion)
    stages = [Stage(smoothing, run, off) for smoothing, run in found.stages]
    return _answer(small, nlp, found.motion, stages, spent)


def _off(nlp: DirectNlp, motion: Guess) -> float:
    """Return max |min(a, b)| of a motion."""
    closing, sliding = nlp.contact_speeds(motion)
    return complementarity(motion.impulses, nlp.problem.dt * closing, sliding, nlp.problem.frictions)


def _answer(small: SmallProblem, nlp: DirectNlp, motion: Guess, stages: list[Stage], spent: float) -> Answer:
    """Judge a motion: by the laws, its rows and its end."""
    problem, last = small.problem, stages[-1].iterate
    end = replace(problem, end=small.done, windows={})
    missed = window_miss(end, motion) if np.isfinite(motion.q).all() else np.inf
    solved = stages[-1].complementarity < LAWFUL and last.violation < KEPT and missed < CLOSE
    cost = problem.dt * problem.weights.torque * float((motion.torques**2).sum())
    gaps = problem.dt * nlp.contact_speeds(motion)[0]
    return Answer(motion, gaps, tuple(stages), spent, cost, bool(solved))


def limited(variant: Variant, most: int) -> Variant:
    """Return the variant with at most so many iterations for a start."""
    return replace(variant, most=min(variant.most, most))


RACE = tuple(Variant(name, name) for name in FORMS)
"""Every form on the same path, 0.1 to 1e-13."""


_FB, _RELAXED = "fischer-burmeister", "relaxed"
CAUSES = (
    Variant("FB", _FB),
    Variant("FB, with a >= 0, b >= 0", "fischer-burmeister-signs"),
    Variant("FB, <= 0 in place of = 0", "fischer-burmeister-relaxed"),
    Variant("FB, from 1e-3", _FB, schedule(1e-3)),
    Variant("FB, book's schedule", _FB, tuple(fischer_burmeister_eps(e) for e in BOOK)),
    Variant("FB, mu_strategy adaptive", _FB, options=(("mu_strategy", "adaptive"),)),
    Variant("FB, modes held at the end", _FB, polished=True),
    Variant("relaxed", _RELAXED),
    Variant("relaxed, = eps in place of <=", "equal"),
    Variant("equal, rows to 1e-10 only", "equal", options=(("constr_viol_tol", 1e-10),)),
    Variant(
        "relaxed, Ipopt's barrier from 1e-9", _RELAXED,
        first=(("mu_init", 1e-9), ("bound_push", 1e-8), ("bound_frac", 1e-8)),
    ),
)  # fmt: skip
"""One thing changed at a time: which change makes the one like the other?"""
FIRST = tuple(
    Variant(f"{form} from {first:.0e}", form, schedule(first))
    for form in (_RELAXED, "equal", _FB)
    for first in (1e-1, 1e-3, 1e-5, 1e-8)
)
"""What the first smoothing does."""
RECOMMENDED = Variant("recommended", _RELAXED, SMOOTHINGS, 2000, planned=True)
"""What the tasks use: the direct method, relaxed to 1e-8 and then the modes held."""


@dataclass(frozen=True)
class Row:
    """A variant on a problem, over its starts.

    Attributes
    ----------
    problem, variant
        Their names.
    solved, starts
        How many of how many.
    iterations, seconds
        Medians over the starts, CPU time.
    product, complementarity
        Medians of max gap · impulse and of max |min(a, b)|.
    cost
        Median over solved starts, NaN without any.
    step
        Median over all iterations of the share of its direction that was gone.
    regularised
        Share of iterations whose Hessian had to be made convex.
    trace
        (smoothing, iterations so far, max |min(a, b)|) of the stages of the first start.
    """

    problem: str
    variant: str
    solved: int
    starts: int
    iterations: float
    seconds: float
    product: float
    complementarity: float
    cost: float
    step: float
    regularised: float
    trace: tuple[tuple[float, int, float], ...]


def run(
    variants: Sequence[Variant], problems: Sequence[str], starts: int, note: Callable[[str], None]
) -> Iterator[tuple[Row, Answer]]:
    """Yield the row of every variant on every problem, and the answer from the first start."""
    for name in problems:
        small = PROBLEMS[name]()
        for variant in variants:
            answers = []
            for seed in range(starts):
                note(f"{name}: {variant.name}, start {seed + 1} of {starts}")
                answers.append(chase(small, variant, seed))
            yield row_of(name, variant, answers), answers[0]


def row_of(problem: str, variant: Variant, answers: Sequence[Answer]) -> Row:
    """Return what a variant made of its starts."""
    costs = [a.cost for a in answers if a.solved]
    stages = [stage for answer in answers for stage in answer.stages]
    steps = [step for stage in stages for step in stage.iterate.steps]
    so_far = np.cumsum([stage.iterate.iterations for stage in answers[0].stages])
    trace = tuple(
        (stage.eps, int(count), stage.complementarity)
        for stage, count in zip(answers[0].stages, so_far, strict=True)
    )
    return Row(
        problem, variant.name, len(costs), len(answers),
        float(np.median([a.iterations for a in answers])),
        float(np.median([a.seconds for a in answers])),
        float(np.median([a.product for a in answers])),
        float(np.median([a.complementarity for a in answers])),
        float(np.median(costs)) if costs else float("nan"),
        float(np.median(steps)) if steps else float("nan"),
        sum(s.iterate.regularised for s in stages) / max(1, sum(s.iterate.iterations for s in stages)),
        trace,
    )  # fmt: skip
