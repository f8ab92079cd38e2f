"""What a fit to tosses pays for each of them: CPU time of a simulated throw, ours and the rivals'.

A fit simulates every toss a thousand times. The throws are made up, a cube's and those of two bars on a hinge
that gives; each simulator runs on one thread with its own steps and the values where its search begins.

    python -m benchmarks.toss_speed
    python -m benchmarks.toss_speed --tosses 100 --repeats 9
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks.printing import show, table
from benchmarks.problems.tosses import ELBOW, random_scene
from benchmarks.timing import one_core
from surefoot.base.errors import MissingExtra
from surefoot.records.identification.thrown_body import ThrownBody, cube_body, thrown_body
from surefoot.records.identification.toss_model import LAWS, ThrownModel, TossModel, TossScene
from surefoot.records.identification.tosses import Cube
from surefoot.worlds.experiments.tosses import RIVALS, rival

COMPLIANCE = 0.014
"""Of the elbow's hinge across its axis [rad/(N m)], about what the shared throws tell."""
FRAMES = 110
"""Of a throw, at 148 a second."""


class Price(NamedTuple):
    """CPU time of a throw [s]: median and largest over the repeats."""

    body: str
    model: str
    median: float
    worst: float


def bodies() -> dict[str, ThrownBody]:
    """Return what is thrown, by name."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "elbow.urdf"
        path.write_text(ELBOW)
        elbow = thrown_body(path)
    return {"cube": cube_body(Cube()), "elbow": elbow.at({"compliance_hinge": COMPLIANCE})}


def models() -> Iterator[TossModel]:
    """Yield our laws and the rivals that are installed."""
    yield from (ThrownModel(law) for law in LAWS)
    for name in RIVALS:
        try:
            yield rival(name)
        except MissingExtra:
            continue


def time_throws(model: TossModel, scene: TossScene, repeats: int) -> list[float]:
    """Return the CPU time of each simulation of a scene's throws [s], the first one apart."""
    values = np.array([p.start for p in model.parameters])
    model.rollout(values, scene)
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        model.rollout(values, scene)
        seconds.append((time.process_time() - begin) / len(scene.starts))
    return seconds


def measure(count: int, repeats: int) -> list[Price]:
    """Return what a throw costs in each simulator."""
    rows = []
    for name, body in bodies().items():
        scene = random_scene(np.random.default_rng(0), count, (0.0, 0.0, 0.0), FRAMES, 1.0 / 148.0, body)
        for model in models():
            seconds = time_throws(model, scene, repeats)
            rows.append(Price(name, model.name, float(np.median(seconds)), max(seconds)))
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--tosses", type=int, default=50, help="throws in a simulation")
    parser.add_argument("--repeats", type=int, default=9, help="simulations that are timed")
    given = parser.parse_args(arguments)
    with one_core():
        prices = measure(given.tosses, given.repeats)
    first = {one.body: one.median for one in prices if one.model == "rigid"}
    rows = [
        (one.body, one.model, f"{1e3 * one.median:.2f}", f"{1e3 * one.worst:.2f}",
         f"{one.median / first[one.body]:.2f}")
        for one in prices
    ]  # fmt: skip
    header = "thrown", "simulator", "median [ms]", "largest [ms]", "over rigid"
    show([table(header, rows, f"CPU time of a throw of {FRAMES} frames", left=2)])


if __name__ == "__main__":
    main()
