"""`--scenario FILE`: what happens to a simulated robot that no option says, as YAML.

The keys, their units and their bounds stand in `scenario_keys.py`, and nowhere else: files are checked
against it, and `scenario.schema.json`, which an editor may be given, is made of it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from surefoot.base.errors import check_name, located
from surefoot.base.text_files import read_yaml

SCHEMA = Path(__file__).with_name("scenario.schema.json")
GROUND = frozenset({"ice", "law", "solref", "solimp", "substeps"})
"""Keys of the ground."""
FAULTS = frozenset({"delay", "weak_joint", "torque_loss"})
"""Keys of what is wrong between robot and controller."""
STAND_KEYS = GROUND | FAULTS
WALK_KEYS = GROUND | FAULTS | {
    "estimator", "noise", "believed_mu", "period", "velocity_file", "control_rate", "latency",
}  # fmt: skip


@dataclass(frozen=True)
class ScenarioFile:
    """What a scenario file says; see `surefoot.app.cli.scenario_keys` for each key's unit and bounds."""

    ice: tuple[dict[str, Any], ...] = ()
    law: Mapping[str, Any] | None = None
    solref: tuple[float, ...] | None = None
    solimp: tuple[float, ...] | None = None
    substeps: int | None = None
    delay: float = 0.0
    weak_joint: str = ""
    torque_loss: float = 0.0
    estimator: str = "inekf"
    noise: float | None = None
    believed_mu: float | str | None = None
    period: float | None = None
    velocity_file: Path | None = None
    control_rate: float = 1000.0
    latency: float | str = "auto"

    @staticmethod
    def read(path: Path | None, keys: Collection[str]) -> ScenarioFile:
        """Return what a file says in these keys; None says nothing.

        Raises
        ------
        ProblemError
            Naming the file and the entry at fault: a key that is unknown, missing or of another command, a
            value that is not what it should be.
        """
        if path is None:
            return ScenarioFile()
        from surefoot.app.cli.scenario_keys import Scenario
        from surefoot.base.file_models import read_as

        content = read_yaml(path, "the scenario")
        with located(path):
            said: dict[str, Any] = {**read_as(Scenario, {} if content is None else content, spoken=True)}
            for key in said:
                check_name("key for this command", key, keys)
        if "velocity_file" in said:
            said["velocity_file"] = path.parent / said["velocity_file"]
        return ScenarioFile(**said)

    @property
    def given(self) -> list[str]:
        """The keys that say something else than the default."""
        return [f.name for f in fields(self) if getattr(self, f.name) != f.default]
