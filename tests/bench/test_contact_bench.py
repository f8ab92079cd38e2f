from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from surefoot.bench.contact import Comparison, Run, compare, performance_profile, problems_in
from surefoot.bench.contact_rivals import pinocchio_calls, siconos_installed, siconos_runs
from surefoot.bench.problems import families, problem_set
from surefoot.cli.main import main
from surefoot.contact import residuals, write_problem
from surefoot.errors import ProblemError


def test_sets_have_the_promised_sizes() -> None:
    robot = problem_set("robot", copies=0.01)
    assert {p.family for p in robot} <= set(families("robot"))
    assert max(p.problem.contacts for p in robot) == 25
    assert all(p.problem.contacts <= 25 for p in robot)
    large = problem_set("large", copies=0.01)
    assert 500 <= max(p.problem.contacts for p in large) <= 620
    assert min(p.problem.contacts for p in large) >= 40
    with pytest.raises(ProblemError, match="unknown scale 'tiny'"):
        problem_set("tiny")


def test_no_problem_is_trivial() -> None:
    for named in problem_set("robot", copies=0.25):
        nothing = np.zeros((named.problem.contacts, 3))
        assert residuals(named.problem, nothing).natural_map > 1e-6, named.name


def test_profile_counts_shares() -> None:
    times = {"a": np.array([1.0, 4.0, np.inf]), "b": np.array([2.0, 1.0, np.inf])}
    found = performance_profile(times, np.array([1.0, 2.0, 4.0]))
    assert np.allclose(found["a"], [1 / 3, 1 / 3, 2 / 3])
    assert np.allclose(found["b"], [1 / 3, 2 / 3, 2 / 3])


def test_speed_up_is_a_geometric_mean_over_the_best_rival() -> None:
    def run(problem: str, solver: str, seconds: float, solved: bool = True) -> Run:
        return Run(problem, problem[0], 1, solver, seconds, 0.0 if solved else 1.0, solved)

    runs = (
        run("x1", "auto", 1.0), run("x1", "r", 9.0), run("x1", "s", 4.0),
        run("y1", "auto", 1.0), run("y1", "r", 1.0), run("y1", "s", 0.1, solved=False),
        run("y2", "auto", 1.0), run("y2", "r", 1.0, solved=False), run("y2", "s", 1.0, solved=False),
    )  # fmt: skip
    found = Comparison(1e-8, runs).speed_up(["r", "s"])
    assert found == pytest.approx({"x": 4.0, "y": 1.0, "all": 2.0, "least": 1.0, "no rival": 1.0})


def test_rivals_really_solve() -> None:
    pytest.importorskip("pinocchio")
    problem = problem_set("robot", copies=0.01)[0].problem
    for method in ("admm", "pgs"):
        gaps = [residuals(problem, call()).natural_map for call in pinocchio_calls(problem, 1e-8, method)]
        assert min(gaps) < 1e-8, method
        assert gaps[-1] <= gaps[0]


@pytest.mark.skipif(not siconos_installed(), reason="Siconos is not installed for the system's Python")
def test_siconos_in_its_own_process() -> None:
    problem = problem_set("robot", copies=0.01)[0].problem
    found = siconos_runs([problem], 1e-8)
    assert "siconos nsgs" in found
    gaps = [residuals(problem, forces).natural_map for _, forces in found["siconos nsgs"][0]]
    assert min(gaps) < 1e-8


def test_compare_certifies_everybody() -> None:
    problems = problem_set("robot", copies=0.01)[:3]
    found = compare(problems, 1e-8, ("auto", "nsgs"), rivals=False)
    assert found.solvers == ("auto", "nsgs")
    assert all(r.solved and r.residual <= 1e-8 and r.seconds > 0 for r in found.runs if r.solver == "auto")


def test_command_writes_json_and_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source = tmp_path / "files"
    source.mkdir()
    write_problem(problem_set("robot", copies=0.01)[0].problem, source / "cube.dat")
    code = main(["bench", "contact", str(source), "--copies", "0.01", "--no-rivals", "--solver", "auto",
                 "--out", str(tmp_path / "runs"), "--json"])  # fmt: skip
    record = json.loads(capsys.readouterr().out)
    assert code == 0
    assert {r["problem"] for r in record["runs"]} >= {"cube.dat", "cube-sticking-0"}
    folder = next((tmp_path / "runs").iterdir())
    assert {f.name for f in folder.iterdir()} == {"contact.json", "profile.png"}
    assert (folder / "profile.png").stat().st_size > 10_000


def test_folders_without_problems_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="no contact problems"):
        problems_in(tmp_path)
    with pytest.raises(ProblemError, match="no such folder"):
        problems_in(tmp_path / "none")
