"""A sweep over a function of one's own: loaded from beside the file, only where code is allowed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import surefoot as sf

CODE = """
import surefoot as sf

def run(values):
    feet = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.15, -0.15)]
    stance = sf.Stance([sf.PointContact(p, mu=values["mu"]) for p in feet])
    verdict = sf.can_stand(stance, [values["x"], 0.0, 0.3], values["mass"])
    return {"margin": verdict.margin, "stood": verdict.feasible, "said": values["kind"]}
"""
FILE = """
experiment: own_stand:run
samples: 16
settings: {mass: 15.0}
ranges:
  mu: [0.3, 0.9]
  x: [0.0, 0.4]
  kind: [a, b]
"""


@pytest.fixture
def sweep(tmp_path: Path) -> Path:
    (tmp_path / "own_stand.py").write_text(CODE)
    (tmp_path / "own.yaml").write_text(FILE)
    return tmp_path / "own.yaml"


@pytest.mark.parametrize("backend", ["serial", "loky"])
@pytest.mark.long
def test_a_function_is_swept_in_this_process_and_in_others(sweep: Path, tmp_path: Path, backend: str) -> None:
    pytest.importorskip("pyarrow")
    config = sf.read_sweep(sweep, allow_code=True)
    table = sf.run_sweep(config, tmp_path / backend, backend=backend).table.to_pydict()
    assert set(table["status"]) == {"done"}
    assert table["stood"] == [x < 0.2 for x in table["x"]]  # the support polygon
    assert {*table["said"]} == {"a", "b"}
    assert config.experiment.goal == "stood"


def test_another_function_is_another_sweep(sweep: Path) -> None:
    one = sf.read_sweep(sweep, allow_code=True).fingerprint()
    assert sf.read_sweep(sweep, allow_code=True).fingerprint() == one
    (sweep.parent / "own_other.py").write_text(CODE.replace("0.15", "0.16"))
    sweep.write_text(FILE.replace("own_stand", "own_other"))
    assert sf.read_sweep(sweep, allow_code=True).fingerprint() != one


def test_code_is_run_only_where_that_is_allowed(sweep: Path, printed: Any) -> None:
    (sweep.parent / "own_stand.py").write_text("raise SystemExit('it ran')")
    assert "is code, which would be run: allow it with --allow-code" in printed("sweep", sweep, code=2)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("def run", "def other", "own_stand has no function 'run'"),
        ("import surefoot", "import nonsuch", "own_stand cannot be loaded: ModuleNotFoundError"),
        ('"stood": verdict.feasible, ', "", "must return a True or False among its results"),
        ("return {", "return 3 #", "must return a dict of results, got 3"),
        ('values["kind"]', "None", "the result .said. must be a number, a text or True or False, got None"),
        ('values["mass"]', 'values["weight"]', "failed when tried: KeyError: 'weight'"),
    ],
)
def test_what_is_no_experiment_is_named(sweep: Path, old: str, new: str, said: str) -> None:
    module = f"own_{abs(hash(said))}"  # each is loaded once in a process
    (sweep.parent / f"{module}.py").write_text(CODE.replace(old, new))
    sweep.write_text(FILE.replace("own_stand", module))
    with pytest.raises(sf.ProblemError, match=said.replace("own_stand", module)):
        sf.read_sweep(sweep, allow_code=True)
