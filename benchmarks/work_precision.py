"""Print what a stated error costs: 13 motions with closed forms, by fixed steps and by `RigidWorld(tol=...)`.

Run: python -m benchmarks.work_precision [--quick] [--out FOLDER] [--json].
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pinocchio
from rich.table import Table
from scipy.integrate import solve_ivp

import surefoot as sf
from benchmarks.printing import options, show, table
from surefoot.base.arrays import FloatArray
from surefoot.base.spatial import GRAVITY
from surefoot.laws import SpringDamper
from surefoot.worlds.experiments.body_experiments import CORNER, FLAT_BOX, LEAN, MASS, TALL, _arm, _slowing
from surefoot.worlds.rigid.bodies import ball, box

RADIUS, PERIOD = 0.1, 0.01
"""Of balls [m], and how long torques and pushes stay as they are [s]: the longest step with a tol."""
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
STEPS = (1e-2, 4e-3, 1e-3, 4e-4, 1e-4)
"""Of the runs with a stated error, and of those with fixed steps [s]."""


@dataclass(frozen=True)
class Motion:
    """A motion with a closed form: body, start, length [s], settings, and the end: place, turn, rates."""

    name: str
    body: sf.Robot
    seconds: float
    end: tuple[Any, Any, Any, Any]
    lift: Any = (0.0, 0.0, 0.0)
    turn: Any = (0.0, 0.0, 0.0)
    velocity: tuple[float, ...] = (0.0,) * 6
    push: Callable[[float], float] | None = None
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def start(self) -> FloatArray:
        """Configuration (nq,) at the start."""
        turned = pinocchio.Quaternion(pinocchio.exp3(np.array(self.turn))).coeffs()
        return np.concatenate([self.body.nominal[:3] + self.lift, turned])

    def run(self, dt: float, tol: float | None) -> tuple[float, int, float]:
        """Return the error of the state [m, rad, and as many per second], steps taken, and seconds."""
        world = sf.RigidWorld(self.body, dt=dt, tol=tol, **self.settings)
        world.reset(self.start, np.array(self.velocity))
        count, begin = round(self.seconds / dt), time.perf_counter()
        for k in range(count):
            push = None if self.push is None else np.array([self.push((k + 0.5) * dt), 0.0, 0.0])
            world.step(np.zeros(0), push)
        spent = time.perf_counter() - begin
        steps = count if world.control is None else 2 * world.control.taken + world.control.refused
        place, turn, speed, rate = (np.asarray(x, dtype=np.float64) for x in self.end)
        R = pinocchio.exp3(turn)
        q, v = world.q_v()
        off = np.r_[q[:3] - place, pinocchio.log3(R.T @ pinocchio.Quaternion(q[3:7]).matrix())]
        return float(np.abs(np.r_[off, v - np.r_[R.T @ speed, R.T @ rate]]).max()), steps, spent


def hopping(height: float, e: float, seconds: float) -> tuple[float, float]:
    """Return gap and speed of a ball that fell from a height [m] and bounces, after all its arcs."""
    up, begin = math.sqrt(2.0 * GRAVITY * height), -math.sqrt(2.0 * height / GRAVITY)
    while up > 1e-12:
        if seconds <= begin + 2.0 * up / GRAVITY:
            t = seconds - begin
            return up * t - 0.5 * GRAVITY * t * t, up - GRAVITY * t
        begin, up = begin + 2.0 * up / GRAVITY, e * up
    return 0.0, 0.0


def thrown(name: str, mu: float, v: float = 1.5, spin: float = -8.0, e: float = 0.8) -> Motion:
    """Return a ball with back spin, thrown from 0.5 m: at its one touch it slides through or grips."""
    t, seconds = math.sqrt(1.0 / GRAVITY), 0.5
    pressed, slip = (1.0 + e) * GRAVITY * t, v - RADIUS * spin
    drag = min(mu * pressed, slip / 3.5)  # a ball of 2/5 m r² grips at 2/7 of its slip
    after, rate = v - drag, spin + drag / (0.4 * RADIUS)
    gap, rise = hopping(0.5, e, seconds)
    end = [v * t + after * (seconds - t), 0.0, RADIUS + gap], [0.0, spin * t + rate * (seconds - t), 0.0]
    return Motion(name, ball(MASS, RADIUS), seconds, (*end, [after, 0.0, rise], [0.0, rate, 0.0]),
                  (0.0, 0.0, 0.5), velocity=(v, 0.0, 0.0, 0.0, spin, 0.0),
                  settings={"mu": mu, "restitution": e})  # fmt: skip


def bounced(name: str, height: float, e: float, seconds: float) -> Motion:
    """Return a ball that falls."""
    gap, speed = hopping(height, e, seconds)
    end = [0.0, 0.0, RADIUS + gap], [0.0] * 3, [0.0, 0.0, speed], [0.0] * 3
    return Motion(name, ball(MASS, RADIUS), seconds, end, (0.0, 0.0, height), settings={"restitution": e})


def sloped(name: str, mu: float, degrees: float = 20.0, seconds: float = 0.5) -> Motion:
    """Return a box on a slope, let go."""
    body, tilt = box(MASS, FLAT_BOX, CORNER), math.radians(degrees)
    slope = sf.SlopeTerrain(degrees)
    pull = max(GRAVITY * (math.sin(tilt) - mu * math.cos(tilt)), 0.0)
    normal = slope.normal(np.zeros(2))
    down = np.array([-normal[2], 0.0, normal[0]]) * (1.0 if normal[0] < 0.0 else -1.0)
    at, turn = body.nominal[2] * normal, [0.0, math.atan2(normal[0], normal[2]), 0.0]
    end = at + 0.5 * pull * seconds**2 * down, turn, pull * seconds * down, [0.0] * 3
    return Motion(name, body, seconds, end, at - body.nominal[:3], turn,
                  settings={"mu": mu, "terrain": slope})  # fmt: skip


def tipped(seconds: float = 0.3) -> Motion:
    """Return a tall box that falls over its edge: energy gives its speed, an integral the time."""
    body, (arm, edge), lean = box(MASS, TALL, CORNER), _arm(), math.radians(LEAN)
    inertia = MASS / 12.0 * (TALL[0] ** 2 + TALL[2] ** 2)

    def squared(a: Any) -> Any:
        about = inertia + MASS * (arm**2 + CORNER**2 + 2.0 * CORNER * arm * np.cos(a))
        return 2.0 * MASS * GRAVITY * arm * (math.cos(lean) - np.cos(a)) / about

    found = solve_ivp(lambda _, x: [x[1], 0.5 * squared(x[0] + 1e-30j).imag / 1e-30], (0.0, seconds),
                      [lean, 0.0], method="DOP853", rtol=1e-13, atol=1e-15)  # fmt: skip
    a, rate = float(found.y[0, -1]), math.sqrt(squared(found.y[0, -1]))
    at = [CORNER * (x - lean) + arm * (math.sin(x) - math.sin(lean)) for x in (a,)]
    speed = [(CORNER + arm * math.cos(a)) * rate, 0.0, -arm * math.sin(a) * rate]
    end = [*at, 0.0, CORNER + arm * math.cos(a)], [0.0, edge + a, 0.0], speed, [0.0, rate, 0.0]
    lift = [0.0, 0.0, CORNER + arm * math.cos(lean) - body.nominal[2]]
    return Motion("tip", body, seconds, end, lift, (0.0, edge + lean, 0.0), settings={"mu": 1.0})


def sprung(seconds: float = 0.02, k: float = 2e4, c: float = 40.0, speed: float = 0.5) -> Motion:
    """Return a ball that has just touched a spring and damper."""
    omega, decay, sag = math.sqrt(k / MASS), 0.5 * c / MASS, MASS * GRAVITY / k
    fast = math.sqrt(omega**2 - decay**2)
    sine = (-speed + decay * sag) / fast
    wave = complex(-decay, fast)
    x = sag * np.exp(wave * seconds).real + sine * np.exp(wave * seconds).imag - sag
    v = sag * (wave * np.exp(wave * seconds)).real + sine * (wave * np.exp(wave * seconds)).imag
    end = [0.0, 0.0, RADIUS + x], [0.0] * 3, [0.0, 0.0, v], [0.0] * 3
    return Motion("spring", ball(MASS, RADIUS), seconds, end, velocity=(0.0, 0.0, -speed, 0.0, 0.0, 0.0),
                  settings={"law": SpringDamper(k, c)})  # fmt: skip


def motions() -> list[Motion]:
    """Return all 13."""
    flat, still = box(MASS, FLAT_BOX, CORNER), [0.0] * 3
    z, v, g = flat.nominal[2], 2.0, GRAVITY
    pull, lasts = 20.0 / MASS - 0.4 * g, 0.2
    pushed = 0.5 * pull * lasts**2 * (1.0 + pull / (0.4 * g))
    slow, w = _slowing(), 8.0
    begin = 2.0 * v / (7.0 * 0.2 * g)
    way = v * begin - 0.1 * g * begin**2 + 5.0 / 7.0 * v * (0.6 - begin)
    turned = 2.5 * 0.2 * g / RADIUS * (0.5 * begin**2 + begin * (0.6 - begin))
    on = 5.0 / 7.0 * v
    return [
        bounced("drop", 0.5, 0.0, 0.8), bounced("bounce", 0.5, 0.6, 1.0),
        bounced("bounces to rest", 0.2, 0.5, 0.8), thrown("throw, slides", 0.1), thrown("throw, grips", 2.0),
        Motion("slide", flat, 0.8, ([v * v / (0.8 * g), 0.0, z], still, still, still),
               velocity=(v, 0.0, 0.0, 0.0, 0.0, 0.0), settings={"mu": 0.4}),
        Motion("pushed", flat, 0.6, ([pushed, 0.0, z], still, still, still),
               push=lambda t: 20.0 if t < lasts else 0.0, settings={"mu": 0.4}),
        sloped("stick", 0.45), sloped("slip", 0.3), tipped(),
        Motion("spin", flat, 1.0, ([0.0, 0.0, z], [0.0, 0.0, w * w / (2.0 * slow)], still, still),
               velocity=(0.0, 0.0, 0.0, 0.0, 0.0, w), settings={"mu": 0.3}),
        Motion("roll", ball(MASS, RADIUS), 0.6,
               ([way, 0.0, RADIUS], [0.0, turned, 0.0], [on, 0.0, 0.0], [0.0, on / RADIUS, 0.0]),
               velocity=(v, 0.0, 0.0, 0.0, 0.0, 0.0), settings={"mu": 0.2}),
        sprung(),
    ]  # fmt: skip


class Runs(NamedTuple):
    """What a motion's runs gave: (error, steps, seconds) of each tolerance and of each fixed step."""

    motion: Motion
    stated: list[tuple[float, int, float]]
    fixed: list[tuple[float, int, float]]


