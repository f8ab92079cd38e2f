"""Every form on every problem from the same random starts, judged by one definition."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from surefoot.planning.transcription.continuation import Answer, Settings, follow
from surefoot.planning.transcription.forms import FORMS, Form, fischer_burmeister_eps, schedule
from surefoot.planning.transcription.problem import SmallProblem
from surefoot.planning.transcription.program import Units, transcribe
from surefoot.planning.transcription.textbook import PROBLEMS
from surefoot.spatial import GRAVITY

MOST = 1200
"""Iterations of Ipopt that a start is given, over all stages."""
PLAIN = Settings(total=MOST)
"""Ipopt as the race uses it."""
BOOK = (0.1, 0.05, 0.01, 0.005, 0.001, 0.0005, 0.00025, 0.000125, 0.0000625)
"""A textbook's schedule: 0.1 to 0.001, then halves until below 1e-4, in its sqrt(a² + b² + eps²)."""


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
        The continuation's.
    settings
        Ipopt's.
    natural
        Whether pairs are softened in units of the problem's own: the impulse that carries the weight for a
        knot, 1 cm and g dt, rather than in SI units.
    polished
        Whether a last stage holds the modes, see `continuation.polish`.
    """

    name: str
    form: Form
    smoothings: tuple[float, ...] = schedule()
    settings: Settings = PLAIN
    natural: bool = False
    polished: bool = False

    def units(self, problem: SmallProblem) -> Units:
        """Return the units in which a problem's pairs are softened."""
        if not self.natural:
            return Units()
        weight = float(np.abs(np.array(problem.system.bias(problem.q, 0.0 * problem.v))).max())
        return Units(length=0.01, impulse=weight * problem.dt, speed=GRAVITY * problem.dt)


def limited(variant: Variant, most: int) -> Variant:
    """Return the variant with at most so many iterations for a start."""
    return replace(variant, settings=replace(variant.settings, total=min(variant.settings.total, most)))


RACE = tuple(Variant(name, form) for name, form in FORMS.items())
"""Every form on the same path, 0.1 to 1e-13."""


def _switch(name: str, form: str, **changed: object) -> Variant:
    return Variant(name, FORMS[form], **changed)  # type: ignore[arg-type]


_FB, _RELAXED = "fischer-burmeister", "relaxed"
CAUSES = (
    _switch("FB", _FB),
    _switch("FB, with a >= 0, b >= 0", "fischer-burmeister-signs"),
    _switch("FB, <= 0 in place of = 0", "fischer-burmeister-relaxed"),
    _switch("FB, from 1e-3", _FB, smoothings=schedule(1e-3)),
    _switch("FB, book's schedule", _FB, smoothings=tuple(fischer_burmeister_eps(e) for e in BOOK)),
    _switch("FB, problem's own units", _FB, natural=True),
    _switch("FB, mu_strategy adaptive", _FB, settings=Settings(total=MOST, strategy="adaptive")),
    _switch("FB, modes held at the end", _FB, polished=True),
    _switch("relaxed", _RELAXED),
    _switch("relaxed, = eps in place of <=", "equal"),
    _switch("equal, rows to 1e-10 only", "equal", settings=Settings(total=MOST, row_tol=1e-10)),
    _switch("relaxed, Ipopt's barrier from 1e-9", _RELAXED,
            settings=Settings(total=MOST, first_barrier=1e-9, push=1e-8)),
    _switch("relaxed, problem's own units", _RELAXED, natural=True),
)  # fmt: skip
"""One thing changed at a time: which change makes the one like the other?"""
FIRST = tuple(
    Variant(f"{form} from {first:.0e}", FORMS[form], schedule(first))
    for form in (_RELAXED, "equal", _FB)
    for first in (1e-1, 1e-3, 1e-5, 1e-8)
)
"""What the first smoothing does."""
RECOMMENDED = Variant("recommended", FORMS[_RELAXED], schedule(0.1, 1e-8), Settings(), polished=True)
"""What the tasks use: relaxed to 1e-8, then the modes held."""


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
        problem = PROBLEMS[name]()
        for variant in variants:
            program = transcribe(problem, variant.form, variant.units(problem))
            answers = []
            for seed in range(starts):
                note(f"{name}: {variant.name}, start {seed + 1} of {starts}")
                answers.append(
                    follow(
                        program, problem.guess(seed), variant.smoothings, variant.settings, variant.polished
                    )
                )
            yield row_of(name, variant, answers), answers[0]


def row_of(problem: str, variant: Variant, answers: Sequence[Answer]) -> Row:
    """Return what a variant made of its starts."""
    costs = [a.outcome.cost for a in answers if a.outcome.solved]
    stages = [stage for answer in answers for stage in answer.stages]
    steps = [step for stage in stages for step in stage.steps]
    so_far = np.cumsum([stage.iterations for stage in answers[0].stages])
    trace = tuple(
        (stage.eps, int(count), stage.outcome.complementarity)
        for stage, count in zip(answers[0].stages, so_far, strict=True)
    )
    return Row(
        problem, variant.name, len(costs), len(answers),
        float(np.median([a.iterations for a in answers])),
        float(np.median([a.seconds for a in answers])),
        float(np.median([a.outcome.product for a in answers])),
        float(np.median([a.outcome.complementarity for a in answers])),
        float(np.median(costs)) if costs else float("nan"),
        float(np.median(steps)) if steps else float("nan"),
        sum(s.regularised for s in stages) / max(1, sum(s.iterations for s in stages)),
        trace,
    )  # fmt: skip
