"""What a law found in every environment."""

from __future__ import annotations

from dataclasses import dataclass

from surefoot.base.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class LawFound:
    """What a law, or a sign, found in every environment; arrays are (N,).

    Attributes
    ----------
    name, unit
        Of the law, and of its measure.
    law
        Whether breaking it is unlawful; else it is a sign.
    share
        Of the environment's rows in which the limit is exceeded [-].
    worst, limit
        Where that is by most, or where it comes nearest; NaN for what was not judged.
    instant, contact
        When [s], and which contact.
    """

    name: str
    unit: str
    law: bool
    share: FloatArray
    worst: FloatArray
    limit: FloatArray
    instant: FloatArray
    contact: IntArray
