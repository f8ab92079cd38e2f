"""Does a success survive where contacts are others? One controller, many worlds and seeds, and intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from statistics import median_low
from typing import Any, Literal, TypeAlias

from surefoot.base.arrays import real_number, whole_number
from surefoot.base.drawn import Drawn
from surefoot.base.errors import ProblemError
from surefoot.mechanics import Robot
from surefoot.worlds.transfer.model_trials import ModelTrials
from surefoot.worlds.transfer.robot_trials import RobotTrials
from surefoot.worlds.transfer.shares import chance_of, difference_interval, share_interval
from surefoot.worlds.transfer.trial import Departure, TrialRun, departure
from surefoot.worlds.transfer.variants import STANDARD, Variant

CHANCE = 0.05
"""Chance with which a report calls a world lost or gained in which nothing is: shared by all its worlds."""
TransferVerdict: TypeAlias = Literal["reference", "lost", "gained", "not told apart", "nothing to lose"]
"""What the interval of the difference of success says of a world."""


@dataclass(frozen=True)
class WorldTransfer:
    """What became of the success in one world.

    Attributes
    ----------
    world
        As it was asked for.
    successes, runs
        How many seeds succeeded, of how many.
    share
        95 % interval of the share of success.
    change
        95 % interval of that share less the first world's.
    verdict
        "lost" or "gained" where the change's interval is on one side of zero and chance alone would make such
        a change in `CHANCE` of all reports; "nothing to lose" where the first world has no success either,
        else "not told apart": of few seeds that is no proof of survival.
    apart_at
        First instant at which a run is 1e-2 m or rad away from the first world's of the same seed: the middle
        one of the seeds [s]; NaN where no run ever is.
    contact
        The contact that did it in that seed: whose impulse differed most until then.
    unsolved
        Steps of exact worlds that MuJoCo solved softly, all seeds together.
    """

    world: str
    successes: int
    runs: int
    share: tuple[float, float]
    change: tuple[float, float]
    verdict: TransferVerdict
    apart_at: float
    contact: str
    unsolved: int


_LONGEST = 190
"""Characters that a `repr` has at most."""


@dataclass(frozen=True, repr=False)
class TransferReport(Drawn):
    """Whether a success survives in other worlds; `table()` has the numbers.

    Attributes
    ----------
    worlds
        One row for each, the first the reference.
    """

    worlds: tuple[WorldTransfer, ...]

    def __repr__(self) -> str:
        return f"TransferReport({len(self.worlds)} worlds, lost={[*self.lost]})"[:_LONGEST]

    def __str__(self) -> str:
        first = self.worlds[0]
        others = len(self.worlds) - 1
        lost = ", ".join(self.lost[:4]) + (f" and {len(self.lost) - 4} more" if len(self.lost) > 4 else "")
        said = f"lost in {len(self.lost)} of {others}: {lost}" if self.lost else f"lost in none of {others}"
        runs = f"{first.successes} of {first.runs} runs succeed in {first.world}"
        return f"{runs}; beyond chance that is {said}. The numbers: .table()."

    @property
    def lost(self) -> tuple[str, ...]:
        """Worlds in which the success is lost beyond chance."""
        return tuple(row.world for row in self.worlds if row.verdict == "lost")

    def as_dict(self) -> dict[str, Any]:
        """Return everything, for JSON."""
        return {"lost": list(self.lost), "worlds": [asdict(row) for row in self.worlds]}

    def table(self) -> list[str]:
        """Return the lines of a Markdown table."""
        lines = ["| world | succeeded | of all (95 %) | change (95 %) | | apart after | by |"]
        lines.append("| --- | --- | --- | --- | --- | --- | --- |")
        for row in self.worlds:
            low, high = (f"{100.0 * x:.0f}" for x in row.share)
            less, more = (f"{100.0 * x:+.0f}" for x in row.change)
            first = row.verdict == "reference"
            never = "" if first else "never"
            after = never if math.isnan(row.apart_at) else f"{row.apart_at:.3f} s"
            said = row.verdict + (f", {row.unsolved} steps soft" if row.unsolved else "")
            change = "" if first else f"{less} to {more} %"
            lines.append(
                f"| {row.world} | {row.successes} of {row.runs} | {low} to {high} % | {change} | {said} "
                f"| {after} | {row.contact} |"
            )
        return lines


def transfer(
    model: Any,
    controller_or_actions: Any,
    worlds: Sequence[str] = STANDARD,
    seeds: int | Iterable[int] = 10,
    *,
    duration: float | None = None,
    start: Any = None,
    success: Callable[..., Any] | None = None,
) -> TransferReport:
    """Tell whether a success survives Coulomb's law, stiffer ground, half the step, and other friction.

    Every seed is run in every world, from the same state: a seed is a small velocity at the start. Shares of
    success have 95 % intervals (Wilson's, and Newcombe's of their difference); a loss is called one only
    where Fisher's exact test says so, too, at a level that the worlds share.

    Parameters
    ----------
    model
        An MjModel, or a robot of `load_robot`.
    controller_or_actions
        Of an MjModel: a function of model and data that sets ``data.ctrl`` before every step, or (T, nu)
        actions. Of a robot: any controller of `run`, as a `Policy`. What has a ``reset()`` is reset before
        each run.
    worlds
        The first is the reference. Texts of an engine and changes: ``mujoco``, ``mujoco-exact``, of a robot
        any world; then ``:stiff``, ``:half-step`` and ``:mu-20%``, or another share.
    seeds
        How many, or which.
    duration
        Of a run [s]; None for as long as there are actions, or 4 s of a robot.
    start
        Configuration at the start; None for the model's first keyframe, or a stand.
    success
        Of an MjModel: a function of model and data at the end. Of a robot: a function of the log. None for
        one that has not fallen.

    Raises
    ------
    ProblemError
        For what is no model, worlds that are not known, or no seeds.

    Examples
    --------
    >>> import mujoco, numpy as np
    >>> body = '<body pos="0 0 .11" euler="0 20 0"><freejoint/><geom type="box" size=".1 .1 .1"/></body>'
    >>> slope = '<geom type="plane" size="9 9 1" euler="0 20 0"/>'
    >>> text = f'<mujoco><worldbody>{slope}{body}</worldbody></mujoco>'
    >>> box = mujoco.MjModel.from_xml_string(text)
    >>> stays = lambda model, data: abs(data.qvel[0]) < 1e-6
    >>> report = transfer(box, np.zeros((300, 0)), ("mujoco", "mujoco-exact"), 8, success=stays)
    >>> [(row.world, row.successes, row.verdict) for row in report.worlds]
    [('mujoco', 0, 'reference'), ('mujoco-exact', 8, 'gained')]
    """
    numbers = list(range(whole_number("seeds", seeds, low=1))) if isinstance(seeds, int) else list(seeds)
    if not numbers or isinstance(worlds, str) or not worlds:
        raise ProblemError("transfer takes at least one seed, and a sequence of at least one world")
    if duration is not None:
        real_number("duration", duration, low=1e-6, high=1e5)
    trials: ModelTrials | RobotTrials
    if isinstance(model, Robot):
        trials = RobotTrials(model, controller_or_actions, duration, start, success)
    elif hasattr(model, "opt") and hasattr(model, "nq"):
        trials = ModelTrials(model, controller_or_actions, duration, start, success)
    else:
        raise ProblemError(f"transfer takes an MjModel or a robot, got {type(model).__name__}")
    variants = [Variant.read(text, trials.engines) for text in worlds]
    reference = [trials.run(variants[0], seed) for seed in numbers]
    rows, level = [_row(variants[0], reference, reference, 0.0)], CHANCE / max(len(variants) - 1, 1)
    for variant in variants[1:]:
        rows.append(_row(variant, [trials.run(variant, seed) for seed in numbers], reference, level))
    return TransferReport(tuple(rows))


def _row(variant: Variant, made: list[TrialRun], reference: list[TrialRun], level: float) -> WorldTransfer:
    """Return what a world's runs come to, beside the first world's."""
    counts = [(sum(one.succeeded for one in runs), len(runs)) for runs in (made, reference)]
    change, told = difference_interval(*counts), chance_of(*counts) < level
    leaves = [departure(one, two) for one, two in zip(made, reference, strict=True)]
    seen = [leave for leave in leaves if not math.isnan(leave.time)]
    middle = median_low(seen) if seen else Departure(math.nan, "")
    return WorldTransfer(
        variant.name, *counts[0], share_interval(*counts[0]), change,
        "reference" if made is reference else _verdict(counts[1][0], counts[0][0], change, told),
        middle.time, middle.contact, sum(one.unsolved for one in made),
    )  # fmt: skip


def _verdict(reference: int, successes: int, change: tuple[float, float], told: bool) -> TransferVerdict:
    """Return the verdict on a world, of its successes and those of the reference."""
    if told and change[1] < 0.0:
        return "lost"
    if told and change[0] > 0.0:
        return "gained"
    return "not told apart" if reference or successes else "nothing to lose"
