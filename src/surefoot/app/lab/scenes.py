"""Answers as scenes of other viewers: what to draw when, in shapes that no viewer knows of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.contacts import BROKEN, CONE_HEIGHT, WEIGHT_LENGTH
from surefoot.app.lab.drawing import Shape
from surefoot.app.lab.geometry import SIDES, cone_surface, fan
from surefoot.app.lab.recording import RecordedMotion, RecordingPage
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.mechanics import Robot, Terrain, Verdict
from surefoot.mechanics.stance import SoleContact, Stance
from surefoot.records import Log
from surefoot.records.motions.motion import Motion

RATE = 30.0
"""Pictures a second of a scene of a log, as many as films have [Hz]."""

Frame = tuple[float, Mapping[str, Shape]]
"""A time [s], and the shapes by name that are there from then on."""


def frames_of(answer: Any, robot: Robot | None = None, terrain: Terrain | None = None) -> Iterator[Frame]:
    """Yield what there is to see of an answer, in the order of time; of a stance or a verdict one frame.

    Parameters
    ----------
    answer
        A log, a plan, a motion, a stance or a verdict.
    robot, terrain
        Of a log that does not name its own.

    Raises
    ------
    ProblemError
        For what is none of these.
    """
    if isinstance(answer, Motion):
        log = Log({"time": answer.times, "q": np.asarray(answer.q)}, {"robot": answer.robot.name})
        yield from _rows(log, answer.robot, terrain)
    elif isinstance(answer, Log):
        yield from _rows(answer, robot, terrain)
    elif isinstance(answer, Verdict):
        yield (
            0.0,
            _stance(answer.stance, answer.by_contact(), float(np.linalg.norm(answer.load[:3])))
            | _centre(answer),
        )
    elif isinstance(answer, Stance):
        yield 0.0, _stance(answer, [], 0.0)
    else:
        raise ProblemError(f"scenes are of logs, plans, motions, stances and verdicts, got {shown(answer)}")


class _InPlace(RecordingPage):
    """A recording in world axes: the ground does not pass below the robot."""

    def _origin(self, row: int) -> FloatArray:
        return np.zeros(2)


def _rows(log: Log, robot: Robot | None, terrain: Terrain | None) -> Iterator[Frame]:
    """Yield the rows of a log that are `RATE` a second."""
    page = _InPlace(RecordedMotion(log, robot, terrain), "scene")
    times = np.asarray(log["time"], dtype=np.float64)
    wanted = np.arange(times[0], times[-1] + 0.5 / RATE, 1.0 / RATE)
    rows = np.unique(np.clip(np.searchsorted(times, wanted), 0, len(times) - 1))
    for row in rows.tolist():
        page.values.within("time", float(times[row]))
        yield float(times[row] - times[0]), page.shapes()


def _stance(stance: Stance, forces: list[FloatArray], weight: float) -> dict[str, Shape]:
    """Return cones, soles and names of a stance's contacts, and the forces where there are any."""
    out: dict[str, Shape] = {}
    for k, contact in enumerate(stance):
        name, place = contact.name or str(k), contact.position
        x, y, z = place.tolist()
        surface = cone_surface(contact.mu, CONE_HEIGHT, contact.rotation_world_contact)
        out[f"/cones/{name}"] = draw.Mesh(surface, fan(SIDES), draw.CONE, 0.35, (x, y, z))
        out[f"/names/{name}"] = draw.Label(place + 0.05 * contact.normal, name)
        if isinstance(contact, SoleContact):
            corners = np.array([corner.position for corner in contact.corners()])
            out[f"/soles/{name}"] = draw.outline(corners, draw.INK)
        if forces:
            force, R = forces[k], contact.rotation_world_contact
            outside = np.hypot(*force[:2]) > contact.mu * force[2] * (1.0 + BROKEN)
            if len(force) == 6 and force[2] > 0.0:
                place = place + R @ np.array([-force[4], force[3], 0.0]) / force[2]
            vector = R @ force[:3] * (WEIGHT_LENGTH / max(weight, 1e-300))
            out[f"/forces/{name}"] = draw.arrow_at(place, vector, draw.BAD if outside else draw.FORCE)
    return out


def _centre(verdict: Verdict) -> dict[str, Shape]:
    """Return the centre of mass, in the colour of the verdict."""
    return {"/com": draw.Ball(verdict.com, 0.03, draw.GOOD if verdict.feasible else draw.BAD)}
