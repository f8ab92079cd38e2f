"""Which walks of learned policies are their simulator's softness: each in worlds of other contacts.

    python -m benchmarks.transfer NETWORK ... [--spec YAML ...] [--seeds 10] [--seconds 4]
    python -m benchmarks.transfer --quick

Each policy is told 0.5 m/s on flat ground of friction 0.6; a walk succeeds that does not fall and makes half
the way. ``--quick`` carries a crate on a slope instead, which MuJoCo's soft contacts let creep.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.records.log import Ending
from surefoot.worlds.mujoco.spec import import_mujoco
from surefoot.worlds.transfer.variants import STANDARD

SPEED, SHARE = 0.5, 0.5
"""Commanded [m/s], and share of its way that a success makes."""
CRATE = """<mujoco><worldbody><geom name="slope" type="plane" size="9 9 1" euler="0 20 0"/>
<body pos="0 0 .11" euler="0 20 0"><freejoint/><geom name="crate" type="box" size=".1 .1 .1"/></body>
</worldbody></mujoco>"""
"""A crate that friction holds."""


def walked(seconds: float) -> Callable[[sf.Log], bool]:
    """Return what tells whether a log is of a walk of so long."""

    def success(log: sf.Log) -> bool:
        way = float(np.linalg.norm(log["q"][-1, :2] - log["q"][0, :2]))
        return bool(log.facts["outcome"] == Ending.DONE and way >= SHARE * SPEED * seconds)

    return success


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a table for each policy."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("networks", nargs="*", type=Path)
    parser.add_argument(
        "--spec", action="append", type=Path, default=[], help="NETWORK's stem is this file's"
    )
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args(arguments)
    if given.quick:
        model = import_mujoco().MjModel.from_xml_string(CRATE)
        report = sf.transfer(
            model, np.zeros((400, 0)), STANDARD, 5, success=lambda m, d: math.hypot(*d.qvel[:2]) < 1e-6
        )
        print("crate at rest on 20 degrees", "\n".join(report.table()), sep="\n\n", flush=True)
    specs = {path.stem: path for path in given.spec}
    for network in given.networks:
        start = time.process_time()
        policy = sf.Policy(network, specs.get(network.stem), command=(SPEED, 0.0, 0.0), dt=1e-3, trust=True)
        report = sf.transfer(
            policy.robot, policy, STANDARD, given.seeds, duration=given.seconds, success=walked(given.seconds)
        )
        print(
            network.stem,
            "\n".join(report.table()),
            f"({time.process_time() - start:.0f} s of CPU)",
            sep="\n\n",
            flush=True,
        )


if __name__ == "__main__":
    main()
