"""MJX steps MuJoCo's model as MuJoCo does."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, distribution

import numpy as np
import pytest

from surefoot.errors import MissingExtra, ProblemError, SimulationError
from surefoot.simulation.bodies import ball
from surefoot.simulation.experiments import EXPERIMENTS, compare
from surefoot.simulation.mjx import MjxWorld, import_mjx
from surefoot.simulation.mjx_batch import MjxBatch
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.spatial import rotation_from_quaternion


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
    with pytest.raises(MissingExtra, match=r"mujoco-mjx is not installed.*'surefoot\[mjx\]'"):
        MjxWorld(ball())
    with pytest.raises(MissingExtra, match=r"mujoco-mjx is not installed"):
        MjxBatch(ball())


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
    rows, _ = compare(EXPERIMENTS["roll"], "mjx")
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


@needs_mjx
@pytest.mark.filterwarnings("ignore")
def test_many_at_once_are_each_as_one_alone() -> None:
    """Turned, pushed, on frictions of their own; the step and its repetition are one compilation of 30 s."""
    body, rng, mu = ball(2.0, 0.1), np.random.default_rng(0), np.array([0.02, 0.1, 0.3, 1.0])
    q, v, push = np.repeat(body.nominal[None], 4, axis=0), rng.normal(size=(4, 6)), rng.normal(size=(4, 3))
    q[:, 3:7] = rng.normal(size=(4, 4))
    q[:, 3:7] /= np.linalg.norm(q[:, 3:7], axis=1, keepdims=True)
    q[:, 2] += [0.0, 0.0, -1e-5, 0.05]
    v[:, 2], push[:, 2] = 0.0, -5.0
    batch, still = MjxBatch(body, count=4, mu=mu), np.zeros((4, 0))
    v[:, :3] = [
        turn.T @ row for turn, row in zip(map(rotation_from_quaternion, q[:, 3:7]), v[:, :3], strict=True)
    ]
    batch.reset(q, v)
    assert batch.state()[0] == pytest.approx(q, abs=1e-15)
    assert batch.state()[1] == pytest.approx(v, abs=1e-14)
    batch.step(still, push, repeat=20)
    out = batch.step(still, repeat=21)
    alone = MjxWorld(body)
    for k in range(4):
        alone.set_friction(float(mu[k]))
        alone.reset(q[k], v[k])
        for step in range(41):
            alone.step(still[k], push[k] if step < 20 else None)
        theirs = alone.contacts()
        assert out.q[k] == pytest.approx(alone.state()[0], abs=1e-8)
        assert out.v[k] == pytest.approx(alone.state()[1], abs=1e-6)
        assert out.forces[k] == pytest.approx(theirs.forces, rel=1e-5, abs=1e-5)
        assert out.gaps[k] == pytest.approx(theirs.gaps, abs=1e-8)
    spun = np.abs(out.v[:, 3:] - v[:, 3:]).max(axis=1)  # a homogeneous ball in the air keeps its spin
    assert (spun[:3] > 1e-3).all()
    assert spun[3] < 1e-9
    assert not out.lost.any()

    # one that is lost stays where it was, and the others go on as if it were not there
    fast = v.copy()
    fast[1] = 1e200
    batch.reset(q, fast)
    lost = batch.step(still, repeat=5)
    assert lost.lost.tolist() == [False, True, False, False]
    assert lost.q[1] == pytest.approx(q[1], abs=1e-15)
    assert np.isfinite(lost.forces).all()
    batch.reset(q, v)
    whole = batch.step(still, repeat=5)
    for k in (0, 2, 3):
        assert lost.q[k] == pytest.approx(whole.q[k], abs=1e-12)
    assert not whole.lost.any()

    # a mask resets only those that are meant
    batch.reset(body.nominal, which=np.array([True, False, False, False]))
    assert batch.state()[0][0] == pytest.approx(body.nominal)
    assert batch.state()[0][1:] == pytest.approx(whole.q[1:])


@needs_mjx
def test_a_batch_refuses_by_name() -> None:
    body = ball(2.0, 0.1)
    for words, told in (
        ({"count": 0}, "count"), ({"count": 2, "mu": [0.1] * 3}, "mu"), ({"mu": np.nan}, "mu"),
        ({"dt": 0.0}, "dt"), ({"payload": -1.0}, "payload"),
    ):  # fmt: skip
        with pytest.raises(ProblemError, match=told):
            MjxBatch(body, **words)  # type: ignore[arg-type]
    batch = MjxBatch(body, count=2)
    before = batch.state()
    for bad in (np.zeros(1), np.zeros((2, 1))):
        with pytest.raises(ProblemError, match="torques must have shape"):
            batch.step(bad)
    with pytest.raises(ProblemError, match="push"):
        batch.step(np.zeros((2, 0)), np.full((2, 3), np.nan))
    with pytest.raises(ProblemError, match="repeat"):
        batch.step(np.zeros((2, 0)), repeat=0)
    with pytest.raises(ProblemError, match="which must be a mask"):
        batch.reset(body.nominal, which=[1, 0])
    with pytest.raises(ProblemError, match="q"):
        batch.reset(np.full((2, 7), np.nan))
    with pytest.raises(ProblemError, match="v must have shape"):
        batch.reset(body.nominal, np.zeros(5))
    with pytest.raises(ProblemError, match="mu"):
        batch.set_friction([0.1, -0.1])
    assert np.array_equal(batch.state()[0], before[0])
