"""How often intervals of friction hold the truth, foot by foot, on walks: docs/reports/estimation.md.

Run: python -m benchmarks.friction_walks [--quick] [--json]. A Go2 trots on friction of 0.2 to 0.9, told 0.6,
on level ground or a slope, in MuJoCo or the rigid world, on an estimated state, with late commands, and is
pushed; its torques are told with noise, wrong scales and late. Walks that fall are cut where they lean.
"""

from __future__ import annotations

from collections.abc import Sequence

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

DURATION, DRAWS, FIRST = 4.0, 40, 100
"""Of a walk [s], how many, and the first seed: limits were chosen on seeds 0 to 59."""
LOWEST, HIGHEST = 0.2, 0.9
"""Friction of the floors [-]."""
SLIPPERY, SLIPPERY_DRAWS = 0.3, 16
"""Highest friction of the walks that slip, and how many of them."""
SCALE, NOISE, LATE = 0.03, 0.05, 1.0
"""Deviation of each torque's scale, noise as a share of a joint's mean torque, and delay [rows]."""


def slipping_walk(seed: int, highest: float = HIGHEST) -> tuple[Log, float]:
    """Return the log of a walk, its torques as sensors tell them, and the friction, up to `highest`."""
    random = np.random.default_rng(seed)
    mu, slope = float(random.uniform(LOWEST, highest)), float(random.choice([0.0, 0.0, 4.0, 8.0]))
    velocity = (float(random.uniform(0.3, 0.7)), 0.0, float(random.uniform(-0.4, 0.4)))
    push = Push(1.0, (float(random.uniform(-40.0, 40.0)), float(random.uniform(-40.0, 40.0)), 0.0), 0.2)
    walk = UntoldWalk(
        velocity=velocity, mu=mu, believed_mu=0.6, terrain=f"slope:{slope:g}" if slope else "flat",
        world=("mujoco", "rigid")[seed % 2], sensors=SensorModel(), pushes=(push,),
        faults=Faults(delay=1e-3 * int(random.integers(0, 4))),
    )  # fmt: skip
    log = walk.log(seed, DURATION)
    torques = np.array(log["torques"])
    told = shift(torques, (LATE, 0.0), order=1, mode="nearest")
    told *= 1.0 + SCALE * random.normal(size=torques.shape[1])
    told += NOISE * np.abs(torques).mean(axis=0) * random.normal(size=torques.shape)
    return Log({**log.arrays, "torques": told}, log.facts), mu


def friction_table(draws: int, highest: float = HIGHEST) -> Table:
    """Return how many intervals hold the truth, by how often a foot slid."""
    groups: dict[str, list[tuple[FootFriction, float]]] = {
        "bounded below only": [], "5 to 9 slips": [], "10 and more": []
    }  # fmt: skip
    for seed in range(FIRST, FIRST + draws):
        log, mu = slipping_walk(seed, highest)
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
    return table(columns, rows, f"{draws} walks, mu {LOWEST:g} to {highest:g}: friction under each foot")


def main(arguments: Sequence[str] | None = None) -> None:
    """Walk and print the table."""
    given = options(__doc__, "three walks").parse_args(arguments)
    slippery = friction_table(1 if given.quick else SLIPPERY_DRAWS, SLIPPERY)
    show([friction_table(2 if given.quick else DRAWS), slippery], given.json)


if __name__ == "__main__":
    main()
