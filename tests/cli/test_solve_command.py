from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from surefoot.cli.main import main


@pytest.fixture
def file(tmp_path: Path) -> Path:
    J = np.random.default_rng(0).normal(size=(6, 8))
    problem = sf.ContactProblem(J @ J.T, [0.2, 0.0, -1.0, 0.0, 0.1, -1.0], 0.5)
    return sf.write_problem(problem, tmp_path / "two.dat")


def test_table_and_exit_code(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(file)]) == 0
    out = capsys.readouterr().out
    assert "two.dat" in out
    assert "solved" in out
    assert "6/6" in out


def test_json_is_all_there_is(file: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(file), str(file), "--solver", "nsgs", "--tol", "1e-10", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [r["solver"] for r in records] == ["nsgs", "nsgs"]
    problem = sf.read_problem(file)
    assert sf.residuals(problem, records[0]["forces"]).natural_map <= 1e-10


def test_unsolved_is_exit_code_one(file: Path) -> None:
    assert main(["solve", str(file), "--solver", "nsgs", "--tol", "0"]) == 1


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.dat"], "no such file: none.dat"),
        (["FILE", "--solver", "simplex"], "unknown solver 'simplex'; valid names:"),
        (["FILE", "--solver", "lemke"], "takes pyramids only"),
        (["FILE", "--tol", "-1"], "tol"),
    ],
)
def test_bad_input_is_one_line(
    file: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["solve", *(str(file) if a == "FILE" else a for a in arguments)]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1
