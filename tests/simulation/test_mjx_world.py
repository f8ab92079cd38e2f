"""MJX steps MuJoCo's model as MuJoCo does."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution

import numpy as np
import pytest

from surefoot.errors import MissingExtra, ProblemError, SimulationError
from surefoot.experiments import EXPERIMENTS
from surefoot.experiments.experiment import compare
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
    with pytest.raises(MissingExtra, match=r"mujoco-mjx is not installed.*-e '\.\[mjx\]'"):
        MjxWorld(ball())


needs_mjx = pytest.mark.skipif(not HERE, reason="MJX is not here")


@needs_mjx
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


@needs_mjx
@pytest.mark.filterwarnings("ignore")
def test_it_keeps_to_the_closed_forms() -> None:
    """On a ball, whose compilation is that of the test above; `surefoot worlds --world mjx` asks for all."""
    rows = compare(EXPERIMENTS["roll"], "mjx")
    assert [row.verdict for row in rows] == ["agrees"] * 2


@needs_mjx
@pytest.mark.filterwarnings("ignore")
def test_a_start_that_is_none_is_refused() -> None:
    body = ball(2.0, 0.1)
    with pytest.raises(ProblemError, match="terrain must be a Terrain"):
        MjxWorld(body, "slope:10")  # type: ignore[arg-type]
    world = MjxWorld(body)
    for bad in (np.full(7, np.nan), body.nominal[:5]):
        with pytest.raises(ProblemError, match="q"):
            world.reset(bad)
    with pytest.raises(ProblemError, match="v"):
        world.reset(body.nominal, np.full(6, np.inf))
    with pytest.raises(ProblemError, match="push"):
        world.step(np.zeros(0), np.array([0.0, np.nan, 0.0]))
    world.reset(body.nominal, np.full(6, 1e200))
    with pytest.raises(SimulationError, match="root_joint"):
        world.step(np.zeros(0))
    assert world.state()[1] == pytest.approx(np.full(6, 1e200))  # as before the step
    world.reset(body.nominal)
    world.step(np.zeros(0))
    assert np.isfinite(world.contacts().forces).all()
