"""What the audit says of robots of gymnasium that nobody trained: 24 runs, none broken without a true cause.

Run by `surefoot bench audit --gymnasium FOLDER`. Ant, Hopper, Walker2d and Humanoid as gymnasium ships and
starts them, under no action for 100 steps of the environment, random ones for 100 and for 300, from two
seeds each. Their files are gymnasium's: they are read where it is installed, or in a folder that is given.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.worlds.mujoco.mujoco_world import import_mujoco


@dataclass(frozen=True)
class Environment:
    """One of gymnasium's environments.

    Attributes
    ----------
    name, files
        Its name, and its model's file in the order of preference.
    skip
        Steps of the simulation in one of the environment.
    noise
        Of the start: of positions, uniform, and of velocities, normal [m, rad, and their rates].
    """

    name: str
    files: tuple[str, ...]
    skip: int
    noise: tuple[float, float]


ENVIRONMENTS = (
    Environment("Ant", ("ant.xml",), 5, (0.1, 0.1)),
    Environment("Hopper", ("hopper.xml",), 4, (0.005, 0.005)),
    Environment("Walker2d", ("walker2d_v5.xml", "walker2d.xml"), 4, (0.005, 0.005)),
    Environment("Humanoid", ("humanoid.xml",), 5, (0.01, 0.01)),
)
ACTIONS = (("no action", 0.0, 100), ("random", 1.0, 100), ("random, long", 1.0, 300))
"""What is done: its name, the share of the controls' range, and steps of the environment."""
SEEDS = (0, 1)


@dataclass(frozen=True)
class GymnasiumRun:
    """What the audit says of one run.

    Attributes
    ----------
    name, actions, seed
        Which run.
    verdict
        Of the audit.
    why
        Laws that are broken, else why one cannot tell.
    finding
        The first symptom.
    """

    name: str
    actions: str
    seed: int
    verdict: str
    why: str
    finding: str


def assets(folder: Path | None) -> Path | str:
    """Return the folder of gymnasium's models, or why there is none."""
    if folder is not None:
        lacking = [e.name for e in ENVIRONMENTS if model_file(folder, e) is None]
        return f"{folder} has no model of {', '.join(lacking)}" if lacking else folder
    found = find_spec("gymnasium")
    if found is None or found.origin is None:
        return "gymnasium is not installed: install it, or give the folder of its models (envs/mujoco/assets)"
    return assets(Path(found.origin).parent / "envs" / "mujoco" / "assets")


def model_file(folder: Path, one: Environment) -> Path | None:
    """Return the file of a model in a folder, None where there is none."""
    return next((folder / name for name in one.files if (folder / name).is_file()), None)


def measure(folder: Path, quick: bool = False) -> Iterator[GymnasiumRun]:
    """Yield what the audit says of every run; quickly of one a robot."""
    for one in ENVIRONMENTS:
        for actions, size, steps in ACTIONS[1:2] if quick else ACTIONS:
            for seed in SEEDS[:1] if quick else SEEDS:
                report = sf.audit_log(_recorded(folder, one, size, steps, seed))
                broken = dict.fromkeys(v.law for v in report.violations)
                first = str(report.symptoms[0]) if report.symptoms else ""
                yield GymnasiumRun(
                    one.name, actions, seed, report.verdict, ", ".join(broken) or report.reason, first
                )


def _recorded(folder: Path, one: Environment, size: float, steps: int, seed: int) -> sf.Log:
    """Return the log of a run."""
    mujoco, rng = import_mujoco(), np.random.default_rng(seed)
    model: Any = mujoco.MjModel.from_xml_path(str(model_file(folder, one)))
    data = mujoco.MjData(model)
    data.qpos[:] += rng.uniform(-one.noise[0], one.noise[0], model.nq)
    data.qvel[:] += rng.normal(size=model.nv) * one.noise[1]
    low, high = model.actuator_ctrlrange.T
    with sf.record(model, data) as log:
        for _ in range(steps):
            data.ctrl[:] = size * rng.uniform(low, high)
            mujoco.mj_step(model, data, one.skip)
    return log
