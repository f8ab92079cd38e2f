"""The force comes late or early."""

from __future__ import annotations

from surefoot.audit.episode import Episode
from surefoot.audit.symptoms.fits import best_shift
from surefoot.audit.symptoms.symptom import Evidence, Symptom


def _judge(e: Episode) -> Evidence | None:
    whole = e.whole_true(e.column)
    if whole is None or not e.has("motion"):
        return None
    best, shift = best_shift(whole, e.rows.forces[:, e.column], e.rows.window(0.08), e.rows.core)
    if best < 0.8 or abs(shift) < 3:
        return None
    late = "late" if shift > 0 else "early"
    return Evidence(
        best - 0.004,
        f"{1e3 * abs(shift) * e.rows.setting.dt:.0f} ms {late} explains {100 * best:.0f} % of the mismatch",
    )


SYMPTOM = Symptom(
    "delayed",
    cause="two clocks, or a filter before the log",
    confirm="knock on the foot and compare the stamps with the joints'",
    cure="stamp at the source; shift or filter all channels alike",
    judge=_judge,
)
