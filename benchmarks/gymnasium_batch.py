"""What `sf.audit_batch` says of gymnasium's robots that nobody trained: many environments each.

    python -m benchmarks.gymnasium_batch [--environments 64] [--steps 1000] [--only Hopper] [--assets FOLDER]

Ant, Humanoid, Walker2d and Hopper as gymnasium ships and starts them, ended and started anew where it ends an
episode, under no action, random ones, and a gait of sines with phases of its own for each environment. Every
substep is a row. Their files are gymnasium's: they are read where it is installed, or in a folder.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import surefoot as sf
from benchmarks.gymnasium_runs import ENVIRONMENTS, Environment, assets, model_file
from benchmarks.printing import options, show, table
from surefoot.base.arrays import FloatArray
from surefoot.worlds.mujoco.engine_warnings import engine_warnings
from surefoot.worlds.mujoco.mujoco_world import import_mujoco

CHANNELS = ("forces", "gaps", "contact_velocities", "contact_friction")
"""Without places: contact points of a recording are other points of their geoms whenever MuJoCo says so."""
OPEN = 1.0
"""Gap of contact points that an environment has not [m]; other channels are zero there."""
SOFT = ("sinking", "creep", "stopping", "settling", "recoil", "creep_slope")
"""Facts of which the largest of all environments is declared."""
RATE, SIZE = 1.5, 0.7
"""Of the gait [1/s], and as a share of the controls' range."""
HEALTHY: dict[str, tuple[float, float, float]] = {
    "Ant": (0.2, 1.0, np.inf),
    "Humanoid": (1.0, 2.0, np.inf),
    "Walker2d": (0.8, 2.0, 1.0),
    "Hopper": (0.7, np.inf, 0.2),
}
"""Heights [m] and the lean [rad] outside of which gymnasium ends an episode."""
Action = Callable[[np.random.Generator, FloatArray, float], FloatArray]


def nothing(rng: np.random.Generator, phases: FloatArray, time: float) -> FloatArray:
    """Return no action."""
    return np.zeros(len(phases))


def random(rng: np.random.Generator, phases: FloatArray, time: float) -> FloatArray:
    """Return a random action, uniform over the range."""
    return rng.uniform(-1.0, 1.0, len(phases))


def gait(rng: np.random.Generator, phases: FloatArray, time: float) -> FloatArray:
    """Return sines."""
    return SIZE * np.sin(2.0 * np.pi * RATE * time + phases)


ACTIONS: dict[str, Action] = {"none": nothing, "random": random, "gait": gait}


def healthy(name: str, data: Any) -> bool:
    """Return whether gymnasium goes on with an episode."""
    low, high, lean = HEALTHY[name]
    floating = data.model.jnt_type[0] == 0
    height = data.qpos[2] if floating else data.qpos[1]
    return bool(low < height < high and (floating or abs(data.qpos[2]) < lean))


def record_one(
    folder: Path, one: Environment, action: Action, steps: int, seed: int
) -> tuple[sf.Log, FloatArray]:
    """Return the log of an environment, and the way of its root in every row [m]."""
    mujoco, rng = import_mujoco(), np.random.default_rng([61, seed])
    model: Any = mujoco.MjModel.from_xml_path(str(model_file(folder, one)))
    data = mujoco.MjData(model)
    phases = rng.uniform(0.0, 2.0 * np.pi, model.nu)
    low, high = model.actuator_ctrlrange.T
    ways: list[float] = []

    def start() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[:] += rng.uniform(-one.noise[0], one.noise[0], model.nq)
        data.qvel[:] += rng.normal(size=model.nv) * one.noise[1]

    start()
    with engine_warnings(), sf.record(model, data) as log:
        for _ in range(steps):
            a = action(rng, phases, data.time)
            data.ctrl[:] = 0.5 * (low + high) + 0.5 * (high - low) * a
            for _ in range(one.skip):
                before = float(data.qpos[0])
                mujoco.mj_step(model, data)
                ways.append(float(data.qpos[0]) - before)
            if not healthy(one.name, data):
                start()
    return log, np.array(ways)


