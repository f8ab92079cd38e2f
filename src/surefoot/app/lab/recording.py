"""*plan* and *audit*: a motion that is known from end to end, to be scrubbed, and what an audit says."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefoot.app.lab import drawing as draw
from surefoot.app.lab.body import RobotBody
from surefoot.app.lab.contacts import contact_shapes, force_rows
from surefoot.app.lab.controls import Button, Checkbox, Choice, Control, Slider, Values
from surefoot.app.lab.drawing import Drawing, Shape
from surefoot.app.lab.figure import strip
from surefoot.app.lab.geometry import MovingGround
from surefoot.app.lab.html_text import heading, paragraph, text
from surefoot.app.lab.page import Page
from surefoot.app.lab.recorded_body import RecordedBody, can_draw
from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError, SurefootError
from surefoot.mechanics import FlatTerrain, Robot, Terrain, load_robot, read_terrain
from surefoot.motion.planning import Plan
from surefoot.records import Log
from surefoot.records.audit import AuditReport
from surefoot.records.log.snapshot import contact_names, frames_of, friction_of, pose_of, weight_of

WINDOW = 4.0
"""Length of the strip of forces around the cursor [s]."""
POINTS = 400
"""Most points of a curve."""
MOST_SPANS = 300
"""Violations that can be jumped to."""
NOWHERE = "-"
"""Of the list of violations: none is chosen."""


@dataclass(frozen=True)
class Span:
    """Something of a recording to jump to: its name, from when to when [s]."""

    name: str
    start: float
    end: float


class RecordedMotion:
    """A log with what is needed to draw it.

    Parameters
    ----------
    log
        With a row at least.
    robot
        Whose it is; None for the one that it names, if that is known.
    terrain
        Its ground; None for the one that it names, flat if it names none.

    Attributes
    ----------
    notes
        What cannot be drawn, a line each.
    stranger
        What draws the robot by the model that a recording keeps; None where another robot is drawn.
    most
        Largest normal force of the log, m g at least [N].

    Raises
    ------
    ProblemError
        For a log without rows, or times that do not rise.
    """

    def __init__(self, log: Log, robot: Robot | None = None, terrain: Terrain | None = None) -> None:
        if len(log) == 0:
            raise ProblemError("the log has no rows: there is nothing to show")
        self.log, self.time = log, np.asarray(log["time"], dtype=np.float64)
        if not np.isfinite(self.time).all() or (np.diff(self.time) <= 0.0).any():
            raise ProblemError(
                "the log's times do not rise: it cannot be scrubbed; `surefoot audit` says where"
            )
        self.notes: list[str] = []
        self.stranger = RecordedBody(log) if robot is None and can_draw(log) else None
        self.robot = self._robot_of() if robot is None and self.stranger is None else robot
        if self.robot is not None and ("q" not in log or log["q"].shape[1] != self.robot.model.nq):
            self.notes.append(f"the log's configurations are not those of {self.robot.name}: it is not drawn")
            self.robot = None
        ground = log.facts.get("terrain")
        self.terrain = terrain or (
            read_terrain(str(ground), "the log's terrain") if ground else FlatTerrain()
        )
        self.names, self.weight = contact_names(log), weight_of(log)
        self.pose = pose_of(log)
        self.most = self.weight
        if "forces" in log:
            normal = np.nan_to_num(np.asarray(log["forces"])[..., 2], posinf=0.0)
            self.most = max(self.weight, float(normal.max(initial=0.0)))
        if "forces" not in log or "contact_positions" not in log:
            self.notes.append("the log has no contact_positions with forces: no arrows and cones")

    def _robot_of(self) -> Robot | None:
        """Return the robot that the log names; None with a note if it is not known."""
        if "robot" not in self.log.facts:
            self.notes.append("the log names no robot: it is not drawn")
            return None
        try:
            return load_robot(str(self.log.fact("robot")))
        except SurefootError as error:
            self.notes.append(f"the robot is not drawn: {error}")
            return None

    @property
    def path(self) -> FloatArray:
        """(k, 2) places that it passes [m]; one at the origin where the log has none."""
        if self.pose is not None:
            places = np.asarray(self.pose[:, :2], dtype=np.float64)
        elif "contact_positions" in self.log:
            places = np.nan_to_num(np.asarray(self.log["contact_positions"])[:, :, :2].mean(axis=1))
        else:
            places = np.zeros((1, 2))
        finite = places[np.isfinite(places).all(axis=1)]
        return finite if len(finite) else np.zeros((1, 2))

    def row_at(self, time: float) -> int:
        """Return the row that holds at a time [s]."""
        return int(np.clip(np.searchsorted(self.time, time + 1e-9, side="right") - 1, 0, len(self.time) - 1))

    def strip(self, time: float, spans: Sequence[Span] = ()) -> str:
        """Return the normal forces around a time [s] as SVG, the spans shaded."""
        if "forces" not in self.log:
            return ""
        first = self.row_at(max(time - 0.5 * WINDOW, self.time[0]))
        last = self.row_at(self.time[first] + WINDOW) + 1
        first = min(first, self.row_at(self.time[last - 1] - WINDOW))
        thin = slice(first, last, max(1, (last - first) // POINTS))
        times, rows = self.time[thin], np.nan_to_num(np.asarray(self.log["forces"][thin, :, 2]), posinf=0.0)
        low, high = times[0], times[-1]
        marks = [(max(s.start, low), min(s.end, high)) for s in spans if s.end > low and s.start < high]
        return strip(times, rows, self.names, self.most, time, marks[:50])


class RecordingPage(Page):
    """The page of a recording.

    Parameters
    ----------
    recording
        That is scrubbed; pages may share it, they only read.
    title, head
        Heading, and what is said of the whole, a paragraph each.
    spans
        What can be jumped to.
    """

    about = "Move the **time**, or let it play. The camera goes with the robot."
    eye, look_at = (1.6, -1.6, 1.0), (0.0, 0.0, 0.2)

    def __init__(
        self, recording: RecordedMotion, title: str, head: Sequence[str] = (), spans: Sequence[Span] = ()
    ) -> None:
        self.title, self._head, self._recording = title, head, recording
        self._spans = tuple(spans[:MOST_SPANS])
        self._body = None if recording.robot is None else RobotBody(recording.robot)
        self._ground = MovingGround(recording.terrain, recording.path)
        self._played = clock.perf_counter()
        t = recording.time
        step = float(np.median(np.diff(t))) if len(t) > 1 else 1e-3
        end = float(t[-1]) if len(t) > 1 else float(t[0]) + step
        controls: list[Control] = [
            Slider("time", "time [s]", float(t[0]), end, step, float(t[0])),
            Checkbox("play", "play", False),
            Slider("speed", "speed", 0.05, 2.0, 0.05, 1.0, hint="1 is real time"),
            Button("back", "a row back", "Step"),
            Button("on", "a row on", "Step"),
        ]
        if self._spans:
            options = (NOWHERE, *(span.name for span in self._spans))
            controls.append(Choice("jump", "jump to", options, NOWHERE, "Violations"))
        self.values = Values(controls)

    @property
    def live(self) -> bool:  # type: ignore[override]
        """Whether it plays."""
        return bool(self.values["play"])

    @property
    def row(self) -> int:
        """The row that is shown."""
        return self._recording.row_at(self.values["time"])

    def change(self, name: str, raw: object) -> None:
        """Take a value; a violation that is chosen is gone to, playing begins now."""
        super().change(name, raw)
        if name == "jump" and raw != NOWHERE:
            self.values.within("time", next(s.start for s in self._spans if s.name == raw))
            self.values.change("play", False)
        if name == "play":
            self._played = clock.perf_counter()
            if raw and self.row == len(self._recording.time) - 1:
                self.values.within("time", self._recording.time[0])

    def press(self, name: str) -> None:
        """Step by a row."""
        if name not in ("back", "on"):
            super().press(name)
        time, row = self._recording.time, self.row + (1 if name == "on" else -1)
        self.values.within("time", time[min(max(row, 0), len(time) - 1)])

    def _play(self) -> None:
        """Let the time go on as the clock does."""
        now = clock.perf_counter()
        passed, self._played = now - self._played, now
        if self.live:
            self.values.within("time", self.values["time"] + passed * self.values["speed"])
            if self.values["time"] >= self._recording.time[-1]:
                self.values.change("play", False)

    def drawing(self) -> Drawing:
        """Return what there is to see now."""
        self._play()
        rec, row, now = self._recording, self.row, self.values["time"]
        head = [heading(f"{now:.3f} s, row {row} of {len(rec.time)}"), *map(paragraph, self._head)]
        broken = [s.name for s in self._spans if s.start - 1e-9 <= now <= s.end + 1e-9]
        head += [paragraph(name, "font-weight: bold;") for name in broken[:5]]
        if "forces" in rec.log:
            mu, forces = friction_of(rec.log, row), np.asarray(rec.log["forces"][row], dtype=np.float64)
            head.append(force_rows(rec.names, np.nan_to_num(forces), mu))
        words = text(*head, *map(paragraph, rec.notes))
        return Drawing(self.shapes(), words, rec.strip(now, self._spans))

    def shapes(self) -> dict[str, Shape]:
        """Return ground, robot, forces and push of the row that is shown."""
        rec, row = self._recording, self.row
        origin = self._origin(row)
        shapes: dict[str, Shape] = {**self._ground.shapes(origin), **self._robot(row, origin)}
        if "forces" in rec.log and "contact_positions" in rec.log:
            mu, forces = friction_of(rec.log, row), np.asarray(rec.log["forces"][row], dtype=np.float64)
            places = np.asarray(rec.log["contact_positions"][row]) - [*origin, 0.0]
            shapes |= contact_shapes(rec.names, places, frames_of(rec.log, row), forces, mu, rec.weight)
        push = np.asarray(rec.log["push"][row]) if "push" in rec.log else np.zeros(3)
        if push.any() and np.isfinite(push).all() and rec.pose is not None:
            vector, at = push / rec.weight, np.asarray(rec.pose[row, :3]) - [*origin, 0.0]
            shapes["/push"] = draw.arrow_at(at - vector, vector, draw.PUSH, 0.015)
        return shapes

    def _origin(self, row: int) -> FloatArray:
        """Return the (2,) place that is in the middle of the picture [m]."""
        rec = self._recording
        if rec.pose is not None and np.isfinite(rec.pose[row, :2]).all():
            return np.array(rec.pose[row, :2], dtype=np.float64)
        return np.asarray(rec.path[0])

    def _robot(self, row: int, origin: FloatArray) -> dict[str, Shape]:
        """Return the robot, or its base as three axes where it is not known."""
        rec = self._recording
        if self._body is not None:
            q = np.array(rec.log["q"][row], dtype=np.float64)
            if not np.isfinite(q).all():
                return {}
            if self._body.robot.floating:
                q[:2] -= origin
            return self._body.shapes(q)
        if rec.stranger is not None:
            q = np.asarray(rec.log["q"][row], dtype=np.float64)
            return rec.stranger.shapes(q, origin) if np.isfinite(q).all() else {}
        if rec.pose is None or not np.isfinite(rec.pose[row]).all():
            return {}
        place = np.asarray(rec.pose[row, :3]) - [*origin, 0.0]
        return {"/robot/base": draw.Ball(place, 0.05, draw.BODY)}


def audit_page(recording: RecordedMotion, report: AuditReport) -> RecordingPage:
    """Return the page of a log with its audit."""
    spans = [
        Span(f"{k}. {v.law}, {v.contact}, {v.start:.3f} s", v.start, max(v.end, v.start))
        for k, v in enumerate(report.violations[:MOST_SPANS], 1)
    ]
    rest = len(report.violations) + sum(report.more.values()) - len(spans)
    head = [report.sentence, *([f"{rest} violations more are not listed."] if rest > 0 else [])]
    return RecordingPage(recording, f"Audit: {report.verdict}", head, spans)


def plan_page(recording: RecordedMotion, plan: Plan) -> RecordingPage:
    """Return the page of a plan."""
    head = [
        f"{plan.status.value}, {plan.method}; {plan.facts['goal']}; law residual {plan.law_residual:.1e}.",
        "Forces act until the next knot.",
    ]
    return RecordingPage(recording, f"Plan: {plan.task}", head)
