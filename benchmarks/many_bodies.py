"""Spheres in the air: a step here and in MuJoCo, and memory: `python -m benchmarks.many_bodies [COUNT]`."""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable

import mujoco
import numpy as np

from surefoot.mechanics.collision import Sphere
from surefoot.worlds.rigid.scene import Body, Scene, SceneWorld

STEPS = 100


def _timed(step: Callable[[], object]) -> float:
    """Return the milliseconds of a step."""
    start = time.perf_counter()
    step()
    return 1e3 * (time.perf_counter() - start)


def main() -> None:
    """Print the medians of both, step after step, and the largest memory before MuJoCo's model is made."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    side = int(np.ceil(count ** (1.0 / 3.0) - 1e-9))
    at = 0.3 * np.stack(np.unravel_index(np.arange(count), (side,) * 3), axis=1) + [0.0, 0.0, 1.0]
    places = [(float(x), float(y), float(z)) for x, y, z in at]
    world = SceneWorld(Scene([Body(f"{k}", Sphere(0.05), 1.0, p) for k, p in enumerate(places)]))
    world.step()
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    balls = "".join(
        f'<body pos="{x} {y} {z}"><freejoint/><geom size="0.05" mass="1"/></body>' for x, y, z in places
    )
    plane = '<option timestep="0.001"/><worldbody><geom type="plane" size="9 9 1"/>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco>{plane}{balls}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    times = [(_timed(world.step), _timed(lambda: mujoco.mj_step(model, data))) for _ in range(STEPS)]
    ours, theirs = np.median(times, axis=0)
    print(f"{count} spheres: {ours:.2f} ms a step, MuJoCo {theirs:.2f} ms; {memory:.2f} GB")


if __name__ == "__main__":
    main()
