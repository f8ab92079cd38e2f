"""Motions that a controller executed in MuJoCo: walks of the G1 made on the fly, and files that are given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import surefoot as sf
from surefoot.motion.walking.walkers import walking_controller
from surefoot.records.motions.motion import Motion

COMMANDS = (
    (0.5, 0.0, 0.0), (0.0, 0.0, 0.5), (0.0, 0.2, 0.0), (-0.3, 0.0, 0.0), (0.8, 0.0, 0.0), (0.3, 0.1, 0.3),
    (0.0, 0.0, 0.0), (0.2, 0.0, -0.4),
)  # fmt: skip
"""Velocities of the walks: forward, left [m/s], turning [rad/s]."""
STORED = 100.0
"""Frames of a recording per second [Hz]."""


def walks(robot: sf.Robot, count: int, duration: float) -> Iterator[Motion]:
    """Yield so many walks of a length [s] in MuJoCo, friction 0.6."""
    for seed, command in enumerate(COMMANDS[:count], 1):
        walker = walking_controller(robot, sf.VelocityCommand.constant(*command))
        log = sf.run(sf.MujocoWorld(robot, mu=0.6), walker, sf.Scenario(duration, mu=0.6, seed=seed))
        every = max(round(1.0 / (STORED * float(log.facts["dt"]))), 1)
        q = np.ascontiguousarray(log["q"][::every])
        name = "walk " + ",".join(f"{x:g}" for x in command)
        yield Motion(robot, q, 1.0 / (every * float(log.facts["dt"])), name)


def files(robot: sf.Robot, paths: Sequence[Path]) -> Iterator[Motion]:
    """Yield executed motions of files, as `read_motion` knows them."""
    for path in paths:
        from surefoot.records.motions.read_motion import read_motion

        yield read_motion(path, robot)
