"""Experiments with one body: each a few lines of set-up, and a closed form of rigid contact."""

from __future__ import annotations

import math

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY, quaternion_about, rotation_from_quaternion
from surefoot.contact import SpringDamper, behaviour
from surefoot.mechanics import SlopeTerrain, Terrain
from surefoot.worlds.experiments.experiment import Measured, MeasuredQuantity, WorldExperiment
from surefoot.worlds.experiments.ground import HARD, bouncing, slid_down
from surefoot.worlds.experiments.track import BodyRun, BodyTrack, fall
from surefoot.worlds.rigid.bodies import ball, box

CORNER = 1e-3
"""Radius of a box's corners [m]: engines want spheres."""
MASS = 2.0
FLAT_BOX = (0.4, 0.4, 0.1)
RADIUS = 0.1


def _along(track: BodyTrack) -> FloatArray:
    """Return the distance from the start [m]: (n + 1,)."""
    return np.asarray(np.linalg.norm(track.q[:, :3] - track.q[0, :3], axis=1))


# --- drop: free fall, then the ground carries the weight

HEIGHT, FALL, DROP = 0.5, 0.3, 0.8


def _drop(world: str, dt: float) -> Measured:
    track = fall(ball(MASS, RADIUS), HEIGHT, DROP, world, dt)
    fallen = track.q[0, 2] - track.q[round(FALL / dt), 2]
    carried = dt * float(track.forces[:, 0, 2].sum()) / (MASS * GRAVITY * DROP)
    return (
        MeasuredQuantity("fallen in 0.3 s", "m", fallen, 0.5 * GRAVITY * FALL**2),
        MeasuredQuantity("mean ground force / weight", "", carried, 1.0),
        MeasuredQuantity("gap at rest", "m", track.q[-1, 2] - RADIUS, 0.0, 0.01 * RADIUS),
    )


# --- bounce: height of the second arc

RESTITUTION, STIFFNESS, BOUNCE, HOP = 0.6, 2e4, 0.3, 0.05
FINER = 10.0
"""A bounce on a spring must be resolved: it is run with a tenth of the step."""


def _bounce(world: str, dt: float) -> Measured:
    h = dt / FINER
    options = bouncing(world, RESTITUTION, MASS, STIFFNESS, h)
    track = fall(ball(MASS, RADIUS), HOP, BOUNCE, world, h, options)
    gap = track.q[:, 2] - RADIUS
    rising = np.diff(gap) > 0.0
    low = int(np.argmax(rising))
    top = float(gap[low + int(np.argmin(rising[low:]))])
    e = RESTITUTION
    if world not in HARD:  # the ground is a spring: the law's own bounce, gravity included
        law = SpringDamper.bouncing(STIFFNESS, RESTITUTION, MASS)
        e = behaviour(law, MASS, math.sqrt(2.0 * GRAVITY * HOP)).restitution
    return (MeasuredQuantity("height of the bounce", "m", top, e**2 * HOP),)


# --- slide: a box comes to rest

SPEED, SLIDE_MU, SLIDE = 2.0, 0.4, 0.8


def _slide(world: str, dt: float) -> Measured:
    run = BodyRun(box(MASS, FLAT_BOX, CORNER), SLIDE, SLIDE_MU, velocity=(SPEED, 0.0, 0.0, 0.0, 0.0, 0.0))
    track = run.run(world, dt)
    exact = SPEED**2 / (2.0 * SLIDE_MU * GRAVITY)
    return (MeasuredQuantity("distance to rest", "m", _along(track)[-1], exact),)


# --- stick: a box on a slope, below and above its friction angle

DEGREES, HOLDS, SLIPS, ON_SLOPE = 20.0, 0.45, 0.3, 0.5


def _on_slope(world: str, dt: float, mu: float) -> BodyTrack:
    terrain: Terrain = SlopeTerrain(DEGREES)
    body = box(MASS, FLAT_BOX, CORNER)
    start = body.nominal.copy()
    start[:3] = body.nominal[2] * terrain.normal(np.zeros(2))
    start[3:7] = quaternion_about([0.0, -1.0, 0.0], math.radians(DEGREES))
    return BodyRun(body, ON_SLOPE, mu, terrain, start=start).run(world, dt)


def _stick(world: str, dt: float) -> Measured:
    held, slid = _on_slope(world, dt, HOLDS), _on_slope(world, dt, SLIPS)
    exact = float(slid_down(np.array(ON_SLOPE), DEGREES, SLIPS))
    return (
        MeasuredQuantity(f"slip at mu {HOLDS:g}", "m", _along(held)[-1], 0.0, exact),
        MeasuredQuantity(f"slip at mu {SLIPS:g}", "m", _along(slid)[-1], exact),
    )


# --- tip: a box falls over its edge

TALL, LEAN, UNTIL, TIP = (0.1, 0.1, 0.3), 5.0, 30.0, 0.6


def _arm() -> tuple[float, float]:
    """Return distance of the centre from the corner sphere's centre [m] and its angle from the edge [rad]."""
    x, z = 0.5 * TALL[0] - CORNER, 0.5 * TALL[2] - CORNER
    return math.hypot(x, z), math.atan2(x, z)


