"""The log of a run: arrays over time, written as one .npz that needs no pickle to read."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.errors import ProblemError

SCHEMA = 1

FIELDS: dict[str, str] = {
    "time": "(T,) time at the start of each step [s]",
    "q": "(T, nq) configuration, Pinocchio's order",
    "v": "(T, nv) velocity, Pinocchio's order",
    "torques": "(T, joints) applied joint torques [N m]",
    "forces": "(T, p, 3) ground force on each contact point as the world reports it, contact frames [N]",
    "forces_commanded": "(T, p, 3) the forces that the controller asked for [N]",
    "gaps": "(T, p) distance of each contact point to the ground, negative in penetration [m]",
    "contact_velocities": "(T, p, 3) velocity of the foot's material there, contact frames [m/s]",
    "contact_positions": "(T, p, 3) contact points, world axes [m]",
    "wrench_desired": "(T, 6) wanted wrench about the centre of mass [N, N m]",
    "wrench_error": "(T, 6) commanded forces' wrench less the wanted one",
    "grasp_map": "(T, 6, 3 p) from commanded forces to the wrench",
    "active": "(T, p) whether the controller lets a point push",
    "attained": "(T,) whether the wanted wrench was possible within the cones",
    "saturated": "(T,) whether a torque met its limit",
    "push": "(T, 3) external force on the base, world axes [N]",
    "mu": "(T,) friction of the ground",
    "planned": "(T, n) whether the gait wants a foot on the ground",
    "command": "(T, 3) wanted velocity of the body: forward, left [m/s], yaw rate [rad/s]",
    "controller_time": "(T,) wall time of the controller's step [s]",
}
"""What a log holds; every array has one row per step, T rows in all and p contact points."""


@dataclass
class Log:
    """Arrays of `FIELDS` and facts about the run; also what an interrupted run leaves.

    Attributes
    ----------
    arrays
        Name to array, cut to the steps that were made.
    facts
        Scalars and lists of strings: robot, mass, dt, feet, contact_foot, effort_limits, ...
    """

    arrays: dict[str, Any]
    facts: dict[str, Any] = field(default_factory=dict)

    def __getitem__(self, name: str) -> Any:
        return self.arrays[name]

    def __len__(self) -> int:
        return len(self.arrays["time"])

    def save(self, path: Path) -> Path:
        """Write to a new .npz file: the arrays, and each fact as ``fact_NAME``.

        Raises
        ------
        ProblemError
            If the file exists already; nothing is overwritten.
        """
        if path.exists():
            raise ProblemError(f"{path} exists already")
        facts = {f"fact_{k}": np.asarray(v) for k, v in self.facts.items()}
        contents: dict[str, Any] = {"schema": np.int64(SCHEMA), **self.arrays, **facts}
        np.savez_compressed(path, **contents)
        return path


def read_log(path: Path | str) -> Log:
    """Read a log that `Log.save` wrote.

    Raises
    ------
    ProblemError
        If the file is missing, not a log, or of a schema that this version does not know.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            if int(file["schema"]) != SCHEMA:
                raise ProblemError(f"{path} has log schema {int(file['schema'])}, expected {SCHEMA}")
            arrays = {k: file[k] for k in file.files if k in FIELDS}
            facts = {k[5:]: file[k].tolist() for k in file.files if k.startswith("fact_")}
    except (OSError, ValueError, KeyError) as error:
        raise ProblemError(f"{path} is not a Surefoot log: {error}") from error
    return Log(arrays, facts)


class Recorder:
    """Collects the rows of a log in arrays that are allocated once."""

    def __init__(self, steps: int, **rows: tuple[int, ...]) -> None:
        self.arrays: dict[str, FloatArray] = {
            name: np.zeros(
                (steps, *shape),
                dtype=bool if name in ("active", "planned", "attained", "saturated") else float,
            )
            for name, shape in rows.items()
        }
        self.count = 0

    def finish(self, facts: dict[str, Any]) -> Log:
        """Return the log of the rows written so far."""
        return Log({name: array[: self.count].copy() for name, array in self.arrays.items()}, facts)