def carried_out(motion: Motion, tolerances: Sequence[float], steps: Sequence[float]) -> Runs:
    """Return the runs of a motion; the first of a kind only compiles."""
    motion.run(PERIOD, TOLERANCES[0])
    return Runs(
        motion, [motion.run(PERIOD, tol) for tol in tolerances], [motion.run(dt, None) for dt in steps]
    )


def draw(runs: Sequence[Runs], path: Path) -> Path:
    """Draw error over steps, a panel for each motion."""
    from surefoot.app.viz.style import BAD, INK, new_figure, save

    figure, axes = new_figure(3, 5, size=(13.0, 7.2))
    for axis, (motion, stated, fixed) in zip(axes.flat, runs, strict=False):
        for found, mark, colour, label in ((fixed, "o-", INK, "fixed steps"), (stated, "s-", BAD, "tol")):
            errors = [max(error, 1e-12) for error, _, _ in found]
            axis.loglog([n for _, n, _ in found], errors, mark, color=colour, ms=4, lw=1.2, label=label)
        for (_, count, _), tol in zip(stated, TOLERANCES, strict=False):
            axis.plot(count, tol, "_", color=BAD, ms=12, alpha=0.5)
        axis.set_title(motion.name, fontsize=9, loc="left")
        axis.set_ylim(3e-13, 1.0)
    for axis in list(axes.flat)[len(runs) :]:
        axis.set_axis_off()
    axes[0, 0].legend(fontsize=8)
    figure.supxlabel("steps taken, refused ones included", fontsize=9)
    figure.supylabel("error of the state; dashes: what was asked for", fontsize=9)
    return save(figure, path)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables and draw the picture."""
    parser = options(__doc__, "three motions, two tolerances")
    parser.add_argument("--out", type=Path, help="folder for the picture")
    given = parser.parse_args(arguments)
    chosen = motions()[5:8] if given.quick else motions()
    tolerances, steps = (TOLERANCES[1:3], STEPS[1:3]) if given.quick else (TOLERANCES, STEPS)
    runs = [carried_out(motion, tolerances, steps) for motion in chosen]

    def tables() -> Iterator[Table]:
        for title, sizes in (("tol", tolerances), ("fixed step [s]", steps)):
            found = [(run.motion.name, run.stated if title == "tol" else run.fixed) for run in runs]
            rows = [(name, *(f"{e:.0e} ({n})" for e, n, _ in by)) for name, by in found]
            yield table((title, *(f"{x:g}" for x in sizes)), rows, "error of the state (steps taken)")

    show(tables(), given.json)
    if given.out is not None:
        given.out.mkdir(parents=True, exist_ok=True)
        print(f"picture: {draw(runs, given.out / 'work_precision.png')}")


if __name__ == "__main__":
    main()
