"""The plans of `auto` name what exists; parts are solved apart, proofs come early, compiling is free."""

from __future__ import annotations

import itertools
import sys
import time
from typing import Any

import numpy as np
import pytest
from numba.core import event

import surefoot as sf
from benchmarks.problems.contacts import capsules, stack, wall
from benchmarks.problems.heaps import rocks
from benchmarks.problems.judge import judge
from surefoot.base.kernels import working_time
from surefoot.contact.laws import LAWS
from surefoot.contact.solvers import auto, on_blocks, redundant_contacts
from surefoot.contact.solvers import strategies as plans
from surefoot.contact.solvers.central_path import CentralPath
from surefoot.contact.solvers.solver import SolverSettings
from surefoot.contact.solvers.step_memory import MOST_UNMET

TABLES = (plans.CONES, plans.CONES_MORE, plans.CONES_LARGE, plans.CONES_BODIES, plans.PYRAMIDS)
PLANS = [*(plan for table in TABLES for plan in table.values()), plans.GENERAL]


def test_every_stage_is_a_solver_or_a_part() -> None:
    known = {*sf.solver_names(), *auto.LOOKS, *auto.FUNCTIONS}
    stages = [stage for plan in PLANS for stage in plan]
    assert {stage.name for stage in stages} <= known
    assert all(stage.most is None or stage.most > 0 for stage in stages)


def test_every_law_has_its_plans_and_each_parts_and_looks_for_a_proof() -> None:
    assert all(set(table) == set(LAWS) for table in TABLES)
    for plan in PLANS:
        assert {plans.PARTS, plans.PROOF} <= {stage.name for stage in plan}


@pytest.mark.parametrize("boxes", [7, 11, 12, 20])
def test_the_compiled_call_knows_no_cliff(boxes: int) -> None:
    """Of 44 and 48 contacts, where it ended once, and of many more it solves a stack at once."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import Scene, stack, steps

    problem = list(steps(Scene(stack(boxes)), 2))[-1].problem
    found = sf.solve(sf.ContactProblem(problem.G, problem.g, problem.mu))
    assert found.solved
    assert found.iterations < 40
    answer = sf.ContactSolver(4 * boxes, problem.mu).solve(problem.G, problem.g)
    assert answer.iterations == found.iterations


def test_walls_are_left_to_the_interior_point_after_a_round() -> None:
    names = [stage.name for stage in plans.CONES_MORE["coulomb"]]
    assert names[:2] == [plans.FEW_BODIES, plans.LATER]


def test_a_bridge_is_left_to_the_lightest_interior_point() -> None:
    """The compiled call's later rounds took 6 to 17 ms of steps that an interior point solves in three."""
    pytest.importorskip("mujoco")
    from benchmarks.problems.stacked_scenes import SCENES, steps

    late = [step.problem for step in steps(SCENES["bridge"], 60)][25::6]
    for problem in late:
        found = sf.solve(sf.ContactProblem(problem.G, problem.g, problem.mu), tol=1e-8)
        assert found.solved
        assert found.iterations < 400


