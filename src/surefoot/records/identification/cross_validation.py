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
    whole_number("folds", folds, low=2)
    if len(tosses) - -(-len(tosses) // folds) < LEAST:
        raise ProblemError(f"{folds} folds of {len(tosses)} tosses leave fewer than {LEAST} to fit")
    number = np.arange(len(tosses)) % folds
    errors = {m.name: {kind: np.empty(len(tosses)) for kind in KINDS} for m in models}
    values: dict[str, dict[str, list[float]]] = {m.name: {} for m in models}
    for fold in range(folds):
        found: BodyFit | None = None
        kept = np.flatnonzero(number == fold)
        for model in models:
            one = fit(
                tosses.subset(np.flatnonzero(number != fold)), model, test=tosses.subset(kept), found=found,
                **settings,
            )  # fmt: skip
            found = one.found
            for kind in KINDS:
                errors[model.name][kind][kept] = getattr(one.test, kind)
            for name, estimate in one.parameters.items():
                values[model.name].setdefault(name, []).append(estimate.value)
    return {
        m.name: FoldErrors(
            TossErrors(**errors[m.name]), {name: np.array(v) for name, v in values[m.name].items()}
        )
        for m in models
    }
