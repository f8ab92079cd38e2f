"""Runs of a Go2 in the rigid world in which something of the robot as a whole is changed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from benchmarks.limit_cases.verdict import CleanLogs, Verdict, audited, breaks, named
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log

TROT, STAND = 10, 11
"""Numbers of the clean runs."""


def robot_cases(logs: CleanLogs) -> Iterator[Verdict]:
    """Yield the cases of robots."""
    trot, stand = logs(TROT), logs(STAND)
    weight = float(trot.fact("mass")) * GRAVITY
    yield from _states(trot)
    pushed = _copy(trot)
    pushed["push"][400:430] = [3.0 * weight, 0.0, 0.0]
    why = "the log tells of a kick of 30 ms that there was not: no jump from one row to the next"
    yield named("a kick of 3 m g", why, _log(trot, pushed), "outside force")
    leash = _copy(stand)
    leash["push"][:] = [0.1 * weight, 0.0, -0.1 * weight]
    why = "a leash at 45 degrees holds a tenth of the weight"
    yield named("a leash", why, _log(stand, leash), "outside force")
    for share, judged, why in (
        (4e-4, True, "masses are told with three digits"),
        (0.06, False, "a payload of a kilogramme"),
    ):
        log = _log(stand, _copy(stand), kind="recording", mass=float(stand.fact("mass")) * (1.0 + share))
        name = f"a recording whose mass is {share:g} beside the model's"
        yield audited(name, why, log, lambda r, judged=judged: (not r.coverage["motion"]) is judged)  # type: ignore[misc]
    silent = _copy(stand)
    part = slice(300, 550)
    silent["forces"][part] = 0.0
    silent["gaps"][part] = 3e-4
    why = "forces that were never read; feet whose gap encoders of 1 mrad on 0.3 m tell: 0.3 mm"
    yield named("a stand without forces", why, _log(stand, silent), "no forces")
    joints = stand["torques"].shape[1]
    why = "gears of 5 N m take all of it from joints that swing, and the log's torques lack it"
    moving = _log(trot, _copy(trot), dry_friction=np.full(joints, 5.0))
    yield breaks("gears whose friction is not in the torques", why, moving, "motion")


def _states(trot: Log) -> Iterator[Verdict]:
    held = _copy(trot)
    for name, array in held.items():
        if name != "time":
            array[400:415] = array[400]
    yield named("fifteen rows held", "a bus that is silent for 15 ms", _log(trot, held), "held rows")
    reset = _copy(trot)
    for name, array in reset.items():
        if name != "time":
            array[400] = array[399]
    reset["q"][401:, :2] += 0.015
    reset["contact_positions"][401:, :, :2] += 0.015
    why = "a reset writes its first row twice, 2 cm aside"
    yield named("a reset whose row comes twice", why, _log(trot, reset), "teleport")


def _copy(log: Log) -> dict[str, Any]:
    return {name: np.array(array) for name, array in log.arrays.items()}


def _log(clean: Log, arrays: dict[str, Any], **facts: Any) -> Log:
    return Log(arrays, {**clean.facts, **facts}, channels=clean.channels)
