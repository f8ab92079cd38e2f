"""What knots do obeys the rows of the NLP, and what is not a knot breaks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.mechanics.terrain import FlatTerrain, SlopeTerrain
from surefoot.motion.planning import rollout
from surefoot.motion.planning.direct import DirectProblem, Facets, GivenModes, Guess, planar_hopper
from surefoot.motion.planning.direct.direct_transcription import DirectNlp
from surefoot.motion.planning.transcription.contact_rows import OPEN, SLIDE, STICK, read_modes
from surefoot.motion.planning.transcription.planar import block_and_foot

casadi = pytest.importorskip("casadi")
KNOTS, DT = 12, 0.02
ACCURACY = 2e-7
"""Of the rows, in N s and m/s: knots solve their contact problems to 1e-8 of their scale."""


def thrown(robot, terrain, seed):
    """A motion with open, sticking and sliding contacts, from a moving start and under random torques."""
    rng = np.random.default_rng(seed)
    q = robot.nominal.copy()
    v = 0.2 * rng.normal(size=robot.model.nv)
    v[0] += 1.0
    torques = 3.0 * rng.normal(size=(KNOTS, robot.joints))
    torques[:, :3] = 0.0
    return rollout(robot, q, v, torques, dt=DT, mu=0.4, terrain=terrain)


CASES = {
    "hopper": (planar_hopper(), FlatTerrain()),
    "block and foot": (block_and_foot(), SlopeTerrain(0.0)),
    "hopper uphill": (planar_hopper(), SlopeTerrain(12.0)),
}


def worst_row(nlp: DirectNlp, motion: Guess, eps: float, bounds=None, rows=None) -> float:
    """The largest violation of a row of a motion, by no iteration of Ipopt."""
    found = nlp.solve(
        nlp.pack(motion), eps, contact_bounds=bounds, row_bounds=rows, max_iter=0, bound_push=1e-16,
        bound_frac=1e-16, slack_bound_push=1e-16, slack_bound_frac=1e-16,
    )  # fmt: skip
    assert found.iterations == 0
    return found.violation


@pytest.mark.parametrize("case", CASES)
def test_knots_obey_the_rows_of_every_law(case) -> None:
    robot, terrain = CASES[case]
    motion = thrown(robot, terrain, 3)
    assert motion.lawful
    problem = DirectProblem(
        robot, motion.q[0], motion.v[0], KNOTS, DT, mu=0.4, terrain=terrain, joint_limits=False,
        torque_limits=np.full(robot.joints, 1e3),
    )  # fmt: skip
    guess, modes = Guess.of(motion, problem), None
    for law in (GivenModes(), Facets()):
        nlp = DirectNlp(problem, law)
        closing, sliding = nlp.contact_speeds(guess)
        given = ()
        if isinstance(law, GivenModes):
            modes = read_modes(guess.impulses, closing, sliding, 0.4)
            mu = problem.frictions
            given = law.bounds(modes, mu), law.row_bounds(modes, mu)
        assert worst_row(nlp, guess, 1e-8, *given) < ACCURACY
        bent = replace(guess, torques=guess.torques + 0.1 * (problem.torque_limits > 0.0))
        assert worst_row(nlp, bent, 1e-8, *given) > 1e-4
        light = replace(guess, impulses=0.5 * guess.impulses)
        assert worst_row(nlp, light, 1e-8, *given) > 1e-3
    assert modes is not None
    assert {OPEN, STICK, SLIDE} >= set(modes.ravel().tolist())
    assert len(set(modes.ravel().tolist())) > 1


@pytest.mark.parametrize("law", [Facets(), GivenModes()], ids=str)
def test_variables_mean_the_motion_they_were_made_from(law) -> None:
    robot = block_and_foot()
    found = thrown(robot, FlatTerrain(), 5)
    problem = DirectProblem(robot, found.q[0], found.v[0], KNOTS, DT)
    nlp, motion = DirectNlp(problem, law), Guess.of(found, problem)
    back = nlp.unpack(nlp.pack(motion))
    for name in ("q", "v", "torques"):
        assert np.array_equal(getattr(back, name), getattr(motion, name))
    assert np.abs(back.impulses - motion.impulses).max() < 1e-12
