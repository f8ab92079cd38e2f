from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.contact.accuracy import ASKED, accuracy_paths, draw_accuracy
from benchmarks.contact.accuracy import OURS as OURS_IN_PICTURE
from benchmarks.contact.comparison import (
    Comparison,
    Run,
    compare,
    copies_of,
)
from benchmarks.contact.methods import LEVELS, cells
from benchmarks.contact.ours import CONTACT_SOLVER
from benchmarks.contact.rivals import DENSE, SPARSE, PinocchioCall, best_call, matrix
from benchmarks.contact.siconos_rival import siconos_best, siconos_installed
from benchmarks.problems.contacts import NamedProblem, families, problem_set
from benchmarks.problems.judge import DECADES, STEPS_PER_DECADE, coarsest, judge
from surefoot.base.errors import ProblemError
from surefoot.contact.files.formats import write_problem
from surefoot.contact.problem import ContactProblem


@cache
def large_problems() -> list[NamedProblem]:
    return problem_set("large", copies=0.01)


@pytest.mark.long
def test_sets_have_the_promised_sizes() -> None:
    robot = problem_set("robot", copies=0.01)
    assert {p.family for p in robot} <= set(families("robot"))
    assert max(p.problem.contacts for p in robot) == 25
    assert all(p.problem.contacts <= 25 for p in robot)
    large = large_problems()
    assert 500 <= max(p.problem.contacts for p in large) <= 620
    assert min(p.problem.contacts for p in large) >= 40
    with pytest.raises(ProblemError, match="unknown scale 'tiny'"):
        problem_set("tiny")


def test_speed_up_is_a_geometric_mean_over_the_best_rival() -> None:
    def run(problem: str, solver: str, seconds: float, solved: bool = True) -> Run:
        return Run(problem, problem[0], 1, solver, seconds, 0.0 if solved else 1.0, solved)

    runs = (
        run("x1", "auto", 1.0), run("x1", "r", 9.0), run("x1", "s", 4.0),
        run("y1", "auto", 1.0), run("y1", "r", 1.0), run("y1", "s", 0.1, solved=False),
        run("y2", "auto", 1.0), run("y2", "r", 1.0, solved=False), run("y2", "s", 1.0, solved=False),
    )  # fmt: skip
    found = Comparison(1e-8, runs).speed_up(["r", "s"])
    assert found == pytest.approx(
        {"x": 4.0, "y": 1.0, "all": 2.0, "least": 1.0, "lost": 0.0, "no rival": 1.0}
    )


def test_the_coarsest_sufficient_tolerance_is_found() -> None:
    for limit in (-0.4, 0.0, 1.3, -2.55, 2.0):
        tried: list[float] = []

        def attempt(step: float, limit: float = limit, tried: list[float] = tried) -> float | None:
            tried.append(step)
            return step if step <= 10.0**limit * (1 + 1e-9) else None

        found = coarsest(attempt, lambda: True)
        assert found is not None
        assert limit - 1.0 / STEPS_PER_DECADE < np.log10(found) <= limit + 1e-6
        assert len(tried) <= len(DECADES) + np.log2(STEPS_PER_DECADE)
    assert coarsest(lambda _: None, lambda: True) is None
    assert coarsest(lambda step: step if step < 1.0 else None, lambda: False) is None


@pytest.mark.parametrize("name", [*DENSE, *SPARSE])
def test_rivals_really_solve_ready_and_with_a_new_matrix(name: str) -> None:
    pytest.importorskip("pinocchio")
    setting = {**DENSE, **SPARSE}[name]
    problem = problem_set("robot", copies=0.01)[1].problem  # of a sliding cube: PGS 1.6 fails on others
    other = copies_of(problem)[-1]
    call, least = best_call(problem, setting, 1e-8)
    assert call is not None
    assert judge(problem, call.ready()) <= 1e-8
    assert least <= 1e-8
    tight = PinocchioCall(problem, setting, call.tol / 100.0, 20_000)
    assert judge(other, tight.fresh((matrix(other, setting), other.g))) <= 1e-8
    assert judge(problem, tight.ready()) <= 1e-8  # the operator has kept nothing of the other problem


@pytest.mark.skipif(not siconos_installed(), reason="Siconos is not installed for the system's Python")
def test_siconos_in_its_own_process() -> None:
    problem = problem_set("robot", copies=0.01)[0].problem
    found = siconos_best([problem], 1e-8)
    assert {"siconos nsgs", "siconos newton", "siconos admm"} == set(found)
    best, least = found["siconos nsgs"][0]
    assert best is not None
    assert least == judge(problem, best.forces) <= 1e-8
    assert 0.0 < best.solve < best.fresh


def test_compare_certifies_everybody() -> None:
    problems = problem_set("robot", copies=0.01)[:3]
    found = compare(problems, 1e-8, ("auto", "nsgs"), rivals=False)
    assert found.solvers == ("auto", "nsgs", CONTACT_SOLVER)
    assert found.ours_fresh == CONTACT_SOLVER
    assert all(r.solved and r.residual <= 1e-8 and r.seconds > 0 for r in found.runs if r.solver == "auto")


@pytest.mark.long
def test_command_writes_json_and_pictures(tmp_path: Path, answer: Any) -> None:
    source = tmp_path / "files"
    source.mkdir()
    write_problem(problem_set("robot", copies=0.01)[0].problem, source / "cube.dat")
    options = ["--copies", "0.01", "--no-rivals", "--solver", "auto", "--out", tmp_path / "runs"]
    record = answer("bench", "contact", source, *options)
    assert {r["problem"] for r in record["runs"]} >= {"cube.dat", "cube-sticking-0"}
    folder = next((tmp_path / "runs").iterdir())
    assert {f.name for f in folder.iterdir()} == {"contact.json"}


def test_accuracy_over_time_asks_for_more_and_more(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    J = rng.normal(size=(12, 6))
    problem = ContactProblem(J @ J.T, J @ rng.normal(size=6), 0.5)
    paths = list(accuracy_paths("thrown", problem, with_rivals=False))
    assert [path.solver for path in paths] == list(OURS_IN_PICTURE)
    best = paths[0]
    assert len(best.seconds) == len(best.errors) == len(ASKED)
    assert (best.errors <= ASKED).all()
    assert (best.seconds > 0.0).all()
    pytest.importorskip("matplotlib")
    assert draw_accuracy(paths, tmp_path / "accuracy.png").stat().st_size > 10_000


def test_auto_is_compared_with_its_methods_at_each_accuracy() -> None:
    found = list(cells("cube", problem_set("robot", copies=0.01)[0].problem))
    assert [cell.level for cell in found] == list(LEVELS)
    assert all(cell.ratio > 0.0 and cell.method != "auto" for cell in found)
