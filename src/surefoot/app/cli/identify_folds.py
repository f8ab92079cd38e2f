"""`surefoot identify --folds N`: laws and simulators judged on every toss by fits that have not seen it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from surefoot.app.cli.console import progress_bar, say, show, table
from surefoot.app.cli.signals import ends_softly, say_interrupted

if TYPE_CHECKING:
    from rich.console import Console

    from surefoot.records.identification.cross_validation import JudgedLaw
    from surefoot.records.identification.tosses import Tosses


def identify_folds(
    tosses: Tosses, models: list[Any], folds: int, settings: dict[str, Any], out: Path, jobs: int | None,
    as_json: bool,
) -> int:  # fmt: skip
    """Cross-validate, and print errors with paired differences to the first law."""
    from surefoot.app.cli.kept_folds import count_kept, folds_folder, judge_folds, read_folds
    from surefoot.records.identification.cross_validation import check_folds

    check_folds(tosses, folds)
    folder = folds_folder(out, tosses, models[0], settings)
    before, all_laws = count_kept(models, folds, folder), folds * len(models)
    label = f"{folds} folds of {len(models)} laws"
    code = 0
    judged: list[dict[str, JudgedLaw] | None] = []
    with ends_softly() as stop, progress_bar(not as_json, label, float(all_laws)) as moved:
        try:
            judged += judge_folds(tosses, models, folds, folder, jobs, moved, **settings)
        except KeyboardInterrupt:
            code = say_interrupted(stop, folder)
            judged = read_folds(models, folds, folder)
    if any(one is not None for one in judged):
        facts = _facts(tosses, judged, folder)
        if before:
            facts["notes"] = [f"{before} of {all_laws} laws of folds as {folder} has them from before"]
        show(facts, as_json, _print)
    return code


def _facts(tosses: Tosses, judged: list[dict[str, JudgedLaw] | None], folder: Path) -> dict[str, Any]:
    """Return errors, and paired differences to the first law, of the folds that are judged."""
    from surefoot.records.identification.cross_validation import KINDS, gather_folds

    found = gather_folds(tosses, judged)
    first = next(iter(found.values()))
    facts: dict[str, Any] = {
        "tosses": len(first.errors.position), "folds": len(judged),
        "folds_done": sum(one is not None for one in judged), "folder": str(folder), "laws": {}, "notes": [],
    }  # fmt: skip
    for name, law in found.items():
        means = {f"{kind}_error_mean": float(getattr(law.errors, kind).mean()) for kind in KINDS}
        gaps = {} if law is first else {kind: vars(first.less(law, kind)) for kind in KINDS}
        numbers = {key: [float(v.min()), float(v.max())] for key, v in law.values.items()}
        facts["laws"][name] = {**means, "first_less_this": gaps, "values_low_high": numbers}
    return facts


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
    done, folds = facts["folds_done"], facts["folds"]
    share = "" if done == folds else f" of {done} folds"
    title = f"{facts['tosses']} tosses{share}, each judged by fits that have not seen it"
    console.print(table(header, rows, title, left=6))
    low, high = facts["laws"][first]["values_low_high"]["mu"]
    say(console, f"{first}: mu from {low:.4f} to {high:.4f} over {done} of {folds} folds")
    say(console, f"folds: {facts['folder']}")
    for note in facts["notes"]:
        say(console, note)


def _gap(gap: dict[str, float] | None) -> str:
    return "" if gap is None else f"{gap['value']:+.2g} ({gap['low']:+.2g} to {gap['high']:+.2g})"
