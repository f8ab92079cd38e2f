"""Cross-validation of laws and simulators: every toss is judged by a fit that has not seen it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol, cast

import numpy as np

from surefoot.base.arrays import FloatArray, whole_number
from surefoot.base.errors import ProblemError
from surefoot.records.identification.identify import LEAST, begin_fit, identify
from surefoot.records.identification.toss_errors import Difference, TossErrors, paired_difference
from surefoot.records.identification.toss_fit import BodyFit, BodyNumbers, TossFit
from surefoot.records.identification.toss_model import TossModel
from surefoot.records.identification.tosses import Tosses

KINDS = ("position", "rotation", "early")
"""Errors that are compared, see `TossErrors`."""


class FoldErrors(NamedTuple):
    """Errors of a law on tosses that its fits had not seen, and its numbers fold by fold.

    Attributes
    ----------
    errors
        (B,) of each toss that was judged, see `TossErrors`, in the order of the recording.
    values
        (folds,) of every number that was fitted, by name.
    """

    errors: TossErrors
    values: dict[str, FloatArray]

    def less(self, other: FoldErrors, kind: str) -> Difference:
        """Return the mean of paired differences to another law on the same tosses, with its 95 % interval."""
        return paired_difference(getattr(self.errors, kind), getattr(other.errors, kind))


class JudgedLaw(NamedTuple):
    """What a law makes of the tosses of one fold that its fit had not seen.

    Attributes
    ----------
    errors
        (k,) of each of its tosses.
    values
        Numbers that were fitted, by name.
    numbers
        The body as the law found it.
    """

    errors: TossErrors
    values: dict[str, float]
    numbers: BodyNumbers


class KeptLaws(Protocol):
    """Where the laws of a fold are kept as soon as they are judged."""

    def read(self, model: TossModel) -> JudgedLaw | None:
        """Return what is kept of a law; None without it."""

    def write(self, model: TossModel, judged: JudgedLaw) -> None:
        """Keep a law."""


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
    kept: KeptLaws | None = None,
    **settings: Any,
) -> dict[str, JudgedLaw]:
    """Fit laws to all tosses but those of a fold, and judge them on these.

    Parameters
    ----------
    tosses, models, folds, fit, settings
        See `cross_validate`.
    fold
        Its number, from 0.
    kept
        Where laws are kept: one that is there is not fitted.

    Returns
    -------
    dict
        What was judged, law by law.
    """
    number = np.arange(len(tosses)) % folds
    rest, own = (tosses.subset(np.flatnonzero(mask)) for mask in (number != fold, number == fold))
    found: BodyFit | None = None
    out: dict[str, JudgedLaw] = {}
    for model in models:
        judged = kept.read(model) if kept else None
        if judged is None:
            if found is None and out:
                found = begin_fit(rest, models[0], **settings).at(out[models[0].name].numbers)
            one = fit(rest, model, test=own, found=found, **settings)
            values = {name: estimate.value for name, estimate in one.parameters.items()}
            judged = JudgedLaw(cast(TossErrors, one.test), values, one.found.numbers)
            if kept:
                kept.write(model, judged)
            found = found or one.found
        out[model.name] = judged
    return out


def gather_folds(tosses: Tosses, judged: Sequence[dict[str, JudgedLaw] | None]) -> dict[str, FoldErrors]:
    """Return the errors of each law on the tosses of all folds, given in their order.

    A fold that is not judged is None: its tosses are left out. One at least is judged.
    """
    done = [one for one in judged if one is not None]
    known = np.array([one is not None for one in judged])[np.arange(len(tosses)) % len(judged)]
    out = {}
    for law, first in done[0].items():
        errors = {kind: np.empty(len(tosses)) for kind in KINDS}
        for fold, one in enumerate(judged):
            if one is None:
                continue
            for kind in KINDS:
                errors[kind][fold :: len(judged)] = getattr(one[law].errors, kind)
        values = {name: np.array([one[law].values[name] for one in done]) for name in first.values}
        out[law] = FoldErrors(TossErrors(**{kind: e[known] for kind, e in errors.items()}), values)
    return out
