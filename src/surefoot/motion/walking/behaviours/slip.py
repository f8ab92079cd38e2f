"""Friction as stance feet find it: what to plan on where they slide, and how fast to walk there.

Every stance foot shows something: it has used some friction and stood, or it slides and shows all there
is (`estimation.FrictionTracker`). The least that any foot has shown lately is what is planned on;
the speed that is asked for and the rate at which that changes are what such friction gives. What a slide has
shown is forgotten after a while, and the robot goes on as before.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.motion.walking.behaviours.behaviour import Request, WalkFacts, WalkView
from surefoot.records import FrictionTracker


class Slip(Remembering):
    """Follows the friction under a robot's feet.

    Parameters
    ----------
    walk
        What it is for.

    Attributes
    ----------
    mu
        Friction that is believed in now [-].
    sliding
        (n,) which feet slide now.
    """

    MEMORY = ("mu", "sliding", "_speeds", "_slid", "_quick", "_quick_age", "_tracker")

    name = "slip"

    def __init__(self, walk: WalkFacts) -> None:
        self.assumed, self.dt, self._radii, self._share = walk.mu, walk.dt, walk.radii, walk.friction_share
        self._froude = math.sqrt(GRAVITY * walk.height)
        self.settings = walk.settings.slip
        self._tracker = FrictionTracker(
            len(walk.radii), walk.dt, least=self.settings.loaded * walk.weight, memory=self.settings.memory,
            sliding_speed=self.settings.sliding_speed * self._froude,
        )  # fmt: skip
        self.reset()

    @classmethod
    def of(cls, walk: WalkFacts) -> Slip | None:
        """Return the behaviour where friction is watched."""
        return cls(walk) if walk.watch_friction else None

    def reset(self) -> None:
        """Forget everything."""
        self._tracker.reset()
        self.mu = self.assumed
        self.sliding: BoolArray = np.zeros(len(self._radii), dtype=bool)
        self._speeds = np.zeros((len(self._radii), 3))
        self._slid, self._quick, self._quick_age = np.zeros(len(self._radii)), math.inf, math.inf

    def propose(self, view: WalkView) -> Request:
        """Ask for the friction that the feet have found, and for speeds that suit it."""
        mu = self._follow(view)
        cap = self.settings.speed * mu * self._froude if mu < self.assumed else math.inf
        return Request(
            speed_cap=cap, mu=self._share * mu, acceleration=self.settings.acceleration * mu * GRAVITY
        )

    def _follow(self, view: WalkView) -> float:
        """Return the friction to plan with [-] after one more step; feet in the air show nothing."""
        forces, now, frames, stance = view.state.forces, view.now, view.frames, view.stance
        if forces is None:
            return self.mu
        normals = frames[:, :, 2]
        arms = -self._radii[:, None] * normals
        velocities = now.twists[:, :3] + np.cross(now.twists[:, 3:], arms)
        self._speeds += min(self.dt / self.settings.filter_time, 1.0) * (velocities - self._speeds)
        own = np.where(stance[:, None], forces, 0.0)
        local = np.einsum("nji,nj->ni", frames, own)
        slow = np.einsum("nji,nj->ni", frames, self._speeds)
        if not (np.isfinite(local).all() and np.isfinite(slow).all()):
            return self.mu
        self.sliding = self._tracker.update(local, slow).sliding & stance
        wanted = max(
            float(self._tracker.believed(self.assumed, self.settings.margin).min()), self.settings.least
        )
        wanted = min(wanted, self.assumed, self._at_once(local))
        time = self.settings.falling_time if wanted < self.mu else self.settings.rising_time
        self.mu += min(self.dt / time, 1.0) * (wanted - self.mu)
        return self.mu

    def _at_once(self, forces: FloatArray) -> float:
        """Return what feet use that begin to slide, forces (n, 3) [N]: the tracker is surer, but later."""
        self._slid = np.where(self.sliding, self._slid + self.dt, 0.0)
        begun = self._slid >= self.settings.soon
        if begun.any():
            use = np.hypot(forces[begun, 0], forces[begun, 1]) / np.maximum(forces[begun, 2], 1e-9)
            self._quick, self._quick_age = (
                max((1.0 - self.settings.margin) * float(use.min()), self.settings.least),
                0.0,
            )
        self._quick_age += self.dt
        return self._quick if self._quick_age < self.settings.hold else math.inf
