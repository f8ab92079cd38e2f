"""MJX steps MuJoCo's model as MuJoCo does."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution

import numpy as np
import pytest

from surefoot.errors import MissingExtra, ProblemError
from surefoot.simulation.bodies import ball
from surefoot.simulation.mjx import MjxWorld, import_mjx
from surefoot.simulation.mujoco import MujocoWorld


def _here() -> bool:
    try:
        distribution("mujoco-mjx")
        import_mjx()
    except (MissingExtra, PackageNotFoundError):
        return False
    return True


HERE = _here()


@pytest.mark.skipif(HERE, reason="MJX is here")
def test_without_mjx_one_line() -> None:
    with pytest.raises(MissingExtra, match=r"mujoco-mjx is not installed.*'surefoot\[jax\]'"):
        MjxWorld(ball())


@pytest.mark.skipif(not HERE, reason="MJX is not here")
@pytest.mark.filterwarnings("ignore")
def test_it_is_mujoco() -> None:
    """One compilation, some 30 s, serves both steps, both frictions and every reset."""
    body, push = ball(2.0, 0.1), np.array([1.0, 2.0, 3.0])
    start = np.array([1.0, 0.0, -0.1, 0.0, 0.0, 0.0])
    for dt in (1e-3, 5e-4):
        worlds = [kind(body, dt=dt, mu=0.3) for kind in (MjxWorld, MujocoWorld)]
        for mu in (0.3, 0.1):
            for world in worlds:
                world.set_friction(mu)
                world.reset(body.nominal, start)
                for k in range(60):
                    world.step(np.zeros(0), push if k < 5 else None)
            (q, v), (p, w) = (world.state() for world in worlds)
            assert q == pytest.approx(p, abs=1e-8)
            assert v == pytest.approx(w, abs=1e-6)
            ours, theirs = (world.contacts() for world in worlds)
            assert ours.forces == pytest.approx(theirs.forces, rel=1e-5, abs=1e-5)
            assert ours.positions == pytest.approx(theirs.positions, abs=1e-8)
            assert worlds[0].time == pytest.approx(60 * dt)
    with pytest.raises(ProblemError):
        worlds[0].step(np.zeros(1))
