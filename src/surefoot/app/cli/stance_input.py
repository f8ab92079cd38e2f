"""The stance that a command is asked about: from a stance file, or from a robot on a terrain."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
import typer

from surefoot.app.cli import extras, options, parsing
from surefoot.app.cli.robots import is_file, load
from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError

if TYPE_CHECKING:
    from surefoot.mechanics.stance import StanceQuestion


class StanceCase(NamedTuple):
    """What a command is about; robot and q are None for a stance file."""

    question: StanceQuestion
    robot: Any = None
    q: Any = None


@dataclass(frozen=True, kw_only=True)
class StanceOptions(options.Ground):
    """Which stance it is: of a file, or of a robot on a terrain."""

    subject: Annotated[
        str,
        typer.Argument(
            help="A stance file (YAML, see docs/files.md; - reads what is piped in), or ROBOT: a name, "
            "a .urdf or an .xml.",
            metavar="FILE|ROBOT",
        ),
    ]
    feet: options.FootFrames = None
    mu: Annotated[float | None, typer.Option(help="Friction of every contact (robot: 0.6).")] = None
    lift: Annotated[str | None, typer.Option(help="Contacts that are in the air, comma-separated.")] = None

    def case(self) -> StanceCase:
        """Return the stance of the file, or of the robot placed on the slope."""
        if self.mu is not None:
            parsing.friction("--mu", self.mu)
        path = Path(self.subject)
        named = path.exists() or path.suffix or "/" in self.subject
        of_file = self.subject == "-" or (not is_file(self.subject) and named)
        return StanceCase(self._of_file(path)) if of_file else self._of_robot()

    def _of_file(self, file: Path) -> StanceQuestion:
        from surefoot.mechanics.stance import StanceQuestion, read_stance

        if self.feet is not None or not self.is_default:
            raise ProblemError("--feet, --slope and --terrain go with a robot, not with a stance file")
        said = read_stance(file)
        _check_sizes(said, file)
        stance = said.stance if self.mu is None else said.stance.with_friction(self.mu)
        stance = stance.without(*(parsing.names("--lift", self.lift) or []))
        return StanceQuestion(said.name, stance, said.mass, said.com, said.external_wrench)

    def _of_robot(self) -> StanceCase:
        from surefoot.mechanics import place
        from surefoot.mechanics.stance import StanceQuestion

        extras.require(extras.robot_packages(self.subject))
        terrain = self.read()
        robot = load(self.subject, self.feet, feet_needed=True)
        q = place(robot, terrain)
        stance = robot.stance(q, mu=0.6 if self.mu is None else self.mu, terrain=terrain)
        lifted = [robot.foot(n).name for n in parsing.names("--lift", self.lift) or []]
        ground = self.terrain or "flat ground" if not self.slope else f"a slope of {self.slope:g} deg"
        title = f"{robot.name} on {ground}"
        title += f", {', '.join(lifted)} lifted" if lifted else ""
        stance = stance.without(*lifted)
        return StanceCase(StanceQuestion(title, stance, robot.mass, robot.com(q), np.zeros(6)), robot, q)


def _check_sizes(question: StanceQuestion, file: Path) -> None:
    """Refuse sizes that no robot has, where double precision would no longer tell right from wrong."""
    real_number(f"{file}: mass", question.mass, low=0.0, high=1e9)
    sizes = {name: getattr(question, name) for name in ("com", "external_wrench")}
    for name, values in {**sizes, "positions": question.stance.positions}.items():
        real_number(f"{file}: largest entry of {name}", np.abs(values).max(initial=0.0), high=1e9)
    real_number(f"{file}: mu", np.max(question.stance.mu, initial=0.0), low=0.0, high=parsing.MU_MAX)
