"""`surefoot identify`: a body, its friction and restitution, and the ground, from recorded tosses."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from surefoot.app.cli import options
from surefoot.app.cli.console import fit_table, progress_bar, say, show, table
from surefoot.app.cli.extras import draw_into
from surefoot.app.cli.output import check_out
from surefoot.base.arrays import whole_number
from surefoot.base.cores import cores
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:  # the other commands need no compiled code
    from rich.console import Console

    from surefoot.records.identification.toss_fit import TossFit
    from surefoot.records.identification.tosses import Tosses

EXPECTED = 1600.0
"""Simulations of all tosses that a fit takes, give or take: for the progress bar."""
NAMED = "auto"


def identify(
    tosses: Annotated[Path, typer.Argument(help="An .npz of tosses, a walk's log.npz or a leg's .csv log.")],
    model: Annotated[
        Path | None,
        typer.Option(help="URDF or MJCF of what was thrown, a cube if none; of the leg; or the robot."),
    ] = None,
    test: Annotated[
        Path | None, typer.Option(help="Other tosses, which the fit does not see: errors on them.")
    ] = None,
    law: Annotated[
        list[str] | None,
        typer.Option(
            help="rigid, newton, tangential, growing-friction; repeatable, the first is 'fit' in --json."
        ),
    ] = None,
    rivals: Annotated[
        str,
        typer.Option(help="Simulators tuned alike: mujoco, drake, bullet, none; auto: mujoco, with --test."),
    ] = NAMED,
    folds: Annotated[int, typer.Option(help="Parts of a cross-validation of all tosses; 0 for none.")] = 0,
    resamples: Annotated[int, typer.Option(help="Bootstrap samples behind the 95 % intervals.")] = 1000,
    seed: Annotated[int, typer.Option(help="Of the resampling and of the points tried.")] = 0,
    jobs: Annotated[
        int | None, typer.Option(min=1, help="Threads that simulate, or processes for folds; all cores.")
    ] = None,
    out: options.PictureOut = Path("runs"),
    picture: options.Picture = True,
    as_json: options.AsJson = False,
) -> int:
    """Fit a body, a contact law and the ground to tosses, a robot to a walk, or a leg to a force sensor."""
    from surefoot.app.cli.identify_robot import identify_robot, is_log

    given = {"--law": law, "--rivals": rivals != NAMED, "--resamples": resamples != 1000, "--seed": seed}
    given |= {"--folds": folds, "--jobs": jobs is not None}
    if tosses.suffix == ".csv":
        from surefoot.app.cli.identify_forces import identify_forces

        return identify_forces(tosses, model, test, out, as_json, given)
    if is_log(tosses):
        return identify_robot(tosses, model, out, as_json, {**given, "--test": test is not None})

    check_out(out if picture or folds else None)
    whole_number("--seed", seed)
    whole_number("--resamples", resamples, low=20)
    recorded, others = _read_both(tosses, test, folds)
    laws = list(dict.fromkeys(law or ["rigid"]))
    models = _models(laws, rivals, test is not None or folds > 0, 1 if folds else jobs or cores())
    settings: dict[str, Any] = {"model": model, "resamples": resamples, "seed": seed}
    if folds:
        from surefoot.app.cli.identify_folds import identify_folds

        return identify_folds(recorded, models, folds, settings, out, jobs, as_json)
    fits = _fits(recorded, models, settings | {"test": others}, not as_json)
    facts = _facts(fits, laws, recorded, others)
    facts["picture"], note = draw_into(picture, out, "identify", partial(_draw, recorded, others, fits))
    facts["notes"] += [note] if note else []
    show(facts, as_json, _print)
    return 0


def _read_both(tosses: Path, test: Path | None, folds: int) -> tuple[Tosses, Tosses | None]:
    """Return the tosses to fit and the others, of the same cube."""
    from surefoot.records.identification.tosses import read_tosses

    if folds and test is not None:
        raise ProblemError("--folds judges every toss: --test is for a fit to all of them")
    recorded = read_tosses(tosses)
    others = None if test is None else read_tosses(test)
    if others is not None and others.cube != recorded.cube:
        raise ProblemError(f"{test} holds tosses of another cube than {tosses}")
    return recorded, others


def _draw(recorded: Tosses, others: Tosses | None, fits: dict[str, TossFit], folder: Path) -> Path:
    from surefoot.app.viz.toss_plots import draw_tosses

    return draw_tosses(recorded, others, fits, folder / "tosses.png")


def _models(laws: list[str], names: str, testing: bool, threads: int) -> list[Any]:
    """Return the model of each law and of each rival; those that can, share tosses among threads."""
    from surefoot.records.identification.toss_model import ThrownModel
    from surefoot.worlds.experiments.tosses import rival

    if names == NAMED:
        wanted = ["mujoco"] if testing and find_spec("mujoco") else []
    else:
        wanted = [] if names == "none" else [name.strip() for name in names.split(",")]
    own = [ThrownModel(name, threads=threads) for name in laws]
    return [*own, *(rival(name, threads) for name in dict.fromkeys(wanted))]


def _fits(recorded: Tosses, simulators: list[Any], settings: dict[str, Any], bar: bool) -> dict[str, TossFit]:
    """Return the fits by name; all of them throw the body that the first one found."""
    from surefoot.records.identification.identify import identify as fit

    fits: dict[str, TossFit] = {}
    found = None
    for simulator in simulators:
        with progress_bar(bar, f"{simulator.name}: simulating tosses", 1.0) as moved:
            progress = _progress(EXPECTED * len(recorded), moved)
            fits[simulator.name] = fit(recorded, simulator, found=found, progress=progress, **settings)
        found = found or fits[simulator.name].found
    return fits


def _progress(expected: float, moved: Any) -> Any:
    """Return what moves the bar by how many tosses have been simulated."""
    return moved and (lambda simulated: moved(min(1.0, simulated / expected)))


def _facts(
    fits: dict[str, TossFit], laws: list[str], recorded: Tosses, others: Tosses | None
) -> dict[str, Any]:
    """Return everything that the command says."""
    first = fits[laws[0]]
    rivals = [name for name in fits if name not in laws]

    def of_law(law: str) -> dict[str, Any]:
        parts = ("train", "test") if others is not None else ("train",)
        errors = {p: _part(fits, law, rivals, p) for p in parts}
        return {"fit": _numbers(fits[law]), "impacts": _impacts(fits[law]), "test": None} | errors

    return {
        "law": laws[0],
        "tosses": len(recorded),
        "width": first.found.body.width,
        **of_law(laws[0]),
        "laws": {name: of_law(name) for name in laws[1:]},
        "noise": {"position": first.position_noise, "rotation_deg": math.degrees(first.rotation_noise)},
        "effort": {name: {"simulations": f.evaluations, "seconds": f.seconds} for name, f in fits.items()},
        "notes": list(dict.fromkeys(note for f in fits.values() for note in f.notes)),
        "picture": None,
    }


def _numbers(fit: TossFit) -> dict[str, Any]:
    """Return the fitted numbers as the JSON has them."""
    return {name: vars(e) for name, e in fit.parameters.items()}


def _impacts(fit: TossFit) -> dict[str, Any] | None:
    return None if fit.impacts is None else fit.impacts._asdict()


def _part(fits: dict[str, TossFit], name: str, rivals: list[str], part: str) -> dict[str, Any]:
    """Return the errors of one law on one part of the tosses, and those of its rivals."""
    from surefoot.records.identification.toss_errors import paired_difference

    ours, kinds = getattr(fits[name], part), ("position", "rotation", "early")
    out: dict[str, Any] = {"tosses": len(ours.position), **_errors(ours), "rivals": {}}
    for rival in rivals:
        theirs = getattr(fits[rival], part)
        gaps = {kind: vars(paired_difference(getattr(ours, kind), getattr(theirs, kind))) for kind in kinds}
        own = {"fit": _numbers(fits[rival]), "impacts": _impacts(fits[rival])}
        out["rivals"][rival] = {**_errors(theirs), **own, "ours_less_theirs": gaps}
    return out


def _errors(errors: Any) -> dict[str, Any]:
    """Return means, medians and errors toss by toss."""
    each = vars(errors)
    means = {f"{kind}_error_mean": float(values.mean()) for kind, values in each.items()}
    middles = {f"{kind}_error_median": float(np.median(values)) for kind, values in each.items()}
    return {**means, **middles, **{f"{kind}_error": values for kind, values in each.items()}}


def _print(console: Console, facts: dict[str, Any]) -> None:
    for law, fit in ((facts["law"], facts["fit"]), *((n, d["fit"]) for n, d in facts["laws"].items())):
        console.print(fit_table(fit, f"{law}, fitted to {facts['tosses']} tosses", digits=5))
    for part in ("train", "test"):
        if facts[part] is not None:
            console.print(_error_table(facts, part))
    if facts["test"] is None:
        say(console, "No --test: errors are those on the tosses it was fitted to.")
    noise = facts["noise"]
    say(
        console,
        f"noise of the recording in free flight: {1e3 * noise['position']:.3g} mm, "
        f"{noise['rotation_deg']:.2g} deg; simulated in all: "
        + ", ".join(
            f"{name} {e['simulations']:.0f} x in {e['seconds']:.0f} s" for name, e in facts["effort"].items()
        ),
        *_impact_lines(facts),
        *facts["notes"],
        f"picture: {facts['picture']}" if facts["picture"] else "",
    )


def _error_table(facts: dict[str, Any], part: str) -> Any:
    """Return the table of mean errors of one part, a row per law and rival."""
    first = facts[part]
    known = "not seen by the fit" if part == "test" else "fitted to"
    header = (
        "",
        "position [width]",
        "rotation [deg]",
        "after 34 ms",
        "less the rival's: position",
        "rotation",
    )
    laws = ((facts["law"], first), *((name, law[part]) for name, law in facts["laws"].items()))
    rows = [(name, *_means(errors), "", "") for name, errors in laws]
    for name, errors in first["rivals"].items():
        position, rotation = (_gap(errors["ours_less_theirs"][kind]) for kind in ("position", "rotation"))
        rows.append((name, *_means(errors), position, rotation))
    return table(header, rows, f"{first['tosses']} tosses {known}", left=6)


def _impact_lines(facts: dict[str, Any]) -> Iterator[str]:
    """Yield what the first impacts say of every law and rival."""
    from surefoot.records.identification.toss_errors import paired_difference

    judged = facts["test"] or facts["train"]
    others = {**facts["laws"], **judged["rivals"]}
    for name, found in ((facts["law"], facts["impacts"]), *((n, o["impacts"]) for n, o in others.items())):
        if found is not None:
            ours, logs = facts["impacts"]["log_likelihood"], found["log_likelihood"]
            gap = f", {facts['law']} less this {_gap(vars(paired_difference(ours, logs)))}"
            yield (
                f"{name}: after {found['impacts']} first impacts median errors of "
                f"{found['velocity_error_median']:.4f} m/s and {found['spin_error_median']:.3f} rad/s (noise "
                f"alone {found['velocity_floor']:.4f} and {found['spin_floor']:.3f}), log-likelihood "
                f"{found['log_likelihood_mean']:.3f} an impact{gap if logs is not ours else ''}"
            )


def _means(errors: dict[str, Any]) -> tuple[str, str, str]:
    early = f"{errors['early_error_mean']:.4f}"
    return f"{errors['position_error_mean']:.4f}", f"{errors['rotation_error_mean']:.2f}", early


def _gap(gap: dict[str, float]) -> str:
    return f"{gap['value']:+.2g} ({gap['low']:+.2g} to {gap['high']:+.2g})"
