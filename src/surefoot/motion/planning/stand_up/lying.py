"""The plan of postures: its exact rollout as a log, with the postures that a controller executes."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.contact import Status
from surefoot.mechanics import FlatTerrain
from surefoot.motion.planning.plan import Plan, PlanSearch, plan_channels, plan_facts
from surefoot.motion.planning.stand_up.forward import RigidModel
from surefoot.motion.planning.stand_up.posture_sequence import Postures
from surefoot.motion.planning.trajectory import TOLERANCE

STANDS_UP, STANDS_HIGH = math.cos(math.radians(10.0)), 0.9
"""A robot has got up if its vertical axis leans less than 10 degrees and it has this share of its height."""

STOP = 0.02
"""Most that a joint may go beyond its range [rad]."""


def upright(q: FloatArray) -> float:
    """Return the vertical part of the own vertical axis of (nq,) q, 1 upright to -1 on the back."""
    return 1.0 - 2.0 * float(q[3] ** 2 + q[4] ** 2)


def beyond(angles: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Return by how much (joints,) angles are at most beyond their range [rad]; rigid steps have no stops."""
    return max(float((low - angles).max()), float((angles - high).max()), 0.0)


def lying_plan(model: RigidModel, law: Postures, start: FloatArray, search: PlanSearch) -> Plan:
    """Roll postures out from a start (nq,) and return the plan; SOLVED if it gets up, lawfully.

    Parameters
    ----------
    model
        Exact rigid steps with all contacts.
    law
        The postures.
    start
        (nq,) lying.
    search
        How they were found.
    """
    robot = model.robot
    model.reset(start)
    steps = round(law.duration / model.dt)
    rows: list[dict[str, Any]] = []
    for k in range(steps):
        q, v = model.q_v()
        torques = law.torques(law.at(k * model.dt, start[7:]), q[7:], v[6:])
        model.step(torques)
        rows.append({"q": q.copy(), "v": v.copy(), "torques": torques, **model.row()})
    q, v = model.q_v()
    arrays: dict[str, Any] = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    lean, height = upright(q), float(q[2]) / float(robot.nominal[2])
    ends = robot.model.lowerPositionLimit[7:], robot.model.upperPositionLimit[7:]
    over = max(beyond(row, *ends) for row in arrays["q"][:, 7:])
    reached = lean > STANDS_UP and height > STANDS_HIGH and over <= STOP
    lawful = model.unsolved == 0 and model.worst_residual <= TOLERANCE
    status = (Status.SOLVED if reached else Status.STALLED) if lawful else Status.STALLED
    tilt = math.degrees(math.acos(min(max(lean, -1.0), 1.0)))
    goal = (
        f"stand up: {tilt:.1f} deg off, {height:.2f} of its height, joints {over:.3f} rad beyond their range"
    )
    found = replace(search, reached=reached, goal=goal)
    facts = plan_facts(robot, found, status, model.worst_residual, (model.dt, model.mu), (q, v))
    facts["world"] = "rigid steps with all links"
    channels = plan_channels(arrays, (model.dt, model.mu), FlatTerrain(), law.effort)
    return Plan(channels, {**facts, **law.facts})