def _turning(angle: FloatArray) -> FloatArray:
    """Return the speed of turning [rad/s] at an angle of the arm past the vertical, from rest at `LEAN`.

    The box rolls on its corner's sphere: energy, with the centre at (R sin a, r + R cos a) from the contact.
    """
    arm, r = _arm()[0], CORNER
    inertia = MASS / 12.0 * (TALL[0] ** 2 + TALL[2] ** 2)
    about = inertia + MASS * (arm**2 + r**2 + 2.0 * r * arm * np.cos(angle))
    drop = np.maximum(math.cos(math.radians(LEAN)) - np.cos(angle), 0.0)
    return np.asarray(np.sqrt(2.0 * MASS * GRAVITY * arm * drop / about))


def _tip(world: str, dt: float) -> Measured:
    body, (arm, edge) = box(MASS, TALL, CORNER), _arm()
    turn = edge + math.radians(LEAN)
    start = body.nominal.copy()
    start[2] = CORNER + arm * math.cos(math.radians(LEAN))
    start[3:7] = quaternion_about([0.0, 1.0, 0.0], turn)
    track = BodyRun(body, TIP, 1.0, start=start, settle=False).run(world, dt)
    axis = np.array([rotation_from_quaternion(q[3:7])[:, 2] for q in track.q])
    angle, rate = np.arctan2(axis[:, 0], axis[:, 2]) - edge, track.v[:, 4]
    last = int(np.argmax(angle > math.radians(UNTIL)))
    at = float(np.interp(math.radians(UNTIL), angle[last - 1 : last + 1], rate[last - 1 : last + 1]))
    exact = float(_turning(np.array(math.radians(UNTIL))))
    return (MeasuredQuantity("turning at 30 deg", "rad/s", at, exact),)


# --- spin: a flat box turns about its vertical axis until friction stops it

SPIN, SPIN_MU, SPINNING = 8.0, 0.3, 1.0


def _slowing() -> float:
    """Return the angular deceleration [rad/s²]: four corners, loaded alike, at one distance."""
    reach = math.hypot(*(0.5 * edge - CORNER for edge in FLAT_BOX[:2]))
    inertia = MASS / 12.0 * (FLAT_BOX[0] ** 2 + FLAT_BOX[1] ** 2)
    return SPIN_MU * MASS * GRAVITY * reach / inertia


def _spin(world: str, dt: float) -> Measured:
    run = BodyRun(box(MASS, FLAT_BOX, CORNER), SPINNING, SPIN_MU, velocity=(0.0, 0.0, 0.0, 0.0, 0.0, SPIN))
    track = run.run(world, dt)
    angle = np.unwrap(2.0 * np.arctan2(track.q[:, 5], track.q[:, 6]))
    angle = angle - angle[0]
    exact = SPIN**2 / (2.0 * _slowing())
    return (MeasuredQuantity("angle to rest", "rad", angle[-1], exact),)


# --- roll: a ball slides, then rolls

ROLL_SPEED, ROLL_MU, ROLL = 2.0, 0.2, 0.6


def _roll(world: str, dt: float) -> Measured:
    run = BodyRun(ball(MASS, RADIUS), ROLL, ROLL_MU, velocity=(ROLL_SPEED, 0.0, 0.0, 0.0, 0.0, 0.0))
    track = run.run(world, dt)
    turns = (rotation_from_quaternion(q[3:7]) for q in track.q)
    speed = np.array([float(turn[0] @ v[:3]) for turn, v in zip(turns, track.v, strict=True)])
    begin = 2.0 * ROLL_SPEED / (7.0 * ROLL_MU * GRAVITY)
    way = ROLL_SPEED * begin - 0.5 * ROLL_MU * GRAVITY * begin**2 + 5.0 / 7.0 * ROLL_SPEED * (ROLL - begin)
    return (
        MeasuredQuantity("speed of rolling", "m/s", speed[-1], 5.0 / 7.0 * ROLL_SPEED),
        MeasuredQuantity("distance in 0.6 s", "m", _along(track)[-1], way),
    )


BODIES = (
    WorldExperiment(
        "drop", "A ball of 2 kg falls 0.5 m and stays.",
        "free fall against g t^2 / 2; the ground's mean force over 0.8 s against the weight; the gap at rest "
        "against none", _drop,
    ),
    WorldExperiment(
        "bounce", "A ball falls 5 cm on ground of restitution 0.6; a tenth of the step.",
        "the height of the next arc against e^2 h (soft worlds: e of their spring-damper)",
        _bounce,
    ),
    WorldExperiment(
        "slide", "A box slides at 2 m/s on ground of friction 0.4.",
        "the distance to rest against v^2 / (2 mu g)",
        _slide,
    ),
    WorldExperiment(
        "stick", "A box on a slope of 20 degrees, with friction above and below its tangent, 0.364.",
        "the way in 0.5 s against none, and against g (sin - mu cos) t^2 / 2",
        _stick,
    ),
    WorldExperiment(
        "tip", "A tall box falls over its edge from 5 degrees past its balance.",
        "the speed of turning at 30 degrees against energy", _tip,
    ),
    WorldExperiment(
        "spin", "A flat box spins at 8 rad/s about its vertical axis on four corners.",
        "the angle to rest against I w^2 / (2 mu m g r)",
        _spin,
    ),
    WorldExperiment(
        "roll", "A ball without spin slides at 2 m/s until it rolls.",
        "its speed in the end against 5/7 v, and its way", _roll,
    ),
)  # fmt: skip
