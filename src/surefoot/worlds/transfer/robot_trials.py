"""Runs of one of our robots under one of our controllers, in any of our worlds."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from surefoot.base.errors import ProblemError
from surefoot.mechanics import FlatTerrain, Robot, place
from surefoot.records import Ending, Log
from surefoot.worlds.interface.world_names import WORLDS, make_world
from surefoot.worlds.running.run import run
from surefoot.worlds.running.scenario import Scenario
from surefoot.worlds.transfer.trial import TrialRun
from surefoot.worlds.transfer.variants import Variant

STEP = 1e-3
"""Of the worlds [s]."""
FRICTION = 0.6
"""Of the ground before it is changed."""
STIFF_STEPS = 2.0
"""Time constant of MuJoCo's stiffest contact, in steps: the least that it takes."""
LENGTH = 4.0
"""Of a run where none is said [s]."""


class RobotTrials:
    """Runs of a robot on flat ground, each from the same pose but for its seed."""

    engines = tuple(WORLDS)

    def __init__(
        self, robot: Robot, control: Any, duration: float | None, start: Any,
        success: Callable[[Log], Any] | None,
    ) -> None:  # fmt: skip
        if not (callable(control) or hasattr(control, "step")):
            raise ProblemError(f"{robot.name} takes a controller, as sf.Policy, got {type(control).__name__}")
        self._robot, self._control, self._success = robot, control, success
        self._duration = LENGTH if duration is None else duration
        self._start = place(robot, None, getattr(control, "posture", None)) if start is None else start

    def run(self, variant: Variant, seed: int) -> TrialRun:
        """Return a run in a world."""
        mu, step = FRICTION * variant.friction, STEP
        options: dict[str, Any] = {}
        if variant.stiff:
            options["solref"] = (STIFF_STEPS * (0.5 if variant.halved else 1.0) * step, 1.0)
        world: Any = make_world(variant.engine, self._robot, FlatTerrain(), mu, dt=step, **options)
        if variant.halved:
            if not hasattr(world, "divide"):
                raise ProblemError(f"half-step is of the worlds mujoco and mujoco-exact, got {variant.name}")
            world.divide(2)
        scenario = Scenario(self._duration, mu, seed=seed, start=self._start)
        log = run(world, self._control, scenario)
        good = log.facts["outcome"] == Ending.DONE if self._success is None else self._success(log)
        forces, foot = np.asarray(log["forces"]), world.contact_foot
        names = [self._robot.feet[f].name for f in foot.tolist()]
        of_feet = {
            name: forces[:, [k for k, n in enumerate(names) if n == name]].sum(axis=1)
            for name in dict.fromkeys(names)
        }
        soft = int(log.facts.get("unsolved_steps", 0))
        return TrialRun(bool(good), np.asarray(log["time"]), np.asarray(log["q"]), of_feet, soft)
