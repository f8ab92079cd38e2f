"""`surefoot identify --folds N`: laws and simulators judged on every toss by fits that have not seen it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from surefoot.app.cli.console import progress_bar, say, show, table

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.records.identification.tosses import Tosses


def identify_folds(
    tosses: Tosses, models: list[Any], folds: int, settings: dict[str, Any], expected: float, as_json: bool
) -> int:
    """Cross-validate, and print errors with paired differences to the first law."""
    from surefoot.records.identification.cross_validation import KINDS, cross_validate

    whole, done = expected * len(tosses) * folds * len(models), 0.0
    with progress_bar(not as_json, f"{folds} folds of {len(models)} laws", 1.0) as moved:

        def progress(simulated: float) -> None:
            nonlocal done
            done = max(done, simulated)
            if moved is not None:
                moved(min(1.0, done / whole))

        found = cross_validate(tosses, models, folds, progress=progress, **settings)
    first = next(iter(found.values()))
    facts: dict[str, Any] = {"tosses": len(tosses), "folds": folds, "laws": {}}
    for name, law in found.items():
        means = {f"{kind}_error_mean": float(getattr(law.errors, kind).mean()) for kind in KINDS}
        gaps = {} if law is first else {kind: vars(first.less(law, kind)) for kind in KINDS}
        numbers = {key: [float(v.min()), float(v.max())] for key, v in law.values.items()}
        facts["laws"][name] = {**means, "first_less_this": gaps, "values_low_high": numbers}
    show(facts, as_json, _print)
    return 0


def _print(console: Console, facts: dict[str, Any]) -> None:
    first = next(iter(facts["laws"]))
    rows = []
    for name, law in facts["laws"].items():
        means = (f"{law[f'{kind}_error_mean']:.4g}" for kind in ("position", "rotation", "early"))
        gaps = (law["first_less_this"].get(kind) for kind in ("position", "rotation"))
        rows.append((name, *means, *(_gap(gap) for gap in gaps)))
    header = (
        "", "position [width]", "rotation [deg]", "after 34 ms", f"{first} less this: position", "rotation",
    )  # fmt: skip
    console.print(
        table(header, rows, f"{facts['tosses']} tosses, each judged by fits that have not seen it", left=6)
    )
    low, high = facts["laws"][first]["values_low_high"]["mu"]
    say(console, f"{first}: mu from {low:.4f} to {high:.4f} over {facts['folds']} folds")


def _gap(gap: dict[str, float] | None) -> str:
    return "" if gap is None else f"{gap['value']:+.2g} ({gap['low']:+.2g} to {gap['high']:+.2g})"
