"""Motions that the direct method finds: exact, lawful to the audit, the same in the rigid world."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import MissingExtra, ProblemError
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import SlopeTerrain, StairsTerrain
from surefoot.motion.planning import rollout
from surefoot.motion.planning.direct import (
    DirectProblem,
    Facets,
    GivenModes,
    Guess,
    StateWindow,
    plan_direct,
    plan_with_modes,
    planar_hopper,
)
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.transcription.contact_rows import STICK, read_modes
from surefoot.worlds.rigid.rigid_world import RigidWorld

pytest.importorskip("casadi")


def reached(found) -> sf.Plan:
    """Return a plan at its goal; the feedback of joints alone does not balance a body on a point or two."""
    plan = found.plan
    assert plan.status.value == ("almost" if plan.facts["replay_apart"] > 0.02 else "solved"), plan.facts
    assert plan.facts["momentum_error"] < 1e-12
    return plan


def ahead(robot, distance: float, **settings) -> DirectProblem:
    """Rest to rest, `distance` [m] ahead."""
    n = robot.model.nv
    there = robot.nominal.copy()
    there[0] += distance
    end = StateWindow.at(there, np.zeros(n), 1e-3, 1e-2)
    given = {"knots": 24, "dt": 0.03, "reference": there, "end": end}
    return DirectProblem(robot, robot.nominal, np.zeros(n), **{**given, **settings})


@pytest.fixture(scope="module")
def hop():
    """The hopper's way of 0.3 m."""
    problem = ahead(planar_hopper(), 0.3)
    return problem, plan_direct(problem)


def test_the_hopper_hops_and_nobody_said_when(hop) -> None:
    _, found = hop
    assert reached(found).law_residual < 1e-8
    assert found.departure < 1e-6
    assert found.miss <= 1e-3
    phases = found.plan.contacts
    assert len(phases) >= 2
    assert found.trajectory.gaps.max() > 1e-3
    assert (found.trajectory.torques[:, :3] == 0.0).all()
    assert np.abs(found.trajectory.torques).max() <= 40.0
    assert found.plan.cost == pytest.approx(found.stages[-1][1].cost, rel=1e-4)


def test_the_motion_runs_again_without_feedback_and_in_the_rigid_world(hop) -> None:
    """The plan's torques are a motion of `rollout`, and at first that of a world whose steps are plain."""
    problem, found = hop
    motion = found.trajectory
    again = rollout(problem.robot, motion.q[0], motion.v[0], motion.torques, dt=problem.dt, mu=problem.mu)
    assert np.array_equal(again.q, motion.q)
    world = RigidWorld(problem.robot, mu=problem.mu, dt=problem.dt, order=1)
    world.reset(motion.q[0], motion.v[0])
    for k, torques in enumerate(motion.torques[:5]):
        world.step(torques)
        assert np.abs(world.q_v()[0] - motion.q[k + 1]).max() < 3e-3
    assert world.unsolved == 0


@pytest.mark.long
def test_a_finer_plan_from_a_coarse_one_is_lawful_to_the_audit(hop) -> None:
    """At 30 ms the step's linear gap leaves 2 mm at a knot's end, which the audit sees; at 10 ms nothing."""
    problem, coarse = hop
    assert {v.law for v in sf.audit_log(coarse.plan, problem.robot).violations} <= {"distance"}
    finer = ahead(planar_hopper(), 0.3, knots=72, dt=0.01)
    found = plan_direct(finer, guess=coarse.trajectory, smoothings=(1e-2, 1e-4, 1e-6, 1e-8))
    assert len(reached(found)) == 72
    assert sf.audit_log(found.plan, problem.robot).verdict == "lawful"


