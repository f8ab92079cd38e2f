"""MuJoCo's contact law in our world and in MuJoCo's: the same bodies come to the same depth the same way."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import surefoot as sf
from surefoot.laws import MujocoLaw
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.rigid.bodies import ball
from surefoot.worlds.rigid.rigid_world import RigidWorld
from tests.moving import lifted
from tests.parity.test_rigid_vs_mujoco import standing

SOFTNESS = {
    "default": ((0.02, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)),
    "bouncy": ((0.02, 0.6), (0.9, 0.95, 0.001, 0.5, 2.0)),
    "direct": ((-3000.0, -40.0), (0.3, 0.95, 0.003, 0.3, 3.0)),
}


@pytest.mark.parametrize(("solref", "solimp"), SOFTNESS.values(), ids=SOFTNESS)
@pytest.mark.long
def test_a_dropped_ball(solref, solimp):
    mass, paths, dt = 3.0, [], 2e-4
    body = ball(mass, 0.1)
    law = MujocoLaw(solref, solimp, mass=mass)
    for world in (
        MujocoWorld(body, dt=dt, solref=solref, solimp=solimp),
        RigidWorld(body, dt=dt, law=law),
    ):
        world.reset(lifted(body.nominal, 0.02))
        path = []
        for _ in range(7500):
            world.step(np.zeros(0))
            path.append(world.q_v()[0][2] - 0.1)
        paths.append(np.array(path))
    mujoco, ours = paths
    depth = law.rest_depth(mass * 9.81)
    assert -ours[-1] == pytest.approx(depth, rel=1e-6)
    assert -mujoco[-1] == pytest.approx(depth, rel=1e-6)
    deepest = -mujoco.min()
    assert -ours.min() == pytest.approx(deepest, rel=0.02)
    assert np.abs(ours - mujoco)[: round(0.2 / dt)].max() < 0.05 * deepest


@pytest.mark.long
def test_go2_rests_at_mujocos_depth():
    robot, soft = sf.load_robot("go2"), {"solref": (0.02, 1.0), "solimp": (0.9, 0.95)}
    made = MujocoWorld(robot, **soft)
    inverse = made.model.body_invweight0[made.model.geom_bodyid[made._reader.feet.geoms], 0]
    assert np.ptp(inverse) < 5e-3 * inverse.mean()  # one effective mass does for four feet
    law, depths = MujocoLaw(**soft, mass=float(1.0 / inverse.mean())), []
    for kind in (partial(MujocoWorld, **soft), partial(RigidWorld, law=law)):
        *_, world = standing(kind, robot, FlatTerrain(), 1500)
        seen = world.contacts()
        assert seen.forces[:, 2].sum() == pytest.approx(robot.mass * 9.81, rel=1e-3)
        depths.append(-seen.gaps)
    mujoco, ours = depths
    assert mujoco.min() > 1e-3  # 4 kg on each 0.4 kg: ten times as deep as a free body
    assert np.abs(ours / mujoco - 1.0).max() < 5e-3
