"""Experiments that end in every way there is; in a file of their own, so that workers can import them."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from surefoot.base.errors import SimulationError
from surefoot.worlds.sweep import NumberRange, Space, SweepConfig, SweepExperiment, number


@dataclass(frozen=True)
class Deadly(SweepExperiment):
    """Kills its worker, raises, or returns its mu; every run leaves a line in a file."""

    columns: ClassVar[Mapping[str, str]] = {"survived": "bool", "twice": "float"}

    mu: float = number(0.0, 0.0, 1.0)
    killers: tuple[int, ...] = ()
    failing: tuple[int, ...] = ()
    broken: tuple[int, ...] = ()
    seen: str = ""
    seconds: float = 0.0

    def run(self, seed: int) -> dict[str, Any]:
        index = INDICES[seed]
        if self.seen:
            with Path(self.seen).open("a") as stream:
                stream.write(f"{index}\n")
        time.sleep(self.seconds)
        if index in self.killers:
            os.kill(os.getpid(), signal.SIGKILL)
        if index in self.failing:
            raise SimulationError("motion", 0.1, 1e-3, "knee", 1e9)
        if index in self.broken:
            raise ZeroDivisionError("a bug")
        return {"survived": self.mu > 0.5, "twice": 2.0 * self.mu}


INDICES = {sample.seed: sample.index for s in (0, 1) for sample in Space({}, s).sample(range(256))}
"""Which sample a seed is of, in the sweeps of `deadly`."""


def deadly(samples: int = 20, seed: int = 0, **settings: Any) -> SweepConfig:
    """Return a sweep of `Deadly` over mu from 0 to 1."""
    return SweepConfig("deadly", Deadly(**settings), Space({"mu": NumberRange(0.0, 1.0)}, seed), samples)
