"""Where each joule of a walk goes: its cost of transport by part.

    python -m benchmarks.stacks.energy [--speed 0.5] [--set ease=1.0] [--policy NETWORK]

One seed in the hard world. Of the positive work of all joints: what legs on the ground and in the air take,
each joint's, and what would be left if joints of a leg, or all, gave each other what they brake (what
rotors and co-contraction cost), and what is not got back at all (friction, impacts). ``--set`` changes a
field of `WalkSettings`.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.stacks.learned import LearnedStack
from benchmarks.stacks.measures import Measures, measured
from benchmarks.stacks.stack import Stack, Surefoot
from benchmarks.stacks.tasks import TASKS
from benchmarks.stacks.trial import carry_out
from surefoot.arrays import FloatArray
from surefoot.audit.motion import TOUCH, foot_forces
from surefoot.control.walking_settings import WalkSettings
from surefoot.log import Log
from surefoot.spatial import GRAVITY

SETTLED = 2.0
"""From when on work counts: the start is another matter [s]."""


def energy_parts(log: Log, settled: float = SETTLED) -> dict[str, float]:
    """Return parts of the cost of transport of a walk on point feet whose joints come leg by leg [-]."""
    late, weight, dt = log["time"] >= settled, log.fact("mass") * GRAVITY, float(log.fact("dt"))
    power = (log["torques"] * log["v"][:, 6:])[late]
    feet = len(log.fact("feet"))
    per = power.shape[1] // feet
    q = log["q"][late]
    share = dt / (weight * float(np.linalg.norm(q[-1, :2] - q[0, :2])))
    down = np.repeat(foot_forces(log)[late][..., 2] > TOUCH * weight, per, axis=1)
    work, brake = np.maximum(power, 0.0), np.maximum(-power, 0.0)
    legs = power.reshape(len(power), feet, per).sum(axis=2)
    parts = {
        "all": work, "on the ground": work * down, "in the air": work * ~down, "braked": brake,
        "if joints of a leg shared": np.maximum(legs, 0.0),
        "if all joints shared": np.maximum(power.sum(axis=1), 0.0), "never got back": power,
    }  # fmt: skip
    parts |= {f"joint {k + 1} of each leg": work[:, k::per] for k in range(per)}
    return {name: float(values.sum()) * share for name, values in parts.items()}


def main() -> None:
    """Print the table of one walk."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--speed", type=float, default=0.5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--set", action="append", default=[], metavar="NAME=NUMBER")
    parser.add_argument("--policy", type=Path)
    args = parser.parse_args()
    changes: dict[str, Any] = {name: float(value) for name, value in (text.split("=") for text in args.set)}
    stack: Stack = Surefoot() if args.policy is None else LearnedStack(args.policy)
    task, logs = replace(TASKS["speed-0.5"], asked=(args.speed, 0.0, 0.0)), list[Log]()

    def keep(log: Log, asked: FloatArray, settled: float) -> Measures:
        logs.append(log)
        return measured(log, asked, settled)

    with (
        patch("benchmarks.stacks.trial.measured", keep),
        patch("surefoot.control.walking.WalkSettings", lambda **given: WalkSettings(**given | changes)),
    ):
        done = carry_out(stack, task, args.seed)
    m = done.measures
    print(f"{stack.name}: {done.outcome}, {m.forward:.3f} m/s, {m.cost_of_transport:.3f} with its start")
    for name, value in energy_parts(logs[0]).items():
        print(f"  {name:28s}{value:7.3f}")


if __name__ == "__main__":
    main()