def put_together(logs: list[sf.Log], ways: list[FloatArray]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return arrays and options of `sf.audit_batch` of environments with contact points of their own."""
    rows = min(len(log) for log in logs)
    points = max(log["forces"].shape[1] for log in logs)
    arrays: dict[str, Any] = {}
    for name in CHANNELS:
        size = np.asarray(logs[0][name]).shape[2:]
        arrays[name] = np.full((rows, len(logs), points, *size), OPEN if name == "gaps" else 0.0, np.float32)
        for k, log in enumerate(logs):
            part = np.asarray(log[name])[:rows]
            arrays[name][:, k, : part.shape[1]] = part
    done = np.zeros((rows, len(logs)), dtype=bool)
    for k, log in enumerate(logs):
        starts = np.asarray(log.facts.get("episode_rows", [0]), dtype=int)
        done[[row - 1 for row in starts if 0 < row <= rows], k] = True
    facts: dict[str, Any] = {name: max(float(log.facts.get(name, 0.0)) for log in logs) for name in SOFT}
    if "velocities" in logs[0].facts:
        facts["velocities"] = logs[0].facts["velocities"]
    for name, most in (
        ("contact_margin", np.max),
        ("contact_damping", np.min),
        ("critically_damped", np.min),
    ):
        if name in logs[0].facts:
            facts[name] = np.full(points, most([most(log.facts[name]) for log in logs if name in log.facts]))
    reward = np.stack([way[:rows] for way in ways], axis=1)
    return arrays, {
        "facts": facts, "done": done, "reward": reward, "mass": float(logs[0].fact("mass")),
        "dt": float(logs[0].fact("dt")),
    }  # fmt: skip


def rows_of(folder: Path, count: int, steps: int, only: str) -> Iterator[list[str]]:
    """Yield a row of the table for each robot and kind of action."""
    for one in ENVIRONMENTS:
        if only and only not in one.name:
            continue
        for name, action in ACTIONS.items():
            parts = [record_one(folder, one, action, steps, seed) for seed in range(count)]
            arrays, rest = put_together([log for log, _ in parts], [way for _, way in parts])
            report = sf.audit_batch(arrays, **rest)
            verdicts = Counter(report.verdicts)
            laws = [law.name for law in report.laws.values() if law.law and law.share.any()]
            told = ", ".join(
                f"{one.name} {round(one.environments * count)} ({100.0 * one.rows:.2g} %)"
                for one in report.exploits[:3]
            )
            counts = [str(verdicts[verdict]) for verdict in ("lawful", "cannot tell", "broken")]
            yield [one.name, name, str(report.episodes), *counts, ", ".join(laws), told]


def main() -> None:
    """Print the table."""
    parser = options(__doc__, "two environments of 50 steps")
    parser.add_argument("--environments", type=int, default=64)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--only", default="", help="robots whose names hold this")
    parser.add_argument("--assets", type=Path, default=None, help="folder of gymnasium's models")
    given = parser.parse_args()
    folder = assets(given.assets)
    if isinstance(folder, str):
        parser.error(folder)
    count, steps = (2, 50) if given.quick else (given.environments, given.steps)
    start = time.process_time()
    header = (
        "robot",
        "actions",
        "episodes",
        "lawful",
        "cannot tell",
        "broken",
        "laws",
        "environments (rows) with",
    )
    title = f"{count} environments of {steps} steps"
    rows = list(rows_of(folder, count, steps, given.only))
    show([table(header, rows, title, left=2, texts=("laws", "environments (rows) with"))], given.json)
    if not given.json:
        print(f"({time.process_time() - start:.0f} s of CPU)")


if __name__ == "__main__":
    main()