def test_no_factor_is_looked_for_where_contacts_hold_many_bodies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of towers with a heavy bottom it took a quarter of the solve, and was of too many columns."""
    tower = stack(np.random.default_rng(1), 20, 0.6, 1e-3, 0.05)
    low = wall(np.random.default_rng(1), 3, 4, 0.6, 1.0)
    asked: list[int] = []
    monkeypatch.setattr(redundant_contacts, "find_factor", lambda problem, *_: asked.append(problem.contacts))
    for drawn in (tower, low):
        problem = sf.ContactProblem(drawn.G, drawn.g, drawn.mu)
        assert redundant_contacts.where_few_bodies(problem, SolverSettings(1e-8), None) is None
    assert asked == [low.contacts]


def test_a_tower_with_a_heavy_top_has_a_sparse_interior_point_early() -> None:
    """Its matrix is guessed too heavy where it would be dense: 1,100 iterations came before it."""
    drawn = stack(np.random.default_rng([0, 0, *b"stack-heavy-top-80"]), 20, 0.6, 1e6, 0.01)
    problem = sf.ContactProblem(drawn.G, drawn.g, drawn.mu)
    found = sf.solve(problem, tol=1e-2)
    assert found.solved
    assert found.iterations < 400
    # where that was no answer, it is not followed again
    light = redundant_contacts.where_lightest(problem, SolverSettings(1e-2), None)
    assert light is not None
    assert redundant_contacts.where_redundant(problem, SolverSettings(1e-2), None) is None


@pytest.mark.long
def test_a_wall_of_mixed_masses_is_left_to_the_interior_point() -> None:
    """Without it nobody comes below 1e-2 in seconds; its rank is guessed too large from G alone."""
    drawn = wall(np.random.default_rng([0, 0, *b"wall-mixed-250"]), 6, 6, 0.6, 1e6)
    found = sf.solve(sf.ContactProblem(drawn.G, drawn.g, drawn.mu), tol=1e-4)
    assert found.solved
    assert found.iterations < 3000


def test_a_path_of_light_and_heavy_bricks_begins_far_from_the_centre() -> None:
    """Its first step was refused, since it left some contacts as far off: all ended at 1e-2 after 27,000."""
    drawn = wall(np.random.default_rng([2, 0, *b"wall-mixed-250"]), 6, 6, 0.6, 1e6)
    assert sf.solve(sf.ContactProblem(drawn.G, drawn.g, drawn.mu), tol=1e-6).solved


@pytest.mark.parametrize(("balls", "each", "first"), [(200, 1, "newton"), (40, 5, "admm"), (600, 1, "admm")])
def test_known_bodies_have_admm_first_where_they_are_few_or_contacts_many(
    balls: int, each: int, first: str
) -> None:
    """In a pit of balls 3,000 of its iterations came before the few Newton steps that were needed."""
    Y = np.kron(np.eye(balls), np.tile(np.eye(3), (each, 1)))
    problem = sf.ContactProblem.of_factor(Y, np.zeros(3 * balls * each), 0.5)
    plan = auto._large_plan(problem, tried=False, error=1e-2)
    assert plan[0].name.startswith(first)
    # what was tried between sweeps is not tried again, but a long path is
    left = [stage.name for stage in auto._large_plan(problem, tried=True, error=1e-2)]
    assert {plans.SPARSE} == {s.name for s in plan} - set(left)
    assert plans.LONG_PATH in left
    # where an interior point came near an answer, Newton goes on from there
    assert auto._large_plan(problem, tried=True, error=1e-7)[0] == plans.AFTER


def test_later_stages_begin_with_what_a_light_interior_point_found() -> None:
    """It was thrown away where it had not come below 1e-3, and nothing else came below 4e-4."""
    drawn = wall(np.random.default_rng([0, 0, *b"wall-mixed-250"]), 6, 6, 0.6, 1e6)
    assert drawn.factor is not None
    found = sf.solve(drawn, tol=1e-4)
    assert found.solved
    assert found.iterations < 6000


def test_a_heap_whose_bodies_are_known_is_left_to_admm() -> None:
    """Sweeps and Newton steps took 12,000 iterations and six times as long, and ended above 1e-6."""
    heap = rocks(np.random.default_rng(1), 150, 1063, 0.5)
    assert heap.factor is not None
    found = sf.solve(heap, tol=1e-4)
    assert found.solved
    assert found.iterations < 5000


LAWFUL = np.array([0.3, 0.0, -1.0])
WANTED = np.array([-0.3, 0.0, 1.0])
"""A contact on the unit matrix that sticks, and its force."""
LOST = {"approaches": [0.0, 0.0, -1.0], "degenerate": [1.0, 0.0, 0.5 - 1e-5]}
"""Free velocities of a contact that no force moves; the second is unlawful by 1e-5 under the convex law."""


def joined(law: str, free: list[float], **options: Any) -> sf.ContactProblem:
    G = np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    return sf.ContactProblem(G, np.concatenate([LAWFUL, free]), 0.5, law=law, **options)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("options", [{}, {"facets": 8}])
def test_a_part_without_solution_leaves_the_others_theirs(law: str, options: dict[str, Any]) -> None:
    for name, free in LOST.items():
        problem = joined(law, free, **options)
        found = sf.solve(problem)
        np.testing.assert_allclose(found.forces[0], WANTED, atol=1e-7)
        if name == "approaches":
            assert found.status is sf.Status.INFEASIBLE
            assert found.proof is not None
            checked = sf.check_proof(problem, found.proof.direction)
            assert checked is not None
            assert checked.conclusive
        path = sf.ContactSolver(2, 0.5, law, **options)
        answer = path.solve(problem.G, problem.g)
        np.testing.assert_allclose(answer.forces[0], WANTED, atol=1e-7)
        assert answer.status is found.status


def test_hardly_degenerate_parts_are_both_solved() -> None:
    """The second contact is unlawful by 1e-12: within the tolerance, as alone."""
    found = sf.solve(joined("convex", [1.0, 0.0, 0.5 - 1e-12])).raise_if_failed()
    np.testing.assert_allclose(found.forces, [WANTED, np.zeros(3)], atol=1e-7)


def test_parts_of_contacts_of_any_kind() -> None:
    contacts = [sf.contact_sets.SoftFinger(0.5, 0.02), sf.contact_sets.SoftFinger(0.5, 0.02)]
    G, g = np.diag([1.0] * 4 + [0.0] * 4), np.array([0.3, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0])
    found = sf.solve(sf.ContactProblem(G, g, contacts=contacts))
    assert found.status is sf.Status.INFEASIBLE
    np.testing.assert_allclose(found.forces[:4].ravel()[:4], [-0.3, 0.0, 1.0, 0.0], atol=1e-6)


def test_many_parts_one_of_them_lost() -> None:
    """Sixty contacts of twenty bodies, one of them squeezed by walls: the other nineteen are solved."""
    rng = np.random.default_rng(2)
    G, g = np.zeros((180, 180)), rng.normal(size=180)
    for k in range(20):
        J = rng.normal(size=(9, 12))
        G[9 * k : 9 * k + 9, 9 * k : 9 * k + 9] = J @ J.T
    G[:9, :9] = 0.0
    g[2] = -1.0
    found = sf.solve(sf.ContactProblem(G, g, 0.4))
    assert found.status is sf.Status.INFEASIBLE
    rest = sf.ContactProblem(G[9:, 9:], g[9:], 0.4)
    assert sf.residuals(rest, found.forces[3:]).worst <= 1e-8


def squeezed(contacts: int) -> sf.ContactProblem:
    """A body between floor and ceiling that close: no forces help, in hundreds of redundant contacts."""
    rng = np.random.default_rng(0)
    places = rng.normal(size=(contacts, 3)) * [0.2, 0.2, 0.0]
    J = np.zeros((3 * contacts, 6))
    for k, (x, y, _) in enumerate(places):
        up = 1.0 if k % 2 == 0 else -1.0
        R, z = np.diag([1.0, up, up]), -0.1 * up
        J[3 * k : 3 * k + 3] = np.hstack([R, -R @ [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]])
    g = J @ rng.normal(size=6)
    g[2::3] -= 0.5
    return sf.ContactProblem(J @ J.T, g, 0.5)


def test_where_a_path_is_never_met_no_other_one_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts that contradict each other: there is no path, and four of them took two thirds of the time."""
    tried: list[int] = []
    follow = CentralPath.follow_unequally

    def count(path: CentralPath, *rest: Any) -> bool:
        before = path.done
        met = follow(path, *rest)
        tried.append(path.done - before)
        assert not met
        return met

    monkeypatch.setattr(CentralPath, "follow_unequally", count)
    assert sf.solve(squeezed(30)).status == sf.Status.INFEASIBLE
    assert tried == [MOST_UNMET]


