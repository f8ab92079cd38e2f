"""Stands whose command is known: what was asked for, what came of it, and how the run ended."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from benchmarks.limit_cases.made import Made
from benchmarks.limit_cases.verdict import Verdict, asked, obeyed
from surefoot.base.spatial import rotation_about
from surefoot.records.audit.command_tracking import judge_task
from surefoot.records.audit.limits import AuditLimits
from surefoot.records.log import Log

ROWS = 1000


def command_cases() -> Iterator[Verdict]:
    """Yield the cases of commands."""
    yield from _pauses()
    yield from _impossible()
    yield from _torques()
    yield from _answers()
    yield from _endings()
    yield from _quaternions()


def commanded() -> Made:
    """Return a stand that is as it was commanded."""
    made = Made(ROWS)
    made.forces[..., 0] = 0.2 * made.forces[..., 2]
    made.more["forces_commanded"] = made.forces.copy()
    made.more["active"] = np.ones((ROWS, 4), dtype=bool)
    made.more["attained"] = np.ones(ROWS, dtype=bool)
    return made


def _pauses() -> Iterator[Verdict]:
    for rows, gap, right, why in (
        (15, 0.0, True, "a trot's touchdown that comes 15 ms late"),
        (200, 3e-4, False, "feet whose gap is measured by encoders of 1 mrad on 0.3 m: 0.3 mm"),
        (400, 0.02, True, "a hop over 2 cm: nothing to push from"),
    ):
        made = commanded()
        part = slice(300, 300 + rows)
        made.gaps[:] = gap if not right and gap else 0.0
        made.more["active"][part], made.more["forces_commanded"][part] = False, 0.0
        if gap:
            made.gaps[part] = gap
            made.forces[part] = 0.0
        how = obeyed if right else asked
        yield how(
            f"no foot is asked for {rows} ms at a gap of {1e3 * gap:g} mm", why, made.log(), "no forces"
        )


def _impossible() -> Iterator[Verdict]:
    for rows, every, right, why in (
        (30, 0, True, "the blow of a landing asks for more than cones have, for 30 ms"),
        (300, 40, False, "a motion that is impossible for 0.3 s, but for rows at which a solver gives up"),
        (600, 2, True, "a program at the edge of its cone: every other row fails by rounding"),
    ):
        made = commanded()
        lost = np.zeros(ROWS, dtype=bool)
        lost[300 : 300 + rows] = True
        if every:
            lost[::every] = False
        made.more["attained"] = ~lost
        how = obeyed if right else asked
        yield how(f"impossible for {rows} ms, not in 1 of {every or rows}", why, made.log(), "infeasible")


def _torques() -> Iterator[Verdict]:
    for off, right, why in (
        (0.02, True, "a motor's torque constant is known to 2 %"),
        (0.25, False, "a gearbox of another ratio: 1 : 8 for 1 : 6.33"),
    ):
        made = commanded()
        made.more["torques_commanded"] = np.full((ROWS, 12), 10.0)
        made.more["torques"] = np.full((ROWS, 12), 10.0 * (1.0 - off))
        how = obeyed if right else asked
        name = f"torques {100 * off:g} % beside the command"
        yield how(name, why, made.log(), "torques not applied")


def _answers() -> Iterator[Verdict]:
    turned = commanded()
    turned.forces = turned.more["forces_commanded"] @ rotation_about(np.array([0.0, 1.0, 0.0]), 0.35).T
    turned.mu[:] = 2.0
    yield asked("forces turned by 20 deg", "a frame that leans as a slope does", turned.log(), "wrong frame")
    mixed = commanded()
    asked_for = mixed.more["forces_commanded"]
    turn = rotation_about(np.array([0.0, 1.0, 0.0]), 0.35)
    mixed.forces = asked_for @ turn.T + [0.0, 0.3, 0.3] * np.linalg.norm(asked_for, axis=-1)[..., None]
    mixed.mu[:] = 3.0
    why = "half of what is amiss is a frame, half is none: a frame alone would mend half of it"
    yield asked("a turn and as much that is none", why, mixed.log(), "not as commanded")
    scaled = commanded()
    scaled.forces = 1.4 * scaled.more["forces_commanded"] @ rotation_about(np.array([0.0, 1.0, 0.0]), 5e-3).T
    yield asked(
        "1.4 times the command", "a wrong gain, and 0.3 deg of a mount", scaled.log(), "not as commanded"
    )


def _endings() -> Iterator[Verdict]:
    for lean, height, right, why in (
        (30.0, 1.0, True, "up a slope of 30 degrees, the steepest a quadruped walks"),
        (80.0, 1.0, False, "on its side"),
        (0.0, 0.6, True, "a crouch: two thirds of a leg's length"),
        (0.0, 0.25, False, "on its belly: the trunk's half height of 8 cm"),
    ):
        log = _ended(lean, height)
        name = f"it ends {lean:g} deg over, {height:g} of its height"
        yield Verdict(name, why, partial(_attained, log, right))


def _attained(log: Log, right: bool, limits: AuditLimits) -> bool:
    return (judge_task(log, limits)[0] == "attained") is right


def _ended(lean: float, height: float) -> Log:
    count = 100
    q, v = np.zeros((count, 7)), np.zeros((count, 6))
    half = 0.5 * np.radians(np.linspace(0.0, lean, count))
    q[:, 3], q[:, 6], q[:, 2] = np.sin(half), np.cos(half), 0.3 * np.linspace(1.0, height, count)
    arrays = {"time": 2e-3 * np.arange(count), "q": q, "v": v, "contact_positions": np.zeros((count, 4, 3))}
    return Log(arrays, {"outcome": "done"})


def _quaternions() -> Iterator[Verdict]:
    """Yield a free base that falls over, its quaternion printed to three digits."""
    log = _ended(80.0, 1.0)
    q = np.array(log["q"])
    q[:, 3:7] = q[:, 3:7].round(4) * (1.0 + 3e-5)
    printed = Log({**log.arrays, "q": q}, log.facts)
    why = "a quaternion printed to four digits has a length of one to 1e-4"
    yield Verdict("it lies, by a printed quaternion", why, partial(_attained, printed, False))
