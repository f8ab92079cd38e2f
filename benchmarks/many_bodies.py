"""Spheres in the air, or at rest in a pit: a step here and in MuJoCo.

python -m benchmarks.many_bodies 1000                   # in the air, and the memory they take
python -m benchmarks.many_bodies 100 --pit --steps 900  # dropped between walls, the last third judged
python -m benchmarks.many_bodies 100 --pit --steps 480 --friction 0.5 0.6 0.7  # other pits
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.mechanics.collision import Box, Sphere
from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld

STEPS = 100
RADIUS, ROOM = 0.05, 0.11
"""Of a sphere [m], and how far apart they begin."""
PIT_STEP = 2e-3
"""Of both worlds, of spheres in a pit [s]."""

Place = tuple[float, float, float]


def _timed(step: Callable[[], object]) -> float:
    """Return the milliseconds of CPU of a step."""
    start = time.thread_time()
    step()
    return 1e3 * (time.thread_time() - start)


def in_air(count: int) -> tuple[list[Place], list[Body]]:
    """Return places of spheres apart from each other, and no walls."""
    side = int(np.ceil(count ** (1.0 / 3.0) - 1e-9))
    at = 0.3 * np.stack(np.unravel_index(np.arange(count), (side,) * 3), axis=1) + [0.0, 0.0, 1.0]
    return [(float(x), float(y), float(z)) for x, y, z in at], []


def in_pit(count: int) -> tuple[list[Place], list[Body]]:
    """Return places of spheres in layers of sixteen, a little out of line, and the four walls around them."""
    rng, grid = np.random.default_rng(0), ROOM * (np.arange(4) - 1.5)
    places = []
    for k in range(count):
        level, row, column = k // 16, k // 4 % 4, k % 4
        x, y, z = np.array([grid[row], grid[column], 0.06 + 0.105 * level]) + rng.uniform(-0.004, 0.004, 3)
        places.append((float(x), float(y), float(z)))
    half, high = 2.6 * ROOM, 0.06 * count / 8.0 + 0.5
    walls = [
        Body(f"wall {k}", Box((sx, sy, high)), position=(x, y, 0.5 * high), fixed=True)
        for k, (x, y, sx, sy) in enumerate(
            ((half, 0.0, 0.1, 2.0), (-half, 0.0, 0.1, 2.0), (0.0, half, 2.0, 0.1), (0.0, -half, 2.0, 0.1))
        )
    ]
    return places, walls


def mujoco_scene(
    places: Sequence[Place], walls: Sequence[Body], step: float, friction: float
) -> tuple[object, object]:
    """Return MuJoCo's model and data of the same spheres and walls."""
    geoms = [f'<geom type="plane" size="9 9 1" friction="{friction}"/>']
    for wall in walls:
        size, place = " ".join(map(str, wall.shape.core.tolist())), " ".join(map(str, wall.position))
        geoms.append(f'<geom type="box" size="{size}" pos="{place}" friction="{friction}"/>')
    ball = f'<freejoint/><geom size="{RADIUS}" mass="1" friction="{friction}"/>'
    balls = "".join(f'<body pos="{x} {y} {z}">{ball}</body>' for x, y, z in places)
    option = f'<option timestep="{step}" cone="elliptic"/>'
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco>{option}<worldbody>{''.join(geoms)}{balls}</worldbody></mujoco>"
    )
    return model, mujoco.MjData(model)


class Times(NamedTuple):
    """Steps' CPU (n, 2) here and in MuJoCo [ms], the largest memory here [GB], and what was left unsolved."""

    steps: FloatArray
    memory: float
    unsolved: int


def run(count: int, steps: int, friction: float, pit: bool) -> Times:
    """Return the times of both worlds, by turns; in a pit those of the last third of the steps."""
    places, walls = (in_pit if pit else in_air)(count)
    step = PIT_STEP if pit else 1e-3
    balls = [Body(f"{k}", Sphere(RADIUS), 1.0, p) for k, p in enumerate(places)]
    world = SceneWorld(Scene([*walls, *balls]), mu=friction, dt=step)
    world.step()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    model, data = mujoco_scene(places, walls, step, friction)
    times = [(_timed(world.step), _timed(lambda: mujoco.mj_step(model, data))) for _ in range(steps)]
    return Times(np.array(times[-steps // 3 :] if pit else times), memory, world.unsolved)


def show(name: str, times: Times, pit: bool) -> None:
    """Print medians, and of a pit how long the longest steps take."""
    ours, theirs = np.median(times.steps, axis=0)
    print(f"{name}: {ours:.2f} ms a step, MuJoCo {theirs:.2f} ms; {times.memory:.2f} GB")
    if pit:
        own = times.steps[:, 0]
        late = np.percentile(own, 99)
        print(
            f"mean {own.mean():.0f} ms, 99 % within {late:.0f}, all within {own.max():.0f}; "
            f"unsolved {times.unsolved}"
        )


def main(arguments: Sequence[str] | None = None) -> None:
    """Print medians, and the largest memory before MuJoCo's model is made, of each friction and of all."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("count", type=int, nargs="?", default=1000)
    parser.add_argument("--pit", action="store_true")
    parser.add_argument("--steps", type=int, default=STEPS)
    parser.add_argument("--friction", type=float, nargs="+", default=[0.6], metavar="MU")
    given = parser.parse_args(arguments)
    found = []
    for friction in given.friction:
        found.append(run(given.count, given.steps, friction, given.pit))
        name = f"{given.count} spheres" + (f", mu {friction:g}" if len(given.friction) > 1 else "")
        show(name, found[-1], given.pit)
    if len(found) > 1:
        steps, memory, unsolved = zip(*found, strict=True)
        show("all of them", Times(np.concatenate(steps), max(memory), sum(unsolved)), given.pit)


if __name__ == "__main__":
    main()
