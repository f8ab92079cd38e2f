"""`surefoot certify`: whether motions are possible, frame by frame, with the cause and the cure."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from surefoot.app.cli import extras, options
from surefoot.app.cli.console import plain_console, progress_bar, say, say_verdict, table
from surefoot.app.cli.output import to_json
from surefoot.app.cli.parsing import numbers
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.app.cli.certified_files import Outcome

SEGMENTS = 12
"""Impossible stretches of one motion that are printed; the JSON has all."""
HEADER = ("motion", "verdict", "score", "impossible", "worst [m g]", "cause", "cure")


def certify(
    files: Annotated[
        list[Path], typer.Argument(help="Motions: CSV, pickles, .npz, logs; see docs/motions.md.")
    ],
    robot: Annotated[str, typer.Option(help="A known robot, a .urdf or an .xml (MJCF) file.")] = "g1",
    fps: Annotated[float | None, typer.Option(help="Frames per second, where a file does not say.")] = None,
    order: Annotated[
        str | None, typer.Option(help="Order of the joints: depth, breadth, or names, comma-separated.")
    ] = None,
    quaternion: Annotated[str | None, typer.Option(help="xyzw or wxyz, where a file does not say.")] = None,
    mu: Annotated[float, typer.Option(help="Friction of contacts that stick.")] = 0.8,
    sliding_mu: Annotated[
        str, typer.Option(help="LEAST,LARGEST friction of contacts that slide.")
    ] = "0.3,0.8",
    window: Annotated[
        float | None, typer.Option(help="Time over which forces are averaged [s]; chosen by the noise.")
    ] = None,
    terrain: Annotated[
        str | None, typer.Option(help="The ground, as for walks: slope:DEG, stairs:HEIGHT,DEPTH, ...; flat.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of a JSON and a CSV of each motion; what is there is not done anew."),
    ] = None,
    repair: Annotated[
        Path | None,
        typer.Option(
            help="Folder of the motions mended, an .npz each: the nearest ones that forces exist for."
        ),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="New file of the picture or page (.html) of a single motion.")
    ] = None,
    jobs: options.Jobs = None,
    as_json: options.AsJson = False,
) -> int:
    """Tell whether the ground and the motors could give the forces of motions, which frames not, and why.

    Exit code 0 if all are possible as they are, 1 if one is not or cannot be told, 2 for wrong input; the
    other files are certified all the same.
    """
    from surefoot.app.cli.certified_files import Question, certify_files

    extras.require(extras.robot_packages(robot))
    if picture is not None and len(files) != 1:
        raise ProblemError("--picture is of a single motion")
    low, high = numbers("--sliding-mu", sliding_mu, "LEAST,LARGEST", "0.3,0.8")
    names = order.split(",") if order is not None and "," in order else order
    drawn = None if picture is None else str(picture)
    mends = None if repair is None else str(repair)
    question = Question(robot, fps, names, quaternion, mu, (low, high), window, terrain, drawn, mends)
    with progress_bar(not as_json, "certify", float(len(files))) as show:
        found = certify_files(files, question, out, jobs, show)
    if as_json:
        print(to_json([one.facts if one.error is None else _describe_failure(one) for one in found]))
    else:
        _print(plain_console(), found)
        for one in found:
            _print_mended(plain_console(), one.facts.get("mended"))
    wrong = [one.error for one in found if one.error is not None]
    if wrong:
        raise ProblemError("; ".join(wrong))
    return 0 if all(one.facts["verdict"] == "possible" for one in found) else 1


def _print_mended(console: Console, mended: dict[str, Any] | None) -> None:
    """Print what became of a motion, and where it is."""
    if mended is not None:
        say(console, f"mended: {mended['sentence']} {mended['file']}")


def _describe_failure(one: Outcome) -> dict[str, str | None]:
    """Return what the JSON says of a file that is wrong."""
    return {"file": one.file, "error": one.error}


def _print(console: Console, found: list[Outcome]) -> None:
    """Print one motion in words, several as a table from the best to the worst."""
    judged = [one for one in found if one.error is None]
    if len(judged) == 1:
        _print_one(console, judged[0].facts)
    elif judged:
        ranked = sorted(judged, key=lambda one: _score(one.facts))
        common = os.path.commonpath([Path(one.file).absolute().parent for one in ranked])
        rows = [_row(one, os.path.relpath(one.file, common)) for one in ranked]
        console.print(table(HEADER, rows, left=HEADER[:1] + HEADER[5:]))
        say(console, _frames(judged))
        count = sum(one.facts["verdict"] == "possible" for one in judged)
        kept = sum(one.kept for one in judged)
        line = f"{count} of {len(judged)} motions are possible"
        say_verdict(console, line + (f"; {kept} were certified before" if kept else ""), count == len(judged))


def _frames(judged: list[Outcome]) -> str:
    """Return how many frames of all motions are impossible, by cause."""
    frames, causes = sum(one.facts["judged"] for one in judged), Counter[str]()
    for one in judged:
        causes.update(one.facts["causes"])
    if not frames:
        return ""
    shares = ", ".join(f"{name} {100.0 * count / frames:.1f} %" for name, count in causes.most_common())
    line = f"{100.0 * sum(causes.values()) / frames:.1f} % of {frames} frames are impossible"
    return f"{line}: {shares}" if causes else line


def _score(facts: dict[str, Any]) -> float:
    score = facts["score"]
    return 2.0 if score is None or score != score else float(score)


def _print_one(console: Console, facts: dict[str, Any]) -> None:
    for segment in facts["segments"][:SEGMENTS]:
        where = f" ({segment['where']})" if segment["where"] else ""
        say(
            console,
            f"{segment['start']:7.2f} to {segment['end']:.2f} s  {segment['cause']}{where}, "
            f"{segment['worst']:.2f} m g: {segment['cure']}",
        )
    hidden = len(facts["segments"]) - SEGMENTS
    say(console, f"and {hidden} stretches more" if hidden > 0 else "", *facts["notes"])
    say_verdict(console, facts["sentence"], facts["verdict"] == "possible")


def _row(one: Outcome, file: str) -> list[str]:
    """Return the row of a motion, its file as seen from the folder that all have in common."""
    facts = one.facts
    worst = max(facts["segments"], key=lambda s: s["worst"] * (s["end"] - s["start"] + 1e-3), default=None)
    share, score = facts["impossible_share"], facts["score"]
    return [
        file if Path(file).stem == facts["name"] else f"{file}: {facts['name']}",
        str(facts["verdict"]),
        "" if score is None else f"{score:.3f}",
        "" if share is None else f"{100.0 * share:.1f} %",
        "" if worst is None else f"{worst['worst']:.2f}",
        "" if worst is None else f"{worst['cause']} {worst['where']}".strip(),
        "" if worst is None else str(worst["cure"]),
    ]
