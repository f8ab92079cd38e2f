"""The stance that a command is asked about: from a stance file, or from a robot on a terrain."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import real_number
from surefoot.cli.parsing import MU_MAX
from surefoot.errors import ProblemError
from surefoot.stance import Stance, StanceQuestion, read_stance


@dataclass(frozen=True)
class Asked:
    """What a command is about; robot and q are None for a stance file."""

    question: StanceQuestion
    robot: Any = None
    q: Any = None


def asked(
    file: Path | None,
    robot: str | None,
    urdf: Path | None,
    feet: str | None,
    slope: float,
    mu: float | None,
    lift: str | None,
) -> Asked:
    """Return the stance of a file, or of a robot placed on a slope.

    Raises
    ------
    ProblemError
        If neither or both are given.
    """
    from surefoot.cli import parsing

    if mu is not None:
        parsing.friction("--mu", mu)
    real_number("--slope", slope, low=-80.0, high=80.0)
    named = robot is not None or urdf is not None
    if (file is None) == (not named):
        raise ProblemError("give a stance file, or --robot NAME, or --urdf FILE; exactly one")
    if file is not None:
        if not str(file).strip("."):
            raise ProblemError(f"no stance file at {str(file)!r}")
        if feet is not None or slope != 0.0:
            raise ProblemError("--feet and --slope go with --robot or --urdf, not with a stance file")
        question = read_stance(file)
        _check_sizes(question, file)
        stance = question.stance if mu is None else question.stance.with_friction(mu)
        return Asked(_without(question, stance, lift))
    return _robot_asked(robot, urdf, feet, slope, 0.6 if mu is None else mu, lift)


def _check_sizes(question: StanceQuestion, file: Path) -> None:
    """Refuse sizes that no robot has, where double precision would no longer tell right from wrong."""
    real_number(f"{file}: mass", question.mass, low=0.0, high=1e9)
    sizes = {
        "com": question.com,
        "external_wrench": question.external_wrench,
        "positions": question.stance.positions,
    }
    for name, values in sizes.items():
        real_number(f"{file}: largest entry of {name}", np.abs(values).max(initial=0.0), high=1e9)
    real_number(f"{file}: mu", np.max(question.stance.mu, initial=0.0), low=0.0, high=MU_MAX)


def _without(question: StanceQuestion, stance: Stance, lift: str | None) -> StanceQuestion:
    from surefoot.cli import parsing

    names = parsing.names("--lift", lift) or []
    return StanceQuestion(
        question.name, stance.without(*names), question.mass, question.com, question.external_wrench
    )


def _robot_asked(
    name: str | None, urdf: Path | None, feet: str | None, slope: float, mu: float, lift: str | None
) -> Asked:
    from surefoot.cli import extras, parsing
    from surefoot.cli.robots import load
    from surefoot.robot import place
    from surefoot.terrain import SlopeTerrain

    extras.require(extras.robot_packages(name if urdf is None else str(urdf.absolute())))
    terrain = SlopeTerrain(slope)
    robot = load(name, urdf, feet)
    q = place(robot, terrain)
    stance = robot.stance(q, mu=mu, terrain=terrain)
    lifted = [robot.foot(n).name for n in parsing.names("--lift", lift) or []]
    title = f"{robot.name} on a slope of {slope:g} deg" if slope else f"{robot.name} on flat ground"
    if lifted:
        title += f", {', '.join(lifted)} lifted"
    stance = stance.without(*lifted)
    return Asked(StanceQuestion(title, stance, robot.mass, robot.com(q), np.zeros(6)), robot, q)
