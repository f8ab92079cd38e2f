"""An episode of a MuJoCo loop, recorded and judged: one report each."""

from __future__ import annotations

import weakref
from collections.abc import Collection
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.records import BatchReport, join_reports, judge_contacts, report_no_touch
from surefoot.worlds.mujoco.episode.contact_recorder import ContactRecorder
from surefoot.worlds.mujoco.episode.step_watch import WATCH

NOT_WHOLE = "its first steps were not seen"
TURNED = "the state was reset in the middle of the episode"


class EpisodeAudit:
    """Records the contacts of a data from `begin` on, and judges them at `finish`.

    Parameters
    ----------
    mujoco, model, data
        The module and its own.
    robot
        See `surefoot.record`.
    """

    def __init__(self, mujoco: Any, model: Any, data: Any, robot: str | None = None) -> None:
        self.recorder = ContactRecorder(mujoco, model, data, robot)
        self._close = weakref.finalize(self, WATCH.remove, self.recorder)
        self._whole = float(data.time) == 0.0
        self._begun = float(data.time)
        self._earned: list[tuple[int, float]] = []
        self._judged: list[BatchReport] = []
        WATCH.add(self.recorder)

    def of(self, model: Any, data: Any) -> bool:
        """Return whether it records this data."""
        return data is self.recorder.data and model is self.recorder.model

    @property
    def rows(self) -> int:
        """Rows of the episode so far."""
        return (
            self.recorder.count + sum(map(len, self.recorder.parts)) + sum(one.rows for one in self._judged)
        )

    def pause(self) -> None:
        """Take note of no step until `begin`."""
        self.recorder.paused = True

    def begin(self) -> None:
        """Begin an episode in the data's present state."""
        self.recorder.paused = False
        self.recorder.begin()
        self._begun, self._whole, self._earned, self._judged = self.recorder.last, True, [], []

    def earn(self, reward: float) -> None:
        """Note what the last step of the environment was paid, and see that all of its time was seen."""
        recorder = self.recorder
        moved = recorder.data.time - recorder.last
        if moved > 0.0:  # steps that C made by itself: what the data holds is the last of them
            recorder.take(moved)
            recorder.missed += 1
        self._earned.append((recorder.count, reward))
        if recorder.full:
            recorder.part()
        if recorder.parts:
            self._judge_parts()

    def finish(self) -> tuple[BatchReport, float]:
        """Return the report of the episode, and which share of its steps was judged; forget it."""
        recorder = self.recorder
        elapsed, rows, turned = recorder.last - self._begun, self.rows, recorder.turned
        report: BatchReport | None = None
        if not (turned or recorder.parts or self._judged):
            step = float(recorder.model.opt.timestep)
            report = (
                recorder.prove(self._unsure, lambda: self._rewards(rows))
                if recorder.touched
                else report_no_touch(rows, step)
            )
        if report is None:
            held = recorder.held if recorder.count else ()
            recorder.part()
            self._judge_parts(held)
            report = join_reports(self._judged)
        step = float(recorder.model.opt.timestep)
        rate = (
            min(1.0, rows * step / elapsed) if elapsed > 0.0 and not turned else float(recorder.missed == 0)
        )
        self.begin()
        return report, rate

    @property
    def _unsure(self) -> str:
        """Why an episode that breaks no law is not called lawful; empty for none."""
        return TURNED if self.recorder.turned else "" if self._whole else NOT_WHOLE

    def close(self) -> None:
        """Record no more."""
        self._close()

    def _judge_parts(self, held: Collection[str] = ()) -> None:
        """Judge the parts that are complete; `held` are laws that the last of them is known to keep."""
        recorder = self.recorder
        for log in recorder.parts:
            if log["forces"].shape[1]:
                known = held if log is recorder.parts[-1] else ()
                reward = self._rewards(len(log))
                self._judged.append(judge_contacts(log, reward=reward, unsure=self._unsure, held=known))
            else:
                self._judged.append(report_no_touch(len(log), float(log.facts["dt"])))
        recorder.parts = []

    def _rewards(self, rows: int) -> FloatArray | None:
        """Return what each of the last rows was paid: the reward of its step of the environment, shared."""
        out, first = np.zeros(rows), 0
        for end, reward in self._earned:
            if first < end <= rows:
                out[first:end] = reward / (end - first)
            first = end
        self._earned = []
        return out if out.any() else None
