"""Feet whose forces, gaps and velocities are made: the laws of contact, and what a log says of itself."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from benchmarks.limit_cases.made import MU, Made
from benchmarks.limit_cases.verdict import Verdict, audited, breaks, keeps, named
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.records.log import Log


def law_cases() -> Iterator[Verdict]:
    """Yield the cases of the laws and of records."""
    yield from _tumbling()
    yield from _slides()
    yield from _no_friction()
    yield from _records()
    yield from _rebounds()


def _tumbling() -> Iterator[Verdict]:
    """Yield corners of a body on ground that gives way by 5 mm, and swings for 0.1 s after a landing."""
    for speed, depth, lawful, why in (
        (2.0, 1.45, True, "another corner's landing adds as much energy again: sqrt(2) times as deep"),
        (2.0, 3.0, False, "nine times the energy of a landing is more than a body of four corners has"),
        (0.1, 1.45, False, "a step set down at 0.1 m/s drives nothing else in"),
    ):
        made = Made(600, sinking=5e-3, settling=0.1)
        made.velocities[200, 0, 2], made.gaps[200:, :] = -speed, -1e-3
        made.gaps[230:240, 1] = -depth * 5e-3
        law = keeps if lawful else breaks
        yield law(f"{depth:g} times the depth after {speed:g} m/s", why, made.log(), "penetration")


def _slides() -> Iterator[Verdict]:
    shaken = Made(20000)
    shaken.velocities[:, 0, 0] = 2e-5 * 2.0 * np.pi * 50.0 * np.cos(2.0 * np.pi * 50.0 * shaken.time)
    why = "ripple of motors turns a leg of 0.2 m by 1e-4 rad at 50 Hz: 20 um, for 20 s"
    yield keeps("a foot that shakes on the spot", why, shaken.log(), "dissipation")
    circle = Made(6000)
    angle = 2.0 * np.pi * circle.time / 3.0
    circle.velocities[:, 0, 0] = 5e-3 * 2.0 * np.pi / 3.0 * np.cos(angle)
    circle.velocities[:, 0, 1] = 5e-3 * 2.0 * np.pi / 3.0 * np.sin(angle)
    why = "round a circle of 5 mm, a foot's own size, in 3 s: it comes back, and nothing braked it"
    yield breaks("a slow circle without friction", why, circle.log(), "dissipation")
    bouncing = Made(1000)
    bouncing.velocities[:, 0, 0] = 0.01
    bouncing.forces[np.arange(1000) % 20 >= 15, 0] = 0.0
    why = "ground contact lost for 5 ms in 20, at 50 Hz, creeping by 1 cm in a second"
    yield breaks("a foot that slides in bounces", why, bouncing.log(), "dissipation")
    steps = Made(6000)
    phase = np.arange(6000) % 500
    steps.forces[phase >= 300, 0], steps.gaps[phase >= 300, 0] = 0.0, 0.03
    steps.velocities[:, 0, 0] = np.where(phase < 60, 0.3 * np.exp(-phase / 2.0), 0.0)
    why = "a foot set down at 0.3 m/s is stopped within 2 ms by any regularised friction: 0.6 mm a step"
    yield keeps("twelve steps that slide a little", why, steps.log(), "dissipation")
    for lag, speed, lawful, why in (
        (10.0, 0.1, True, "it lags by 2 ms behind a slip that turns at 87 rad/s, as a scuffing foot does"),
        (45.0, 0.012, False, "an inner pyramid of four: 45 degrees beside the slip, on a round cone"),
    ):  # fmt: skip
        made = Made(4000)
        made.velocities[:, 0, 0] = speed
        made.forces[:, 0, 0] = -MU * np.cos(np.radians(lag)) * made.forces[:, 0, 2]
        made.forces[:, 0, 1] = MU * np.sin(np.radians(lag)) * made.forces[:, 0, 2]
        law = keeps if lawful else breaks
        yield law(f"friction {lag:g} deg beside a slide", why, made.log(), "dissipation")


def _no_friction() -> Iterator[Verdict]:
    for friction, lawful, why in (
        (1e-5, True, "MuJoCo knows no less than 1e-5"),
        (0.02, False, "ice near its melting point has 0.02"),
    ):
        made = Made(400, mu=0.0)
        made.forces[:, 0, 0] = friction * made.forces[:, 0, 2]
        law = keeps if lawful else breaks
        yield law(f"friction {friction:g} on ground that has none", why, made.log(), "friction")


def _records() -> Iterator[Verdict]:
    for rows, lawful, why in (
        (3, False, "three rows have one acceleration, and nothing to hold it against"),
        (12, True, "the shortest touch of a quick foot, 12 ms at 1 kHz"),
    ):
        log = Made(rows).log()
        yield audited(f"a log of {rows} rows", why, log, lambda r, lawful=lawful: r.lawful is lawful)  # type: ignore[misc]
    for step, lawful, why in (
        (1e-3 * (1.0 - 1e-3), True, "ten times what a microcontroller's quartz is wrong by"),
        (1.0 / 1024.0, False, "1024 Hz, which many recorders call a kilohertz"),
    ):
        log = Made(400, dt=step, said=1e-3).log()
        name = f"1 ms said of {1e3 * step:.4g} ms"
        yield audited(name, why, log, lambda r, lawful=lawful: r.lawful is lawful)  # type: ignore[misc]
    for length, lawful, why in (
        (1.0 - 0.004, True, "normals in a byte for each axis are known to 0.4 %"),
        (
            1.0 / np.cos(np.radians(15.0)),
            False,
            "a height map's (-dz/dx, -dz/dy, 1) on a slope of 15 degrees",
        ),
    ):
        made = Made(400)
        made.more["normals"] = np.tile([0.0, 0.0, length], (400, 4, 1))
        law = keeps if lawful else breaks
        yield law(f"normals of length {length:.3g}", why, made.log(), "finite")
    for slip, lawful, why in (
        (0.03, True, "3 cm/s on ground that says it creeps by 5"),
        (0.5, False, "what says it creeps by a metre in a second is no ground to stand on"),
    ):
        made = Made(1000, creep=0.05 if lawful else 1.0, contact_damping=np.full(4, 1e9))
        made.more["contact_creep"] = np.zeros((1000, 4))
        made.velocities[:, 0, 0] = slip
        law = keeps if lawful else breaks
        yield law(f"a foot that creeps at {slip:g} m/s", why, made.log(), "dissipation")
    for size, left, symptom, why in (
        (
            5e-3,
            1e-3,
            "starts in the ground",
            "a keyframe 5 mm too low; falling freely for a row it gains 10 um",
        ),
        (5e-3, 4.2e-3, "sinking", "soft ground of 4 mm: most of the depth of the first row is left"),
        (1.5e-3, 1e-3, "sinking", "it begins at rest at 1.5 mm and is driven in to 8 mm by a landing"),
    ):
        made = Made(600)
        deepest = 8e-3 if size < 2e-3 else size + 1e-5
        depth = np.interp(made.time, [0.0, 1e-3, 0.2, 0.3], [size, deepest, left, left])
        if size < 2e-3:
            depth = np.interp(made.time, [0.0, 0.1, 0.3], [size, deepest, 1.1e-3])
        made.gaps[:, 0] = np.where(made.time < 0.35, -depth, 0.0)
        yield named(f"{1e3 * size:g} mm deep at first, {1e3 * left:g} mm later", why, made.log(), symptom)


def _rebounds() -> Iterator[Verdict]:
    for restitution, lawful, dt, why in (
        (1.005, True, 2.5e-4, "drop tests tell restitution to half a percent"),
        (1.03, False, 2.5e-4, "6 % more energy than a fall from 0.3 m had"),
        (1.25, False, 1e-3, "the same at the usual kilohertz, half as much energy again"),
    ):
        law = keeps if lawful else breaks
        yield law(f"a ball of restitution {restitution:g}", why, ball(restitution, dt).log(), "restitution")
    coarse = ball(0.95, 2.5e-4)
    every = slice(None, None, 100)
    fine = coarse.log()
    log = Log({name: np.array(a)[every] for name, a in fine.arrays.items()}, {**fine.facts, "dt": 0.025})
    why = "every hundredth row of a ball that bounces lawfully: the touches lie between rows of 25 ms"
    yield keeps("a ball in coarse rows", why, log, "restitution")
    made = ball(1.0, 2.5e-4)
    made.gaps += 1e-6 * np.random.default_rng(1).normal(size=made.gaps.shape)
    why = "gaps to a micrometre, as interferometers have them: still plain that velocities are those after"
    yield keeps("a lawful ball whose gap is measured", why, made.log(), "restitution")


def ball(restitution: float, dt: float, height: float = 0.3) -> Made:
    """Return a ball of 1 kg that falls from a height [m], with the velocities after each row's impulse."""
    g, z, v, rows = GRAVITY, height, 0.0, list[tuple[float, float, float]]()
    for _ in range(round(1.5 / dt)):
        free = v - g * dt
        lands = z + dt * free < 0.0
        new = -restitution * v if lands and abs(v) > 0.1 else (0.0 if lands else free)
        rows.append(((new - free) / dt, z, new))
        v, z = new, z + dt * new
    force, gap, speed = np.array(rows).T
    made = Made(len(rows), dt=dt, mass=1.0, feet=1)
    made.forces[:, 0] = _upright(force)
    made.velocities[:, 0], made.gaps[:, 0] = _upright(speed), gap
    return made


def _upright(values: FloatArray) -> FloatArray:
    out = np.zeros((len(values), 3))
    out[:, 2] = values
    return out
