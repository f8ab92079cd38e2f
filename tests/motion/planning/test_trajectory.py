"""A rollout is what the world does under the same torques, and says where it is not lawful."""

import numpy as np
import pytest

from surefoot.base.errors import ProblemError
from surefoot.mechanics.robot import place
from surefoot.motion.planning import rollout
from surefoot.worlds.rigid.rigid_world import RigidWorld


def holding(robot, q):
    """Return torques that hold the legs against the joints' positions, as a policy."""

    def policy(k, state, v):
        return 40.0 * (q[7:] - state[7:]) - 0.4 * v[6:]

    return policy


def test_a_rollout_is_what_the_rigid_world_does(go2):
    """But for what the world's plain steps lose of momentum: next to nothing in a stand."""
    q = place(go2)
    motion = rollout(go2, q, np.zeros(18), holding(go2, q), dt=0.01, steps=30)
    world = RigidWorld(go2, mu=0.6, dt=0.01, order=1)
    world.reset(q)
    for k in range(30):
        world.step(motion.torques[k])
        states = world.q_v()
        assert np.abs(states[0] - motion.q[k + 1]).max() < 1e-3
    assert motion.lawful
    assert motion.law_residual < 1e-8


def test_a_lost_motion_is_not_lawful(go2):
    torques = np.full((5, 12), 1e290)
    motion = rollout(go2, place(go2), np.zeros(18), torques, dt=0.01)
    assert not motion.lawful
    assert motion.law_residual == np.inf
    assert np.isnan(motion.q[-1]).all()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"q": np.zeros(3)}, "q"),
        ({"v": np.full(18, np.nan)}, "v"),
        ({"torques": np.zeros((4, 3))}, "torques"),
        ({"torques": np.full((4, 12), np.inf)}, "torques"),
        ({"mu": -1.0}, "mu"),
        ({"dt": 0.0}, "dt"),
        ({"torques": lambda k, q, v: np.zeros(12)}, "steps"),
    ],
)
def test_bad_input_is_named(go2, change, told):
    given = {"q": place(go2), "v": np.zeros(18), "torques": np.zeros((4, 12)), "dt": 0.01, "mu": 0.6} | change
    with pytest.raises(ProblemError, match=told):
        rollout(go2, given.pop("q"), given.pop("v"), given.pop("torques"), **given)
