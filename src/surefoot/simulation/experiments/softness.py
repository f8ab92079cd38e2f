"""Ground that gives: how it gets rigid as it stiffens, and MuJoCo's time constant from 0.002 to 0.2 s."""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact.laws.soft import MujocoLaw, SpringDamper
from surefoot.simulation.bodies import ball
from surefoot.simulation.experiments.experiment import Curve, Experiment, Measurement, Quantity
from surefoot.simulation.experiments.ground import period, soft
from surefoot.simulation.experiments.track import fall
from surefoot.spatial import GRAVITY

MASS, RADIUS = 2.0, 0.1
STIFFNESSES = (2e3, 1.6e4, 1.28e5)
HOP, FINER = 0.05, 5.0
"""Height of the fall [m]; share of the step that resolves the stiffest spring."""
RESTING = 0.05
SLOWEST = 8.0
"""Time constant over step from which a landing is resolved; shorter ones take shorter steps."""
TIMES = (0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
"""MuJoCo's time constants [s]."""
SINKS = 1e-3
"""Depth from which a resting foot counts as sunk [m]."""


def deepest(stiffness: FloatArray) -> FloatArray:
    """Return how deep a fall of `HOP` goes into springs (n,) [N/m] without damping [m], by energy."""
    rest = MASS * GRAVITY / stiffness
    return np.asarray(rest + np.sqrt(rest**2 + 2.0 * rest * HOP))


def _order(depths: FloatArray) -> float:
    """Return the exponent of 1 / k that fits depths over `STIFFNESSES`."""
    return float(-np.polyfit(np.log(STIFFNESSES), np.log(depths), 1)[0])


def _harden(world: str, dt: float) -> Measurement:
    body, h, rests, depths = ball(MASS, RADIUS), dt / FINER, [], []
    for k in STIFFNESSES:
        damped = SpringDamper(k, 2.0 * math.sqrt(k * MASS))
        lying = fall(body, -MASS * GRAVITY / k, RESTING, world, dt, soft(world, damped, MASS, dt))
        rests.append(RADIUS - lying.q[-1, 2])
        until = math.sqrt(2.0 * HOP / GRAVITY) + 0.3 * period(k, MASS)
        falling = fall(body, HOP, until, world, h, soft(world, SpringDamper(k, 0.0), MASS, h))
        depths.append(RADIUS - falling.q[:, 2].min())
    exact = deepest(np.array(STIFFNESSES))
    quantities = (
        Quantity("order of the rest depth in 1/k", "", 1.0),
        Quantity("order of the deepest point in 1/k", "", _order(exact)),
        Quantity("deepest point on the hardest", "m", float(exact[-1])),
    )
    values = _order(np.array(rests)), _order(np.array(depths)), depths[-1]
    return Measurement(values, quantities, Curve(np.array(STIFFNESSES), np.array(depths)))


def _harden_theory() -> Curve:
    k = np.geomspace(STIFFNESSES[0], STIFFNESSES[-1], 100)
    return Curve(k, deepest(k))


def _law(time: float) -> MujocoLaw:
    return MujocoLaw((time, 1.0), mass=MASS)


def rest_depth(time: float) -> float:
    """Return how deep anything rests on ground of MuJoCo's default impedance and a time constant [m]."""
    return _law(time).rest_depth(MASS * GRAVITY)


def _solref(world: str, dt: float) -> Measurement:
    """Lay the ball on ground of every time constant, and drop it there."""
    body, rows = ball(MASS, RADIUS), []
    for time in TIMES:
        law, h = _law(time), dt * min(1.0, time / (SLOWEST * 1e-3))  # MuJoCo clamps what is below two steps
        options = {"law": law} if world == "rigid" else {"solref": law.solref, "solimp": law.solimp}
        lying = fall(body, -rest_depth(time), max(RESTING, 2.0 * time), world, h, options)
        fallen = fall(body, HOP, 0.2 + 2.0 * time, world, h, options)
        load, gap = fallen.forces[:, 0, 2] / (MASS * GRAVITY), fallen.q[:, 2] - RADIUS
        rows.append(
            {
                "time constant [s]": time,
                "rest depth [m]": float(RADIUS - lying.q[-1, 2]),
                "deepest [m]": float(-gap.min()),
                "peak load / weight": float(load.max()),
                "rebound [m]": float(max(gap[int(np.argmin(gap)) :].max(), 0.0)),
            }
        )
    quantities = [Quantity(f"rest depth at {time:g} s", "m", rest_depth(time)) for time in TIMES]
    depths = [row["rest depth [m]"] for row in rows]
    firm = [row for row in rows if row["rest depth [m]"] <= SINKS]
    best = min(firm, key=lambda row: row["peak load / weight"])
    note = (
        f"sweet spot: {best['time constant [s]']:g} s, the gentlest landing "
        f"({best['peak load / weight']:.3g} weights) of those that sink by {1e3 * SINKS:g} mm at most"
    )
    return Measurement(depths, quantities, Curve(np.array(TIMES), np.array(depths)), rows, note)


def _solref_theory() -> Curve:
    times = np.geomspace(TIMES[0], TIMES[-1], 60)
    return Curve(times, np.array([rest_depth(float(t)) for t in times]))


SOFTNESS = (
    Experiment(
        "harden", "A ball falls 5 cm on springs of 2 to 128 kN/m, and rests on them; a fifth of the step.",
        "rest depth m g / k and deepest point, by energy, over the stiffness: the orders in which they "
        "vanish",
        _harden, _harden_theory, ("stiffness [N/m]", "deepest point [m]"), logarithmic=True,
    ),
    Experiment(
        "solref", "A ball falls 5 cm on ground of MuJoCo's time constants, 0.002 to 0.2 s.",
        "rest depth against (1 - d) g / (d k), MuJoCo's own law; the rigid world runs it as a soft law",
        _solref, _solref_theory, ("time constant [s]", "rest depth [m]"), ("mujoco", "rigid", "mjx"), True,
    ),
)  # fmt: skip
