"""The stance that a command is asked about: from a stance file, or from a robot on a terrain."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

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
    named = robot is not None or urdf is not None
    if (file is None) == (not named):
        raise ProblemError("give a stance file, or --robot NAME, or --urdf FILE; exactly one")
    if file is not None:
        if feet is not None or slope != 0.0:
            raise ProblemError("--feet and --slope go with --robot or --urdf, not with a stance file")
        question = read_stance(file)
        stance = question.stance if mu is None else question.stance.with_friction(mu)
        return Asked(_without(question, stance, lift))
    return _robot_asked(robot, urdf, feet, slope, 0.6 if mu is None else mu, lift)


def _without(question: StanceQuestion, stance: Stance, lift: str | None) -> StanceQuestion:
    names = [n.strip() for n in (lift or "").split(",") if n.strip()]
    return StanceQuestion(
        question.name, stance.without(*names), question.mass, question.com, question.external_wrench
    )


def _robot_asked(
    name: str | None, urdf: Path | None, feet: str | None, slope: float, mu: float, lift: str | None
) -> Asked:
    from surefoot.cli import parsing
    from surefoot.robot import load_robot, place
    from surefoot.stance import SlopeTerrain

    if name is not None and urdf is not None:
        raise ProblemError("give --robot or --urdf, not both")
    terrain = SlopeTerrain(slope)
    robot = load_robot(str(urdf) if urdf is not None else str(name), parsing.names(feet))
    q = place(robot, terrain)
    stance = robot.stance(q, mu=mu, terrain=terrain)
    lifted = [robot.foot(n).name for n in parsing.names(lift) or []]
    title = f"{robot.name} on a slope of {slope:g} deg" if slope else f"{robot.name} on flat ground"
    if lifted:
        title += f", {', '.join(lifted)} lifted"
    stance = stance.without(*lifted)
    return Asked(StanceQuestion(title, stance, robot.mass, robot.com(q), np.zeros(6)), robot, q)
