"""How often intervals of friction hold the truth, foot by foot, on walks: docs/reports/estimation.md.

Run: python -m benchmarks.friction_walks [--quick] [--json]. A Go2 trots on friction of 0.2 to 0.9, told 0.6,
on level ground or a slope, in MuJoCo or the rigid world, on an estimated state, with late commands, and is
pushed; its torques are told with noise, wrong scales and late. Then it is pushed every second for 12 s on
friction of 0.22 to 0.4 that it believes 1.1 to 1.5 times as high. Walks that fall are cut where they lean.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from rich.table import Table
from scipy.ndimage import shift

from benchmarks.identify_walks import UntoldWalk
from benchmarks.printing import options, show, table
from benchmarks.walks import known_robot
from surefoot.records.identification.foot_friction import SHORTEST, FootFriction, friction_of_walk
from surefoot.records.log import Log
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.run import Push
from surefoot.worlds.running.sensors import SensorModel

DURATION, DRAWS, FIRST = 4.0, 200, 100
"""Of a walk [s], how many, and the first seed: limits were chosen on others."""
LOWEST, HIGHEST = 0.2, 0.9
"""Friction of the floors [-]."""
SLIPPERY, SLIPPERY_DRAWS, LONG = (0.22, 0.4), 40, 12.0
"""Friction of the floors of walks that slip again and again, how many of them, and how long they are [s]."""
SCALE, NOISE, LATE = 0.03, 0.05, 1.0
"""Deviation of each torque's scale, noise as a share of a joint's mean torque, and delay [rows]."""


def slipping_walk(seed: int) -> tuple[Log, float]:
    """Return the log of a walk, its torques as sensors tell them, and the friction."""
    random = np.random.default_rng(seed)
    mu, slope = float(random.uniform(LOWEST, HIGHEST)), float(random.choice([0.0, 0.0, 4.0, 8.0]))
    velocity = (float(random.uniform(0.3, 0.7)), 0.0, float(random.uniform(-0.4, 0.4)))
    push = Push(1.0, (float(random.uniform(-40.0, 40.0)), float(random.uniform(-40.0, 40.0)), 0.0), 0.2)
    walk = UntoldWalk(
        velocity=velocity, mu=mu, believed_mu=0.6, terrain=f"slope:{slope:g}" if slope else "flat",
        world=("mujoco", "rigid")[seed % 2], sensors=SensorModel(), pushes=(push,),
        faults=Faults(delay=1e-3 * int(random.integers(0, 4))),
    )  # fmt: skip
    return _told(walk.log(seed, DURATION), random), mu


def slippery_walk(seed: int) -> tuple[Log, float]:
    """Return the same of a walk that is pushed every second on a floor that it thinks less slippery."""
    random = np.random.default_rng(seed)
    mu = float(random.uniform(*SLIPPERY))
    believed, size = mu * float(random.uniform(1.1, 1.5)), float(random.uniform(20.0, 60.0))
    pushed = random.uniform(-size, size, (int(LONG) - 1, 2)).tolist()
    pushes = [Push(1.0 + k, (forward, left, 0.0), 0.2) for k, (forward, left) in enumerate(pushed)]
    walk = UntoldWalk(
        velocity=(float(random.uniform(0.4, 0.8)), 0.0, float(random.uniform(-0.5, 0.5))), mu=mu,
        believed_mu=believed, world=("mujoco", "rigid")[seed % 2], sensors=SensorModel(),
        pushes=tuple(pushes), faults=Faults(delay=1e-3 * int(random.integers(0, 4))),
    )  # fmt: skip
    return _told(walk.log(seed, LONG), random), mu


def _told(log: Log, random: np.random.Generator) -> Log:
    """Return the log with torques as sensors tell them."""
    torques = np.array(log["torques"])
    told = shift(torques, (LATE, 0.0), order=1, mode="nearest")
    told *= 1.0 + SCALE * random.normal(size=torques.shape[1])
    told += NOISE * np.abs(torques).mean(axis=0) * random.normal(size=torques.shape)
    return Log({**log.arrays, "torques": told}, log.facts)


def friction_table(walk: Callable[[int], tuple[Log, float]], draws: int, title: str) -> Table:
    """Return how many intervals hold the truth, by how often a foot slid."""
    groups: dict[str, list[tuple[FootFriction, float]]] = {
        "bounded below only": [], "5 to 9 slips": [], "10 and more": []
    }  # fmt: skip
    for seed in range(FIRST, FIRST + draws):
        log, mu = walk(seed)
        if len(log) * log.fact("dt") < SHORTEST:
            continue
        for foot in friction_of_walk(known_robot("go2"), log):
            kind = "bounded below only" if np.isinf(foot.high) else "5 to 9 slips"
            groups["10 and more" if foot.slips >= 10 and np.isfinite(foot.high) else kind].append((foot, mu))
    rows = []
    for kind, found in groups.items():
        held = sum(foot.low <= mu <= foot.high for foot, mu in found)
        width = np.array([foot.high - foot.low for foot, _ in found if np.isfinite(foot.high)])
        low = np.median([foot.low / mu for foot, mu in found]) if found else np.nan
        half = f"{np.median(width) / 2.0:.3f}, at most {width.max() / 2.0:.3f}" if len(width) else "-"
        rows.append((kind, str(len(found)), str(held), half, f"{low:.2f}"))
    columns = ("feet", "how many", "hold the truth", "half-width (median)", "low / mu (median)")
    return table(columns, rows, f"{draws} {title}: friction under each foot")


def main(arguments: Sequence[str] | None = None) -> None:
    """Walk and print the tables."""
    given = options(__doc__, "three walks").parse_args(arguments)
    usual = f"walks, mu {LOWEST:g} to {HIGHEST:g}"
    often = f"slippery walks, mu {SLIPPERY[0]:g} to {SLIPPERY[1]:g}"
    show(
        [
            friction_table(slipping_walk, 2 if given.quick else DRAWS, usual),
            friction_table(slippery_walk, 1 if given.quick else SLIPPERY_DRAWS, often),
        ],
        given.json,
    )


if __name__ == "__main__":
    main()
