from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.app.cli.main import main


@pytest.fixture
def file(tmp_path: Path) -> Path:
    J = np.random.default_rng(0).normal(size=(6, 8))
    problem = sf.ContactProblem(J @ J.T, [0.2, 0.0, -1.0, 0.0, 0.1, -1.0], 0.5)
    return sf.write_problem(problem, tmp_path / "two.dat")


def test_table_and_exit_code(file: Path, printed: Any) -> None:
    out = printed("solve", file)
    assert "two.dat" in out
    assert "solved" in out
    assert "6/6" in out


def test_json_is_all_there_is(file: Path, answer: Any) -> None:
    records = answer("solve", file, file, "--solver", "nsgs", "--tol", "1e-10")
    assert [r["solver"] for r in records] == ["nsgs", "nsgs"]
    problem = sf.read_problem(file)
    assert sf.residuals(problem, records[0]["forces"]).velocity_error <= 1e-10


def test_unsolved_is_exit_code_one(file: Path) -> None:
    assert main(["solve", str(file), "--solver", "nsgs", "--tol", "0"]) == 1


@pytest.fixture
def lcp_files(tmp_path: Path) -> list[Path]:
    """One LCP with a solution and one without: z1 + z2 >= 1 cannot be where M = 0."""
    good, bad = tmp_path / "good.dat", tmp_path / "bad.dat"
    good.write_text("2\n0\n2\n2\n2 2\n2 1\n1 2\n-5 -6\n")
    bad.write_text("2\n0\n2\n2\n2 2\n0 0\n0 0\n-1 -1\n")
    return [good, bad]


def test_complementarity_problems(lcp_files: list[Path], printed: Any, answer: Any) -> None:
    good, bad = map(str, lcp_files)
    assert "lemke" in printed("solve", good)
    solved, failed = answer("solve", good, bad, code=1)
    assert np.allclose(solved["z"], [4 / 3, 7 / 3])
    assert (solved["kind"], solved["status"], failed["status"]) == ("lcp", "solved", "infeasible")
    v = np.array(failed["proof"])
    assert (v >= 0).all()
    assert v @ [-1.0, -1.0] < 0.0
    assert "proof v 1 " in printed("solve", bad, code=1)


def test_both_kinds_at_once(file: Path, lcp_files: list[Path], printed: Any, answer: Any) -> None:
    assert [r["kind"] for r in answer("solve", file, lcp_files[0])] == ["contact", "lcp"]
    assert printed("solve", lcp_files[0], "--solver", "interior_point")
    said = printed("solve", lcp_files[0], "--solver", "simplex", code=2)
    assert "unknown LCP solver 'simplex'; valid names: auto" in said