def test_the_modes_of_a_plan_given_as_a_schedule_lead_to_it(hop) -> None:
    """And a schedule in which the foot never leaves the ground leads nowhere."""
    problem, found = hop
    nlp = DirectNlp(problem, GivenModes())
    modes = read_modes(found.motion.impulses, *nlp.contact_speeds(found.motion), problem.mu)
    again = plan_with_modes(problem, modes)
    assert reached(again).method == "given modes"
    assert again.plan.cost == pytest.approx(found.plan.cost, rel=1e-3)
    stuck = plan_with_modes(problem, np.full_like(modes, STICK), max_iterations=60)
    assert stuck.plan.status.value == "stalled"
    with pytest.raises(ProblemError, match=r"modes must have shape \(24, 1\), .* got \[3\]"):
        plan_with_modes(problem, np.full_like(modes, 3))
    with pytest.raises(ProblemError, match=r"got shape \(3, 1\)"):
        plan_with_modes(problem, modes[:3])


@pytest.mark.long
def test_a_plan_warm_starts_the_next_one(hop) -> None:
    """The same plan comes out, in fewer iterations."""
    _, found = hop
    further = ahead(planar_hopper(), 0.32)
    cold = plan_direct(further)
    warm = plan_direct(further, guess=found.motion, smoothings=(1e-4, 1e-8))
    assert reached(warm).iterations < 0.75 * reached(cold).iterations
    assert warm.plan.cost == pytest.approx(cold.plan.cost, rel=1e-6)


def test_uphill_with_little_friction() -> None:
    """On a slope of 10 degrees, friction of 0.25 suffices: the friction used stays within it."""
    hopper, slope = planar_hopper(), SlopeTerrain(10.0)
    problem = ahead(hopper, 0.0, terrain=slope, mu=0.25, knots=12, end=StateWindow())
    found = plan_direct(problem)
    assert reached(found).law_residual < 1e-8
    impulses = found.trajectory.impulses
    assert (np.abs(impulses[..., 0]) <= 0.25 * impulses[..., 2] * (1 + 1e-6) + 1e-12).all()


def test_what_cannot_be_reached_is_not_solved() -> None:
    """0.6 m ahead within 0.09 s."""
    found = plan_direct(ahead(planar_hopper(), 0.6, knots=3), smoothings=(1e-2, 1e-8), max_iterations=60)
    assert found.plan.status.value == "stalled"
    assert "outside its windows" in str(found.plan.fact("goal"))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"knots": 0}, "knots must be a whole number >= 1"),
        ({"terrain": StairsTerrain()}, "takes a plane for ground"),
        ({"reference": np.zeros(4)}, r"reference must have shape \(5,\) or \(25, 5\)"),
        ({"windows": {25: StateWindow()}}, "windows are of knots 1 to 24, got 25"),
        ({"torque_limits": np.ones(2)}, r"torque_limits must have shape \(5,\)"),
    ],
)
def test_problems_that_are_none(settings, message) -> None:
    with pytest.raises(ProblemError, match=message):
        ahead(planar_hopper(), 0.3, **settings)


def test_windows_that_leave_nothing() -> None:
    far = planar_hopper().nominal + 9.0 * np.eye(5)[3]
    problem = ahead(planar_hopper(), 0.3, end=StateWindow.at(far))
    with pytest.raises(ProblemError, match=r"q of the window at knot 24\[3\] leaves nothing"):
        plan_direct(problem)


def test_a_robot_that_is_not_planar_and_a_guess_that_does_not_fit() -> None:
    arm = load_robot("ur5")
    with pytest.raises(ProblemError, match="robots in a plane, ur5"):
        DirectProblem(arm, arm.nominal, np.zeros(6), 5, 0.03)
    problem = ahead(planar_hopper(), 0.3)
    guess = Guess.between(problem)
    with pytest.raises(ProblemError, match="torques of the guess must have shape"):
        plan_direct(problem, guess=Guess(guess.q, guess.v, guess.torques[:, :4], guess.impulses))


def test_facets_that_are_none() -> None:
    with pytest.raises(ProblemError, match="complementarity form"):
        Facets("soft")


def test_without_casadi_one_line_says_what_to_install(monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "casadi", None)
    with pytest.raises(MissingExtra, match=r"casadi is not installed; run: pip install -e '\.\[plan\]'"):
        plan_direct(ahead(planar_hopper(), 0.3))
