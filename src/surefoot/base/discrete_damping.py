"""How much damping a discrete loop can take: shares of a joint's speed taken away in one step.

Damping d acts on an inertia I for a step dt as if its torque were constant: v' = (1 - s) v with s = d dt / I.
The loop overshoots from s = 1 on and is unstable from s = 2 on; where the torque acts a step late, v'' = v' -
s v, it swings from s = 1/4 on and is unstable from s = 1 on. Each share says what it is for.
"""

from __future__ import annotations

from surefoot.base.arrays import FloatArray

DELAYED = 0.2
"""A robot's own loop, whose torques act a step late: still without a swing."""
SPRUNG = 0.25
"""Springs of a prediction whose steps are as long as its knots, stiffness and damping alike."""
POSED = 0.48
"""Joints that hold a posture, their stiffness beside it: calm also where torques act one step late."""
REPLAYED = 0.3
"""Feedback towards a recorded motion: small enough to leave the motion its own dynamics."""
HELD = 0.5
"""Dry friction of a simulated motor: the whole speed at once would chatter."""
BORNE = 0.7
"""A policy's own gains, as it was trained with them: cut only where a joint would overshoot."""


def largest_damping(inertia: FloatArray, dt: float, share: float) -> FloatArray:
    """Return the damping (n,) that takes a share of the speed in a step dt [s], of (n,) inertias.

    In N m s/rad for kg m², in N s/m for kg.
    """
    return share * inertia / dt


def largest_stiffness(inertia: FloatArray, dt: float, share: float) -> FloatArray:
    """Return the stiffness (n,) for which `largest_damping` of the same share is 0.7 of the critical one.

    With k = s²/2 I/dt² and d = s I/dt the ratio d / (2 sqrt(k I)) is 1/sqrt(2).
    """
    return 0.5 * share**2 * inertia / dt**2
