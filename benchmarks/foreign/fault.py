"""A seeded failure: what is changed in a run, and the truth about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from surefoot.records import Log

ModelHook = Callable[[Any, Any], None]
"""Called with model and data before a step, after the control."""


@dataclass(frozen=True)
class Fault:
    """What a failure is made of.

    Attributes
    ----------
    cause
        Its name, of `benchmarks.foreign.causes`.
    places
        Names of bodies, joints, actuators and geoms that count as right; none where any does.
    onset
        When it begins [s]; None for what is present from the start.
    settings
        Settings of the loop that differ.
    on_measured
        Called with time, qpos and qvel as measured, which it may change.
    on_step
        Called with model and data before each step.
    begins
        Whether it has begun, of model and data after a step: the first time that it has is the onset.
    on_log
        Returns the log as a user's logger would have written it.
    detail
        What was done, in words.
    """

    cause: str
    places: tuple[str, ...] = ()
    onset: float | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    on_measured: Callable[[float, Any, Any], None] | None = None
    on_step: ModelHook | None = None
    begins: Callable[[Any, Any], bool] | None = None
    on_log: Callable[[Log], Log] | None = None
    detail: str = ""


Draw = Callable[[np.random.Generator], Fault]
"""Draws a failure by its random numbers."""


@dataclass(frozen=True)
class Run:
    """A run and the truth about it.

    Attributes
    ----------
    loop, seed, attempt
        Where it is from; attempts before this one did not fail, or not by the fault.
    log
        As recorded.
    fault
        What was injected, None for a lawful control.
    onset
        When it began [s], None for what was present from the start.
    failure
        How the run failed, empty if its task was attained.
    failed_at
        When that was seen [s].
    """

    loop: str
    seed: int
    attempt: int
    log: Log
    fault: Fault | None
    onset: float | None
    failure: str
    failed_at: float
