"""Runs of a Go2 in the rigid world in which something of the robot as a whole is changed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.limit_cases.made import arrays_of, changed_log
from benchmarks.limit_cases.verdict import STAND, TROT, CleanLogs, Verdict, audited, breaks, named
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log


def robot_cases(logs: CleanLogs) -> Iterator[Verdict]:
    """Yield the cases of robots."""
    trot, stand = logs(TROT), logs(STAND)
    weight = float(trot.fact("mass")) * GRAVITY
    yield from _states(trot)
    pushed = arrays_of(trot)
    pushed["push"][400:430] = [3.0 * weight, 0.0, 0.0]
    why = "the log tells of a kick of 30 ms that there was not: no jump from one row to the next"
    yield named("a kick of 3 m g", why, changed_log(trot, pushed), "outside force")
    leash = arrays_of(stand)
    leash["push"][:] = [0.1 * weight, 0.0, -0.1 * weight]
    why = "a leash at 45 degrees holds a tenth of the weight"
    yield named("a leash", why, changed_log(stand, leash), "outside force")
    for share, judged, why in (
        (4e-4, True, "masses are told with three digits"),
        (0.06, False, "a payload of a kilogramme"),
    ):
        log = changed_log(
            stand, arrays_of(stand), kind="recording", mass=float(stand.fact("mass")) * (1.0 + share)
        )
        name = f"a recording whose mass is {share:g} beside the model's"
        yield audited(name, why, log, lambda r, judged=judged: (not r.coverage["motion"]) is judged)  # type: ignore[misc]
    silent = arrays_of(stand)
    part = slice(300, 550)
    silent["forces"][part] = 0.0
    silent["gaps"][part] = 3e-4
    why = "forces that were never read; feet whose gap encoders of 1 mrad on 0.3 m tell: 0.3 mm"
    yield named("a stand without forces", why, changed_log(stand, silent), "no forces")
    joints = stand["torques"].shape[1]
    why = "gears of 5 N m take all of it from joints that swing, and the log's torques lack it"
    moving = changed_log(trot, arrays_of(trot), dry_friction=np.full(joints, 5.0))
    yield breaks("gears whose friction is not in the torques", why, moving, "motion")


def _states(trot: Log) -> Iterator[Verdict]:
    held = arrays_of(trot)
    for name, array in held.items():
        if name != "time":
            array[400:415] = array[400]
    yield named("fifteen rows held", "a bus that is silent for 15 ms", changed_log(trot, held), "held rows")
    reset = arrays_of(trot)
    for name, array in reset.items():
        if name != "time":
            array[400] = array[399]
    reset["q"][401:, :2] += 0.015
    reset["contact_positions"][401:, :, :2] += 0.015
    why = "a reset writes its first row twice, 2 cm aside"
    yield named("a reset whose row comes twice", why, changed_log(trot, reset), "teleport")