@pytest.mark.parametrize("contacts", [30, 64, 200, 450])
def test_contradictions_are_proven_before_the_methods_wear_out(contacts: int) -> None:
    found = sf.solve(squeezed(contacts))
    assert found.status is sf.Status.INFEASIBLE
    assert found.iterations < 3000  # sweeps and steps: 34,000 where the proof comes last


@pytest.mark.parametrize("places", [[0], [1], [0, 2], [0, 1, 3], [3]])
def test_a_proof_comes_last_of_a_problem_that_is_nearly_solved(
    places: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def stage_of(stage: plans.PlanStage, *given: Any) -> None:
        asked.append(stage.name)

    monkeypatch.setattr(auto, "try_stage", stage_of)
    plan = tuple(plans.PlanStage(plans.PROOF if k in places else f"method {k}") for k in range(4))
    problem = sf.ContactProblem(np.eye(3), [0.0, 0.0, -1.0], 0.5)
    settings = SolverSettings(1e-12, None, np.inf)
    others = [stage.name for stage in plan if stage.name != plans.PROOF]
    for force, wanted in ((1.0 - 1e-9, [*others, plans.PROOF]), (0.5, None)):
        asked.clear()
        auto._run(problem, settings, np.array([[0.0, 0.0, force]]), 0, plan, working_time())
        assert asked.count(plans.PROOF) == 1
        assert wanted is None or asked == wanted


def test_only_forces_that_run_away_are_doubted_early(monkeypatch: pytest.MonkeyPatch) -> None:
    """A look for a proof in the middle of a heap's solve took a seventh of it, and found nothing.

    Under heavy bodies the forces of light ones are large: a whole look took half of the solve.
    """
    looks: list[tuple[int, bool]] = []
    monkeypatch.setattr(auto, "find_proof", lambda problem, _, plain: looks.append((problem.contacts, plain)))

    def rest_of_the_plan(*_: Any) -> Any:
        raise NotImplementedError

    monkeypatch.setattr(auto, "_run", rest_of_the_plan)
    heap = capsules(np.random.default_rng(1), 60, 276, 0.5, push=0.01)
    drawn = rocks(np.random.default_rng([0, 77]), 100, 463, 0.6, 1e3)
    mixed = sf.ContactProblem(drawn.G, drawn.g, drawn.mu)
    for problem, most in ((heap, 100), (squeezed(200), 100), (mixed, 2000)):
        with pytest.raises(NotImplementedError):
            sf.solve(problem, max_iterations=most)
    assert looks == [(200, False), (463, True)]


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_rocks_of_mixed_masses_are_solved_where_nobody_knows_the_bodies(seed: int) -> None:
    """Seven seconds of everything else ended above 1e-6."""
    drawn = rocks(np.random.default_rng([seed, 77]), 100, 463, 0.6, 1e3)
    found = sf.solve(sf.ContactProblem(drawn.G, drawn.g, drawn.mu), tol=1e-6)
    assert found.solved
    assert judge(drawn, found.forces) <= 1e-6


def test_the_clock_stands_still_while_kernels_are_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    before = working_time()
    event.start_event("numba:compiler_lock")
    time.sleep(0.05)
    event.end_event("numba:compiler_lock")
    assert working_time() - before < 0.04
    problem = squeezed(64).replace(g=np.tile([0.1, 0.0, -1.0], 64) * np.repeat(np.arange(64) % 2 == 0, 3))
    sf.solve(problem)  # what is not loaded yet
    alternate = on_blocks.alternate

    def compiles_first(*given: Any) -> Any:
        event.start_event("numba:compiler_lock")
        time.sleep(1.2)
        event.end_event("numba:compiler_lock")
        return alternate(*given)

    monkeypatch.setattr(on_blocks, "alternate", compiles_first)
    found = sf.solve(problem, max_time=1.0, max_iterations=5)
    assert found.status is not sf.Status.MAX_TIME


def bricks(contacts: int) -> sf.ContactProblem:
    """Few bodies on many contacts: interior point, Newton and ADMM all come to it."""
    rng = np.random.default_rng(contacts)
    J = rng.normal(size=(3 * contacts, contacts))
    return sf.ContactProblem(J @ J.T, J @ rng.normal(size=contacts), 0.5)


@pytest.mark.parametrize("problem", [bricks(12), bricks(60), bricks(140), squeezed(30), squeezed(140)])
@pytest.mark.parametrize("most", [20, 400, 2000])
def test_iterations_alone_decide(
    problem: sf.ContactProblem, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A loaded machine is one whose clock runs away: hours pass between any two looks at it."""
    before = sf.solve(problem.replace(), tol=1e-12, max_iterations=most)
    hours = itertools.count(step=3600.0)
    for name, module in list(sys.modules.items()):
        if name.startswith("surefoot.contact") and hasattr(module, "working_time"):
            monkeypatch.setattr(module, "working_time", lambda: next(hours))
    after = sf.solve(problem.replace(), tol=1e-12, max_iterations=most)
    assert after.status is before.status
    assert after.iterations == before.iterations
    np.testing.assert_array_equal(after.forces, before.forces)
