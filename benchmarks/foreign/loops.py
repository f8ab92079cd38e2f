"""The loops by name, and which of them a seed of a cause runs in."""

from __future__ import annotations

from benchmarks.foreign import (
    balancer,
    balancer_faults,
    hexapod,
    hexapod_faults,
    hopper,
    hopper_faults,
    humanoid,
    humanoid_faults,
    pusher,
    pusher_faults,
    quadruped,
    quadruped_faults,
)  # fmt: skip
from benchmarks.foreign.fault import Run
from benchmarks.foreign.simulation import Loop

LOOPS = (
    Loop("pd quadruped", quadruped.mjcf, quadruped.QuadrupedControl, quadruped.vary, quadruped_faults.FAULTS),
    Loop("hopper", hopper.mjcf, hopper.HopperControl, hopper.vary, hopper_faults.FAULTS),
    Loop(
        "arm pushing a box", pusher.mjcf, pusher.PusherControl, pusher.vary, pusher_faults.FAULTS,
        lambda settings: str(settings.watched),
    ),
    Loop("pd humanoid", humanoid.mjcf, humanoid.HumanoidControl, humanoid.vary, humanoid_faults.FAULTS),
)  # fmt: skip
OTHERS = (
    Loop("servo hexapod", hexapod.mjcf, hexapod.HexapodControl, hexapod.vary, hexapod_faults.FAULTS),
    Loop("wheeled balancer", balancer.mjcf, balancer.BalancerControl, balancer.vary, balancer_faults.FAULTS),
)  # fmt: skip
"""Loops of other robots, which came after the rules; half of their seeds is held back as well."""


def failed(cause: str, seed: int) -> Run:
    """Return the run of a seed that fails of a cause: the loops that can fail so take turns."""
    able = [loop for loop in LOOPS if cause in loop.faults]
    return able[seed % len(able)].failed(cause, seed)
