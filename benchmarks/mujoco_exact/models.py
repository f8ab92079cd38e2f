"""Other people's models under random actions: how many steps are solved exactly, and what they cost.

The files are those of gymnasium and of dm_control's suite, in a folder that holds them (``pip install
--no-deps --target FOLDER gymnasium dm_control``). Actions are drawn anew over the whole range of the
controls, each step or for as many as are asked for.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

import surefoot as sf

GYMNASIUM = (
    "ant", "hopper", "walker2d_v5", "half_cheetah", "swimmer", "pusher_v5", "reacher", "humanoid",
    "humanoidstandup", "inverted_double_pendulum",
)  # fmt: skip
"""Models of gymnasium/envs/mujoco/assets."""
DM_CONTROL = (
    "quadruped", "fish", "dog", "hopper", "walker", "cheetah", "humanoid", "humanoid_CMU", "finger",
    "manipulator", "stacker", "ball_in_cup", "swimmer", "reacher",
)  # fmt: skip
"""Models of dm_control/suite."""
FOLDERS = {"gym": ("gymnasium/envs/mujoco/assets", GYMNASIUM), "dm": ("dm_control/suite", DM_CONTROL)}
"""Short name of a package to where its models lie, and which."""
ACCEPTED = 1e-6
"""Velocity error over the speed of approach up to which a step counts as certified [-]."""


@dataclass
class ModelRun:
    """One model's run.

    Attributes
    ----------
    name
        Package and model.
    steps, held
        Steps, and those of them that have contacts, limits, equalities or dry joints.
    missed
        Steps of these that are not certified: MuJoCo's soft ones.
    lost
        Steps whose state or sensors are no finite numbers.
    exact, soft
        CPU time of a step, and of `mj_step` in the same run with elliptic cones, medians [µs].
    said
        Why it did not run, else nothing.
    """

    name: str
    steps: int = 0
    held: int = 0
    missed: int = 0
    lost: int = 0
    exact: float = 0.0
    soft: float = 0.0
    said: str = ""

    @property
    def share(self) -> float:
        """Share of the steps with constraints that is certified [-]."""
        return 1.0 - self.missed / self.held if self.held else 1.0


def find_models(folder: Path) -> dict[str, Path]:
    """Return the models that a folder holds, by package and name."""
    found = {}
    for package, (place, names) in FOLDERS.items():
        for name in names:
            file = folder / place / f"{name}.xml"
            if file.is_file():
                found[f"{package} {name}"] = file
    return found


def _range(model: Any) -> tuple[Any, Any]:
    """Return the least and largest controls (nu,); those without a range from -1 to 1."""
    limited = np.array(model.actuator_ctrllimited).astype(bool)
    low, high = np.where(limited[:, None], np.array(model.actuator_ctrlrange), [-1.0, 1.0]).T
    return low, high


def run_model(name: str, file: Path, seconds: float, hold: int, seed: int) -> ModelRun:
    """Return how a model goes under random actions."""
    out = ModelRun(name)
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # cones become elliptic: that is known
            stepper = sf.MujocoStepper(model)
    except (ValueError, sf.SurefootError) as error:
        out.said = str(error).splitlines()[0]
        return out
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    data, twin, rng = mujoco.MjData(model), mujoco.MjData(model), np.random.default_rng(seed)
    (low, high), taken = _range(model), []
    for k in range(round(seconds / model.opt.timestep)):
        if k % hold == 0:
            control = rng.uniform(low, high)
        data.ctrl[:] = twin.ctrl[:] = control
        before, begin = stepper.unsolved, time.thread_time_ns()
        stepper.step(data)
        middle = time.thread_time_ns()
        mujoco.mj_step(model, twin)
        taken.append((middle - begin, time.thread_time_ns() - middle))
        held = stepper.certificate.blocks > 0
        out.held += held
        wrong = stepper.unsolved > before or stepper.certificate.velocity_error > ACCEPTED
        out.missed += held and wrong
        finite = all(np.isfinite(part).all() for part in (data.qpos, data.qvel, data.qacc, data.sensordata))
        out.lost += not finite
    out.steps = len(taken)
    out.exact, out.soft = np.median(np.array(taken), axis=0) / 1e3
    return out


def run_models(folder: Path, seconds: float, hold: int, seed: int) -> Iterator[ModelRun]:
    """Yield the runs of all models that a folder holds."""
    for name, file in find_models(folder).items():
        yield run_model(name, file, seconds, hold, seed)


def model_rows(runs: list[ModelRun]) -> list[list[str]]:
    """Return the rows of the table, the sum at its end."""
    rows = [
        [
            r.name, str(r.steps), str(r.held), f"{100.0 * r.share:.3f}", str(r.missed), str(r.lost),
            f"{r.exact:.0f}", f"{r.soft:.0f}",
        ]
        for r in runs
        if not r.said
    ]  # fmt: skip
    held, missed = sum(r.held for r in runs), sum(r.missed for r in runs)
    share = 100.0 * (1.0 - missed / max(held, 1))
    lost = sum(r.lost for r in runs)
    rows.append(["all", str(sum(r.steps for r in runs)), str(held), f"{share:.3f}", str(missed), str(lost),
                 "", ""])  # fmt: skip
    return rows


MODEL_HEAD = ("model", "steps", "held", "certified [%]", "soft", "not finite", "exact [µs]", "mj_step [µs]")
"""Titles of `model_rows`."""
