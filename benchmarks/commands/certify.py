"""`surefoot bench certify`: certificates of executed and of spoilt motions, beside kinematic filters."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from benchmarks.printing import report, table
from surefoot.app.cli import extras, parsing
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from benchmarks.certify.detection import Detection
    from benchmarks.certify.executed import Executed


def certify(
    executed: Annotated[
        list[Path] | None, typer.Option(help="File of an executed motion of the G1; may be repeated.")
    ] = None,
    walks: Annotated[int, typer.Option(min=0, max=8, help="Walks of the G1 that are recorded.")] = 6,
    duration: Annotated[float, typer.Option(min=2.0, help="Length of a walk [s].")] = 8.0,
    seed: Annotated[int, typer.Option(help="Seed of corruptions and noise.")] = 0,
    quick: Annotated[bool, typer.Option("--quick", help="One walk of three seconds.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
) -> int:
    """Certify executed motions and find what was done to spoilt ones, beside CoM-CoP distance and root jerk.

    Exit code 1 if executed frames are called impossible too often, or a corruption is found too seldom.
    """
    from benchmarks.certify.detection import detect
    from benchmarks.certify.executed import judge
    from benchmarks.certify.recordings import files
    from benchmarks.certify.recordings import walks as recorded
    from surefoot.mechanics import load_robot

    extras.require((*extras.robot_packages("g1"), "mujoco"))
    parsing.seed(seed)
    if quick:
        walks, duration = 1, 3.0
    robot = load_robot("g1")
    motions = [*files(robot, executed or ()), *recorded(robot, walks, duration)]
    if not motions:
        raise ProblemError("give --executed files or at least one of --walks")
    lawful = judge(motions, seed)
    found = detect(motions, seed)
    record = {
        "motions": [motion.name for motion in motions],
        "executed": [asdict(one) for one in lawful],
        "spoilt": [asdict(one) for one in found],
    }
    report(record, json, lambda console: _print(console, lawful, found, len(motions)))
    return 0 if all(one.holds for one in lawful) and (quick or all(one.holds for one in found)) else 1


def _print(console: Console, lawful: list[Executed], found: list[Detection], count: int) -> None:
    rows = [
        (
            one.what, str(one.frames), f"{100.0 * one.impossible / one.frames:.2f} %",
            f"{100.0 * one.worst:.2f} %", f"{100.0 * one.possible / one.frames:.1f} %", str(one.torque),
            f"{one.speed:.0f}",
        )
        for one in lawful
    ]  # fmt: skip
    heads = ("executed", "frames", "impossible", "worst clip", "possible", "for torques", "frames/s")
    console.print(table(heads, rows, f"{count} executed motions, processor time on one core"))
    lines = [
        (
            one.name, *_areas(one.frames), *_areas(one.clips),
            _share(one.named),
            "" if one.holds else "less than expected",
        )
        for one in found
    ]  # fmt: skip
    spoilt_heads = (
        "spoilt by", "frames: certificate", "CoM-CoP", "root jerk", "clips: certificate", "CoM-CoP ",
        "root jerk ", "cause named", "",
    )  # fmt: skip
    title = "Areas under the curve at 30 Hz against the same motions as executed"
    console.print(table(spoilt_heads, lines, title))


def _share(value: float) -> str:
    return "" if value != value else f"{100.0 * value:.0f} %"


def _areas(values: tuple[float, ...]) -> list[str]:
    shown = [f"{value:.3f}" for value in values]
    return shown + [""] * (3 - len(shown))
