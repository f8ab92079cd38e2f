"""What certificates say of motions that were executed: at several rates, with noise, and how fast."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

import surefoot as sf
from benchmarks.certify.corruptions import resampled
from surefoot.records.motions.motion import Motion

RATES = (30.0, 50.0, 120.0)
"""At which they are certified [Hz]."""
NOISE = (1e-3, np.radians(0.3))
"""Of the root's place [m], and of all angles [rad]."""


@dataclass(frozen=True)
class Executed:
    """Motions at a rate.

    Attributes
    ----------
    what
        The rate, and whether there is noise.
    frames, impossible, possible
        Numbers of frames with a verdict, and of those of either.
    worst
        Largest share of impossible frames of a clip [-].
    torque
        Impossible frames whose cause is a torque.
    speed
        Frames per second of processor time.
    limit
        Largest share of impossible frames that is expected [-].
    """

    what: str
    frames: int
    impossible: int
    possible: int
    worst: float
    torque: int
    speed: float
    limit: float

    @property
    def holds(self) -> bool:
        """Whether hardly any executed frame is called impossible, and none for its torques."""
        return self.impossible <= self.limit * self.frames and self.worst <= 0.02 and self.torque == 0


def noisy(motion: Motion, rng: np.random.Generator) -> Motion:
    """Return a motion with white noise in place and angles."""
    import pinocchio

    q, nv = motion.q.copy(), motion.robot.model.nv
    q[:, :3] += rng.normal(0.0, NOISE[0], (len(q), 3))
    steps = np.hstack([np.zeros((len(q), 3)), rng.normal(0.0, NOISE[1], (len(q), nv - 3))])
    turned = [pinocchio.integrate(motion.robot.model, a, b) for a, b in zip(q, steps, strict=True)]
    return replace(motion, q=np.array(turned))


def judge(motions: Sequence[Motion], seed: int = 0) -> list[Executed]:
    """Return the verdicts of executed motions, at every rate without and with noise."""
    rng, out = np.random.default_rng(seed), []
    for rate in RATES:
        clean = [resampled(motion, rate) for motion in motions]
        out.append(_judge(f"{rate:g} Hz", clean, 0.005))
        out.append(_judge(f"{rate:g} Hz, noise", [noisy(motion, rng) for motion in clean], 0.01))
    return out


def _judge(what: str, motions: Sequence[Motion], limit: float) -> Executed:
    begin = time.process_time()
    reports = [sf.certify_motion(motion.robot, motion) for motion in motions]
    spent = time.process_time() - begin
    verdicts = [r.frames.verdict for r in reports]
    torque = sum(int(np.sum(np.isin(r.frames.cause, ("torque of a joint", "speed")))) for r in reports)
    return Executed(
        what,
        sum(r.judged for r in reports),
        sum(int(np.sum(v == "impossible")) for v in verdicts),
        sum(int(np.sum(v == "possible")) for v in verdicts),
        max(r.impossible_share for r in reports),
        torque,
        sum(len(motion) for motion in motions) / spent,
        limit,
    )
