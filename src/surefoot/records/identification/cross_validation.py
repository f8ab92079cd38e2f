"""Cross-validation of laws and simulators: every toss is judged by a fit that has not seen it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.records.identification.identify import LEAST, identify
from surefoot.records.identification.toss_errors import Difference, TossErrors, paired_difference
from surefoot.records.identification.toss_fit import BodyFit, TossFit
from surefoot.records.identification.toss_model import TossModel
from surefoot.records.identification.tosses import Tosses

KINDS = ("position", "rotation", "early")
"""Errors that are compared, see `TossErrors`."""


class FoldErrors(NamedTuple):
    """Errors of a law on tosses that its fits had not seen, and its numbers fold by fold.

    Attributes
    ----------
    errors
        (B,) of each toss, see `TossErrors`, in the order of the recording.
    values
        (folds,) of every number that was fitted, by name.
    """

    errors: TossErrors
    values: dict[str, FloatArray]

    def less(self, other: FoldErrors, kind: str) -> Difference:
        """Return the mean of paired differences to another law on the same tosses, with its 95 % interval."""
        return paired_difference(getattr(self.errors, kind), getattr(other.errors, kind))


class JudgedFold(NamedTuple):
    """What laws make of the tosses of one fold that their fits had not seen.

    Attributes
    ----------
    errors
        (k,) of each of its tosses, law by law.
    values
        Numbers that were fitted, law by law and by name.
    """

    errors: dict[str, TossErrors]
    values: dict[str, dict[str, float]]


def cross_validate(
    tosses: Tosses,
    models: Sequence[TossModel],
    folds: int,
    fit: Callable[..., TossFit] = identify,
    **settings: Any,
) -> dict[str, FoldErrors]:
    """Fit laws to all folds but one, judge them on that one, and do so for each.

    Tosses are dealt out in turn, so that what changes during a recording is in every fold. In a fold all laws
    begin with the body that the first of them found, and all have the same tosses.

    Parameters
    ----------
    tosses
        What was recorded.
    models
        Laws and simulators; the first finds the body.
    folds
        How many parts.
    fit
        See `identify`.
    settings
        More arguments of it.

    Raises
    ------
    ProblemError
        If there are fewer than two folds, or too few tosses to fit.
    """
    check_folds(tosses, folds)
    judged = [judge_fold(tosses, models, folds, fold, fit, **settings) for fold in range(folds)]
    return gather_folds(tosses, judged)


def check_folds(tosses: Tosses, folds: int) -> None:
    """Raise a `ProblemError` for fewer than two folds, or such that leave too few tosses to fit."""
    whole_number("folds", folds, low=2)
    if len(tosses) - -(-len(tosses) // folds) < LEAST:
        raise ProblemError(f"{folds} folds of {len(tosses)} tosses leave fewer than {LEAST} to fit")


def judge_fold(
    tosses: Tosses,
    models: Sequence[TossModel],
    folds: int,
    fold: int,
    fit: Callable[..., TossFit] = identify,
    **settings: Any,
) -> JudgedFold:
    """Fit laws to all tosses but those of a fold, and judge them on these; parameters of `cross_validate`."""
    number = np.arange(len(tosses)) % folds
    rest, own = (tosses.subset(np.flatnonzero(mask)) for mask in (number != fold, number == fold))
    found: BodyFit | None = None
    errors: dict[str, TossErrors] = {}
    values: dict[str, dict[str, float]] = {}
    for model in models:
        one = fit(rest, model, test=own, found=found, **settings)
        found = one.found
        if one.test is not None:
            errors[model.name] = one.test
        values[model.name] = {name: estimate.value for name, estimate in one.parameters.items()}
    return JudgedFold(errors, values)


def gather_folds(tosses: Tosses, judged: Sequence[JudgedFold]) -> dict[str, FoldErrors]:
    """Return the errors of each law on all tosses, from all folds in their order."""
    out = {}
    for law, names in judged[0].values.items():
        errors = {kind: np.empty(len(tosses)) for kind in KINDS}
        for fold, one in enumerate(judged):
            for kind in KINDS:
                errors[kind][fold :: len(judged)] = getattr(one.errors[law], kind)
        values = {name: np.array([one.values[law][name] for one in judged]) for name in names}
        out[law] = FoldErrors(TossErrors(**errors), values)
    return out
