"""What learned policies take from soft contact, whether that predicts how they do elsewhere, and a guard.

    python -m benchmarks.policies NETWORK ... [--spec YAML ...] [--seeds 5] [--guard]

Each policy walks at 0.5 m/s for 10 s in the physics of its training, where an .xml of its stem beside it
says which, else on MuJoCo's default softness with steps of 4 ms; and in ours. Its score is the number of an
audit's symptoms in ours. Then it walks on ice, a slope, stiff ground and with a delay. ``--guard`` holds each
beside itself with `surefoot.Guard` on ice and where soft ground becomes hard.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

import surefoot as sf
from benchmarks import audit_models
from surefoot.records.audit.motion import foot_forces, heading_velocity
from surefoot.records.log import Ending
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.observers import Moment, Observer

SPEED, SECONDS, CHANGE = 0.5, 6.0, 2.5
"""Commanded [m/s], how long where it may fall, and when soft ground becomes hard [s]."""
DEFAULT: dict[str, Any] = {"dt": 4e-3, "solref": (0.02, 1.0), "solimp": (0.9, 0.95, 0.001, 0.5, 2.0)}
STIFF, SOFT = (0.002, 1.0), (0.08, 1.0)
"""solref of stiff and soft ground."""
ELSEWHERE: dict[str, dict[str, Any]] = {
    "ice 0.2": {"mu": 0.2}, "slope 15": {"terrain": sf.SlopeTerrain(15.0)},
    "stiff": {"solref": STIFF}, "delay 20 ms": {"delay": 0.02},
}  # fmt: skip
GUARDED: dict[str, dict[str, Any]] = {
    "ice 0.2": {"mu": 0.2}, "ice 0.1, 150 N": {"mu": 0.1, "push": 150.0}, "ice 0.05": {"mu": 0.05},
    "soft to hard": {"solref": SOFT, "later": STIFF},
}  # fmt: skip


class _Harder(Observer):
    """Ground whose softness changes at `CHANGE`."""

    def __init__(self, world: sf.MujocoWorld, solref: Sequence[float] | None) -> None:
        self.world, self.solref = world, solref

    def step(self, moment: Moment) -> None:
        """Change it when its time has come."""
        if self.solref is not None and moment.time >= CHANGE:
            self.world.model.pair_solref[:] = self.solref


def walked(
    policy: sf.Policy, seconds: float, seed: int = 0, guard: bool = False, *, mu: float = 0.6,
    delay: float = 0.0, terrain: Any = None, push: float = 0.0, later: Any = None, **world: Any,
) -> sf.Log:  # fmt: skip
    """Return the log of a walk in a world with these settings."""
    ground = sf.FlatTerrain() if terrain is None else terrain
    place = sf.place(policy.robot, ground, policy.posture)
    there = sf.MujocoWorld(policy.robot, ground, mu, **world)
    pushes = [sf.Push(CHANGE + 0.05 * (seed % 8), (0.0, push, 0.0), 0.1)] if push else []
    faults = Faults(noise=0.5, delay=delay)
    scenario = sf.Scenario(seconds, mu, pushes, (), seed, faults, place)
    controller = sf.Guard(policy, mu=mu, terrain=ground) if guard else policy
    return sf.run(there, controller, scenario, [_Harder(there, later)])


def gained(log: sf.Log) -> dict[str, float]:
    """Return what a policy takes from contact, and how hard it lands."""
    dt, weight = float(log.fact("dt")), float(log.fact("mass")) * 9.81
    loaded, velocity = log["forces"][..., 2] > 0.02 * weight, log["contact_velocities"]
    power = (log["forces"] * velocity).sum(axis=-1)
    return {
        "depth [mm]": -1e3 * float(log["gaps"].min()),
        "touches": float((loaded[1:] & ~loaded[:-1]).sum()),
        "slid [m]": float((np.linalg.norm(velocity[..., :2], axis=-1) * loaded).sum()) * dt,
        "contact gave [J]": float(np.maximum(power, 0.0).sum()) * dt,
        "largest force [m g]": float(np.linalg.norm(foot_forces(log), axis=-1).max()) / weight,
        "symptoms": float(len(sf.audit_log(log).symptoms)),
    }


def _trained(policy: sf.Policy, file: Path) -> tuple[str, sf.Log]:
    """Return the name and the log of a walk in the physics of training."""
    own = file.with_suffix(".xml")
    if own.is_file():
        return "training", audit_models.walked(next(audit_models.models_under([own]))[1], 10.0, policy)
    return "default", walked(policy, 10.0, **DEFAULT)


def exploits(policies: Sequence[tuple[Path, sf.Policy, sf.Policy]], seeds: int) -> Iterator[str]:
    """Yield the rows of the first table: in training's physics, in ours, and how many survive elsewhere."""
    scores, survived = [], []
    for file, slow, fast in policies:
        name = file.stem
        for where, log in (_trained(slow, file), ("ours", walked(fast, 10.0))):
            row = gained(log)
            cells = " | ".join(f"{value:.3g}" for value in row.values())
            yield f"| {name} | {where} | {len(log) * log.fact('dt'):.0f} s | {cells} |"
        stood = {
            label: sum(walked(fast, SECONDS, k, **how).fact("outcome") == Ending.DONE for k in range(seeds))
            for label, how in ELSEWHERE.items()
        }
        yield f"| {name} | survived of {seeds} | {', '.join(f'{label}: {n}' for label, n in stood.items())} |"
        scores.append(row["symptoms"])
        survived.append(sum(stood.values()))
    if len(policies) > 2:
        rank = spearmanr(scores, survived).statistic
        yield f"rank correlation of score and survival: {rank:.2f} of {len(policies)} policies"


def guarded(policies: Sequence[tuple[Path, sf.Policy, sf.Policy]], seeds: int) -> Iterator[str]:
    """Yield the rows of the second table: with and without a guard."""
    for file, _, policy in policies:
        name = file.stem
        for label, how in GUARDED.items():
            for guard in (False, True):
                logs = [walked(policy, SECONDS, k, guard, **how) for k in range(seeds)]
                fell = sum(log.fact("outcome") != Ending.DONE for log in logs)
                late = [heading_velocity(log)[2000:, :2].mean(axis=0) for log in logs if len(log) > 2000]
                error = float(np.mean([np.linalg.norm(v - [SPEED, 0.0]) for v in late]))
                taken = [gained(log) for log in logs]
                slid, force = (np.mean([t[k] for t in taken]) for k in ("slid [m]", "largest force [m g]"))
                who = f"{'guard' if guard else 'alone'} | {fell} of {seeds}"
                yield f"| {name} | {label} | {who} | {error:.3f} | {slid:.2f} | {force:.1f} |"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("networks", nargs="+", type=Path)
    parser.add_argument(
        "--spec", action="append", type=Path, default=[], help="NETWORK's stem is this file's"
    )
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--guard", action="store_true")
    given = parser.parse_args(arguments)
    specs = {path.stem: path for path in given.spec}
    policies = []
    for n in given.networks:
        slow, fast = (
            sf.Policy(n, specs.get(n.stem), command=(SPEED, 0.0, 0.0), dt=dt, trust=True)
            for dt in (DEFAULT["dt"], 1e-3)
        )
        policies.append((n, slow, fast))
    table = guarded if given.guard else exploits
    for line in table(policies, given.seeds):
        print(line, flush=True)


if __name__ == "__main__":
    main()
