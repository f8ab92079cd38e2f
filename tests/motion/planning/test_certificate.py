"""What SOLVED means beside the goal: momentum that forces gave, and a finer run that ends there as well."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import pytest

from surefoot.contact.solution import Status
from surefoot.mechanics.robot import place
from surefoot.mechanics.terrain import FlatTerrain, PitTerrain
from surefoot.motion.planning import PlanSearch, plan_from, rollout
from surefoot.motion.planning.certificate import certify, foot_hits, link_hits, momentum_error
from surefoot.motion.planning.planner import plan
from surefoot.motion.planning.stepped_ground import find_passed_ground

casadi = pytest.importorskip("casadi")
FOUND = PlanSearch("stand", "by hand", cost=0.0, reached=True, iterations=1, seconds=0.0, goal="stands")
LONG = [pytest.param(task, marks=pytest.mark.long) for task in ("push", "jump", "jump-up", "backflip")]


def test_nothing_pushes_a_hopper_off_ice() -> None:
    """The plain step's error did: SOLVED, with a horizontal impulse of 0.000 N s."""
    made = plan(None, "hopper", 0.3, mu=0.0)
    assert made.status is Status.STALLED
    assert made.robot is not None
    ways = np.array([made.robot.com(q)[0] for q in [*made["q"], made.fact("end_q")]])
    assert np.abs(ways - ways[0]).max() < 1e-12


@pytest.mark.parametrize("task", ["ball", "hopper", *LONG])
@pytest.mark.long
def test_every_task_keeps_momentum(task: str) -> None:
    made = plan(None, task)
    motion, robot = made.again() if task != "push" else None, made.robot
    assert robot is not None
    assert made.facts["momentum_error"] < 1e-12
    if motion is not None:
        assert momentum_error(motion, robot, FlatTerrain()) < 1e-12
    assert made.status is (Status.SOLVED if made.facts["replay_apart"] <= 0.02 else Status.ALMOST)
    assert made.status is Status.SOLVED, made.facts["goal"]


@pytest.fixture(scope="module")
def standing(go2):
    q = place(go2)
    hold = lambda k, a, v: 60.0 * (q[7:] - a[7:]) - 2.0 * v[6:]  # noqa: E731
    return rollout(go2, q, np.zeros(18), hold, dt=0.002, steps=100)


def test_a_stand_ends_where_it_is(go2, standing) -> None:
    said = certify(standing, go2, FlatTerrain())
    assert said.holds
    assert said.momentum < 1e-12
    assert said.apart < 1e-4


def test_impulses_that_did_not_act_are_noticed(go2, standing) -> None:
    """2 % of the weight, sideways, in every knot."""
    pushed = standing.impulses.copy()
    pushed[:, 0, 1] += 0.02 * standing.dt * go2.mass * 9.81
    forged = replace(standing, impulses=pushed)
    assert momentum_error(forged, go2, FlatTerrain()) > 0.01
    made = plan_from(forged, go2, FOUND)
    assert made.status is Status.ALMOST
    assert "off the impulses" in made.facts["goal"]


def test_an_end_that_a_finer_run_does_not_reach_is_noticed(go2, standing) -> None:
    moved = standing.q.copy()
    moved[1:, 0] += 0.03
    made = plan_from(replace(standing, q=moved), go2, FOUND)
    assert made.status is Status.ALMOST
    assert "ends 3 cm off" in made.facts["goal"]


@pytest.mark.parametrize(("rise", "told"), [(-0.02, "mm into the ditch"), (0.02, "")])
def test_feet_that_dip_into_a_ditch_on_their_way_are_noticed(go2, standing, rise, told) -> None:
    """They touch nothing there: the ditch is deep."""
    way = standing.q.copy()
    way[50, :3] += [0.3, 0.0, rise]
    way[51:, 0] += 0.8
    ground = PitTerrain(0.25, 0.3, 0.3)
    between = find_passed_ground(ground, go2, way[0], way[-1])
    assert bool(foot_hits(way, go2, between)) == bool(told)
    made = plan_from(replace(standing, q=way), go2, FOUND, ground)
    assert made.status is Status.ALMOST  # the replay stays where it is
    assert told in made.facts["goal"]


def test_joints_that_a_replay_drives_too_fast_are_noticed(go2, standing) -> None:
    """ANYmal's turn of 90 degrees: lawful and at its goal, and thrown over in four of four executions."""
    slow = copy(go2)
    slow.speed_limits = np.full(go2.joints, 0.1 * np.abs(standing.v[:, 6:]).max())
    said = certify(standing, slow, FlatTerrain())
    assert said.apart < 1e-4
    assert not said.holds
    assert "its joints run at" in str(said)


def test_links_that_hit_are_noticed(go2, standing) -> None:
    """The trunk laid into the ground, and the legs folded inwards until left and right meet."""
    assert not link_hits(standing, go2, FlatTerrain())
    low, crossed = standing.q.copy(), standing.q.copy()
    low[-1, 2] -= 0.3
    assert ("base_0", "ground") in link_hits(replace(standing, q=low), go2, FlatTerrain())
    crossed[-1, [7, 10]] = -0.5, 0.5  # hips of the front legs
    met = link_hits(replace(standing, q=crossed), go2, FlatTerrain())
    assert any({one[:2], other[:2]} == {"FL", "FR"} for one, other in met)
    made = plan_from(replace(standing, q=crossed), go2, FOUND)
    assert made.status is Status.ALMOST
    assert " mm into " in made.facts["goal"]
