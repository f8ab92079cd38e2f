"""What a simulated robot's controller knows of the ground: options of its terrain and its friction."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import typer

from surefoot.errors import ProblemError, check_name

if TYPE_CHECKING:
    from surefoot.cli.scenario_file import ScenarioFile
    from surefoot.terrain import Terrain

KNOWLEDGE = ("exact", "map", "blind")
ASSUMED = 0.6
"""Friction that is believed in until a foot slides, with `believed_mu: auto`."""
TerrainKnowledge: TypeAlias = Annotated[
    str,
    typer.Option(
        help="exact: the controller knows the terrain; map: a height map from a sensor; blind: touch."
    ),
]


@dataclass(frozen=True)
class Beliefs:
    """What the controller believes.

    Attributes
    ----------
    mu
        Friction [-] that it starts from.
    watch
        Whether it believes in less where feet slide.
    terrain
        Its knowledge of the terrain, a name of `KNOWLEDGE`.
    """

    mu: float
    watch: bool
    terrain: str

    @staticmethod
    def read(believed_mu: float | str | None, mu: float, terrain: str, planner: str) -> Beliefs:
        """Return the beliefs that options and scenario say, `mu` [-] being the ground's own.

        Raises
        ------
        ProblemError
            For an unknown word, or a planner that cannot do with less than the truth.
        """
        check_name("--terrain-knowledge", terrain, KNOWLEDGE)
        watch = isinstance(believed_mu, str)
        if planner != "convex" and (watch or terrain != "exact"):
            given = "believed_mu: auto" if watch else f"--terrain-knowledge {terrain}"
            raise ProblemError(f"{given} goes with --planner convex")
        if isinstance(believed_mu, str):
            return Beliefs(ASSUMED, True, terrain)
        return Beliefs(mu if believed_mu is None else believed_mu, False, terrain)

    def ground(self, terrain: Terrain) -> Terrain:
        """Return the ground that the controller plans on."""
        from surefoot.control.terrain_knowledge import believed_ground

        return believed_ground(self.terrain, terrain)

    def senses(self, said: ScenarioFile) -> dict[str, Any]:
        """Return what the scenario says of the senses; only with exact knowledge the filter has a map."""
        from surefoot.simulation.height_scan import RangeSensor
        from surefoot.simulation.sensors import SensorModel

        sensors = None
        if said.estimator == "inekf":
            sensors = SensorModel().scaled(1.0 if said.noise is None else said.noise)
            sensors = sensors if self.terrain == "exact" else replace(sensors, heights=False)
        return {"sensors": sensors, "scanner": RangeSensor() if self.terrain == "map" else None}
