"""Steps that catch a biped which was pushed: how soon they come, and where they go.

What a push leaves is a miss of the divergent motion, ξ minus the ξ from which the footsteps ahead lead on
for ever. It grows with exp(ω t), and no force of a foot takes it back once it is larger than the sole, so
steps have to [1]_: a step at the time t that is moved by d takes d exp(-ω t) off the miss of now, less a
little since the pressure moves to it over the time on both feet. Each step takes as much as legs reach, the
next ones what is left. Where that does not take all of it, steps come sooner: the clock goes faster, and the
exponent is less [2]_.

References
----------
.. [1] J. Pratt, J. Carff, S. Drakunov, A. Goswami, "Capture point: a step toward humanoid push recovery",
   Humanoids 2006.
.. [2] M. Khadiv, A. Herzog, S. A. A. Moosavian, L. Righetti, "Walking control based on step timing
   adaptation", IEEE T-RO 2020.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.memory import Remembering
from surefoot.motion.walking.biped.biped_settings import CATCHING
from surefoot.motion.walking.biped.footstep_planner import Footstep, StepPlanner, pressure_path
from surefoot.motion.walking.biped.pendulum import PendulumPreview

PACES = (1.0, 1.2, 1.4, 1.6, 1.8)
"""How many times as fast as time the clock may go."""


@dataclass
class Catching(Remembering):
    """Whether a body is being caught, and the steps that do it.

    Attributes
    ----------
    preview, planner
        Of the pendulum and of the steps.
    height
        Of the centre of mass [m].
    calm
        Plans since the body was last off by much.
    pace
        How many times as fast as time the gait's clock goes.
    """

    MEMORY = ("calm", "pace")

    preview: PendulumPreview
    planner: StepPlanner
    height: float
    calm: int = CATCHING.calm_plans
    pace: float = 1.0

    @property
    def active(self) -> bool:
        """Whether steps catch the body now."""
        return self.calm < CATCHING.calm_plans

    def reset(self) -> None:
        """Forget the last push."""
        self.calm, self.pace = CATCHING.calm_plans, 1.0

    def notice(self, miss: FloatArray) -> bool:
        """Take note of a (2,) miss at a plan [m]; return whether steps have to catch the body."""
        off = float(np.hypot(*miss)) / self.height
        self.calm = 0 if off > CATCHING.begin_miss else self.calm + (off < CATCHING.end_miss)
        if not self.active:
            self.pace = 1.0
        return self.active

    def steps(
        self, ahead: Callable[[float], list[Footstep]], miss: FloatArray, divergent: FloatArray, clock: float
    ) -> list[Footstep]:
        """Choose the pace; return the steps at it that catch the body.

        Parameters
        ----------
        ahead
            The steps as they would be at a pace.
        miss, divergent
            (2,) miss at the pace of now, with all that the plan knows of, and (2,) ξ [m].
        clock
            The gait's time [s].
        """

        @cache
        def led(pace: float) -> tuple[list[Footstep], FloatArray]:
            """Return the steps at a pace and the ξ from which they lead on for ever."""
            steps = ahead(pace)
            return steps, self.preview.divergent(pressure_path(steps, clock + self.preview.middles))[0]

        found, wanted = led(self.pace)
        unseen = miss - (divergent - wanted)  # the legs' momentum, about the same at every pace
        best = math.inf
        for pace in PACES:
            if CATCHING.hurry_cost * (pace - 1.0) >= best:
                break  # whatever it leaves
            steps, wanted = led(pace)
            moved, left = self.moved(steps, unseen + divergent - wanted, clock)
            cost = max(float(np.hypot(*left)) - CATCHING.spared, 0.0) + CATCHING.hurry_cost * (pace - 1.0)
            if cost < best:
                best, self.pace, found = cost, pace, moved
        return found

    def moved(
        self, steps: list[Footstep], miss: FloatArray, clock: float
    ) -> tuple[list[Footstep], FloatArray]:
        """Return the steps moved so that they take off a (2,) miss of now, and (2,) what is left of it [m].

        Those that stand stay; steps after one that is moved go with it. `clock` is the gait's time [s].
        """
        out, left, last, plain = [], miss, steps[0], steps[0]
        for one in steps:
            moved = one
            if one.begin > clock:
                # The pressure moves by d evenly over the double support of length T, from t on: what that
                # does to ξ now is d exp(-ω t) (1 - exp(-ω T)) / (ω T), by ξ̇ = ω (ξ - p) read backwards.
                both = self.preview.omega * max(min(last.end, one.end) - one.begin, 1e-6)
                share = math.exp(-self.preview.omega * (one.begin - clock)) * (1.0 - math.exp(-both)) / both
                nominal, side = last.place + one.place - plain.place, float(self.planner.sides[one.foot])
                reach = self.planner.geometry.within_reach
                moved = replace(one, place=reach(nominal + left / share, last.place, one.yaw, side))
                left = left - share * (moved.place - nominal)
            if one.begin >= plain.begin:
                last, plain = moved, one
            out.append(moved)
        return out, left
