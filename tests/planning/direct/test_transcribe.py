"""What knots do obeys the rows of the NLP, and what is not a knot breaks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from surefoot.planning import rollout
from surefoot.planning.direct import (
    DirectProblem,
    Facets,
    GivenModes,
    Guess,
    RoundCone,
    planar_biped,
    planar_hopper,
)
from surefoot.planning.direct.transcribe import DirectNlp
from surefoot.planning.transcription.contact_rows import OPEN, SLIDE, STICK, read_modes
from surefoot.robot import load_robot, place
from surefoot.terrain import FlatTerrain, SlopeTerrain

casadi = pytest.importorskip("casadi")
KNOTS, DT = 12, 0.02
ACCURACY = 2e-7
"""Of the rows, in N s and m/s: knots solve their contact problems to 1e-8 of their scale."""


def thrown(robot, terrain, seed):
    """A motion with open, sticking and sliding contacts, from a moving start and under random torques."""
    rng = np.random.default_rng(seed)
    q = place(robot, terrain) if robot.floating else robot.nominal.copy()
    v = 0.2 * rng.normal(size=robot.model.nv)
    v[0] += 1.0
    torques = 3.0 * rng.normal(size=(KNOTS, robot.joints))
    if not robot.floating:
        torques[:, :3] = 0.0
    return rollout(robot, q, v, torques, dt=DT, mu=0.4, terrain=terrain)


CASES = {
    "hopper": (planar_hopper(), FlatTerrain()),
    "biped": (planar_biped(), SlopeTerrain(0.0)),
    "go2": (load_robot("go2"), FlatTerrain()),
    "go2 uphill": (load_robot("go2"), SlopeTerrain(12.0)),
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
    guess, modes = Guess.of(motion), None
    for law in (RoundCone(), GivenModes(), *([Facets(2)] if problem.planar else [])):
        nlp = DirectNlp(problem, law)
        closing, sliding = nlp.contact_speeds(guess)
        given = ()
        if isinstance(law, GivenModes):
            modes = read_modes(guess.impulses, closing, sliding, 0.4)
            d = problem.tangents - 1
            mu = problem.frictions
            given = law.bounds(modes, d, mu), law.row_bounds(modes, d, mu)
        assert worst_row(nlp, guess, 1e-8, *given) < ACCURACY
        bent = replace(guess, torques=guess.torques + 0.1 * (problem.torque_limits > 0.0))
        assert worst_row(nlp, bent, 1e-8, *given) > 1e-4
        light = replace(guess, impulses=0.5 * guess.impulses)
        assert worst_row(nlp, light, 1e-8, *given) > 1e-3
    assert modes is not None
    assert {OPEN, STICK, SLIDE} >= set(modes.ravel().tolist())
    assert len(set(modes.ravel().tolist())) > 1


@pytest.mark.parametrize("law", [Facets(2), RoundCone(), GivenModes()], ids=str)
def test_variables_mean_the_motion_they_were_made_from(law) -> None:
    robot = planar_biped()
    motion = Guess.of(thrown(robot, FlatTerrain(), 5))
    nlp = DirectNlp(DirectProblem(robot, motion.q[0], motion.v[0], KNOTS, DT), law)
    back = nlp.unpack(nlp.pack(motion))
    for name in ("q", "v", "torques"):
        assert np.array_equal(getattr(back, name), getattr(motion, name))
    assert np.abs(back.impulses - motion.impulses).max() < 1e-12


@pytest.mark.parametrize("count", [4, 6, 8])
def test_facets_of_space_hold_the_impulse_they_start_from(count) -> None:
    """Σ D β is the tangential impulse for any regular set of directions, and β >= 0."""
    law, rng = Facets(count), np.random.default_rng(1)
    impulses = rng.normal(size=(5, 3, 3))
    values = law.start(impulses, np.ones((5, 3)), rng.normal(size=(5, 3, 2)), np.full(3, 0.6)).reshape(
        5, 3, -1
    )
    beta = values[..., :count]
    assert (beta >= 0.0).all()
    assert np.abs(beta @ law.directions.T - impulses[..., :2]).max() < 1e-12
