"""Short questions on a machine that has compiled nothing: Python answers them, as compiled code would."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.compilation import cold_start as module
from surefoot.base.compilation import compiled_so_far
from surefoot.base.compilation.cold_start import ColdStart
from surefoot.base.compilation.uncounted import borrowed, keep, window

ROOT = Path(__file__).parents[3]
STANCES = ROOT / "examples" / "stances"
PROGRAM = """
from surefoot.base.compilation.numba_internals import compiled, entry_point

@compiled
def inverse(x, power=1.0):
    return 1.0 / x**power

@compiled
def applied(f, x):
    return f(x)

@compiled
def total(a, out):
    out[0] += 1.0
    for k in range(a.size):
        out[0] += inverse(a[k]) + applied(inverse, a[k])
    return out[0]

@compiled
def twice(x):
    return inverse(x) + inverse(x)

@compiled
def long_total(a, out):
    for k in range(a.size):
        out[0] += twice(a[k])
    return out[0]

@compiled
def by_parts(a, parts):
    parts[0][0] += 1.0
    return 1.0 / (float(a[0]) * 1)
"""


@pytest.fixture
def kernels(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return kernels that nobody has compiled, and let Python run them."""
    import numba

    file = tmp_path / "cold.py"
    file.write_text(PROGRAM)
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "kept"))
    names: dict[str, Any] = {"__name__": "cold"}
    exec(compile(PROGRAM, str(file), "exec"), names)
    start = ColdStart()
    start.allow(60.0)
    monkeypatch.setattr("surefoot.base.compilation.numba_internals.cold_start", start)
    return names | {"start": start}


def test_python_runs_a_kernel_all_kernels_below_it_and_those_it_is_given(kernels: Any) -> None:
    before, out = compiled_so_far(), np.zeros(1)
    assert kernels["total"](np.array([1.0, 2.0, 4.0]), out) == 1.0 + 2 * 1.75
    assert kernels["inverse"](4.0) == 0.25
    assert compiled_so_far() == before
    assert 0.0 < kernels["start"].seconds < 60.0
    assert not kernels["start"].inside


def test_an_entry_point_runs_as_python_too(kernels: Any) -> None:
    import numba

    call = kernels["entry_point"](kernels["total"], (numba.float64[::1], numba.float64[::1]))
    before = compiled_so_far()
    assert call(np.ones(2), np.zeros(1)) == 5.0
    assert compiled_so_far() == before


def test_what_python_refuses_is_compiled_and_finds_its_arrays_as_they_were(kernels: Any) -> None:
    before, part = compiled_so_far(), np.zeros(1)
    assert kernels["by_parts"](np.zeros(2), (part,)) == np.inf  # Python divides no float by zero
    assert part[0] == 1.0
    assert compiled_so_far() == before + 1
    assert not kernels["start"].allowed


def test_a_kernel_that_takes_too_long_is_compiled(kernels: Any) -> None:
    kernels["start"].allow(0.02)
    before, out = compiled_so_far(), np.zeros(1)
    assert kernels["long_total"](np.ones(3_000_000), out) == 6_000_000.0
    assert compiled_so_far() == before + 1


def test_nothing_runs_as_python_unless_a_program_asks() -> None:
    assert not module.cold_start.allowed


def test_uncounted_arrays_are_counted_ones_in_python() -> None:
    given = np.arange(6.0)
    assert borrowed(given) is given
    window(given, 2, 2, 2)[1, 1] = 9.0
    assert given[5] == 9.0
    assert keep(given) is None


def answer(command: list[str], **environment: str) -> Any:
    """Return what a command says as JSON; a slow or busy machine may have to compile after all."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src"), **environment}
    words = [sys.executable, "-m", "surefoot", *command, "--json"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert all(line.startswith("surefoot: compiling") for line in done.stderr.splitlines())
    return json.loads(done.stdout)


def agree(one: Any, two: Any, where: str = "") -> None:
    """Compare what two runs say."""
    if isinstance(one, dict):
        assert one.keys() == two.keys()
        for name in one.keys() - {"seconds", "picture", "seconds_per_solve"}:
            agree(one[name], two[name], f"{where} {name}")
    elif isinstance(one, list):
        assert len(one) == len(two)
        for a, b in zip(one, two, strict=True):
            agree(a, b, where)
    elif isinstance(one, float):
        assert one == pytest.approx(two, rel=1e-5, abs=1e-6), where
    else:
        assert one == two, where


def problem_file(folder: Path, contacts: int = 4) -> str:
    """Write a problem of some contacts."""
    random = np.random.default_rng(contacts)
    jacobian, g = random.normal(size=(3 * contacts, 18)), random.normal(size=3 * contacts)
    return str(sf.write_problem(sf.ContactProblem(jacobian @ jacobian.T, g, 0.6), folder / "problem.npz"))


@pytest.mark.parametrize("command", ["check", "solve"])
@pytest.mark.long
def test_a_command_compiles_nothing_and_says_the_same(command: str, tmp_path: Path) -> None:
    asked = [problem_file(tmp_path)] if command == "solve" else [str(STANCES / "go2_three_legs.yaml")]
    words = [command, *asked, *(["--no-picture"] if command == "check" else [])]
    kept = tmp_path / "kept"
    agree(answer(words, NUMBA_CACHE_DIR=str(kept)), answer(words))
    assert not list(kept.rglob("*.nbc"))


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "stance"),
    [
        ("check", "chimney.yaml"),
        ("check", "go2_three_legs.yaml"),
        ("check", "g1_hand_on_wall.yaml"),
        ("region", "slope.yaml"),
    ],
)
def test_every_stance_is_told_the_same(command: str, stance: str, tmp_path: Path) -> None:
    words = [command, str(STANCES / stance), "--no-picture"]
    agree(answer(words, NUMBA_CACHE_DIR=str(tmp_path)), answer(words))


QUESTIONS = """
import json, sys
import numpy as np
from surefoot.base.compilation import compiled_so_far
from surefoot.base.compilation.cold_start import cold_start
if sys.argv[1] == "cold":
    cold_start.allow(1e9)
import surefoot as sf
said = []
for seed in range(40):  # solved, impossible, frictionless, of all scales
    random = np.random.default_rng(seed)
    n = int(random.integers(1, 7))
    J, g = random.normal(size=(3 * n, 6 if seed % 2 else 18)), random.normal(size=3 * n)
    g *= 10.0 ** random.uniform(-4.0, 3.0)
    mu = 0.0 if seed % 7 == 0 else 10.0 ** random.uniform(-2.0, 1.0)
    found = sf.solve(sf.ContactProblem(J @ J.T, g, mu))
    said.append([found.status.value, found.solver, float(np.linalg.norm(found.velocities))])
for seed in range(25):
    random = np.random.default_rng(seed)
    normals = random.normal(size=(int(random.integers(1, 5)), 3)) + [0.0, 0.0, 2.0]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    feet = [sf.PointContact(random.normal(size=3), n, mu=random.uniform()) for n in normals]
    stance, com = sf.Stance(feet), 0.3 * random.normal(size=3)
    verdict = sf.can_stand(stance, com, 10.0)
    said.append([verdict.feasible, verdict.status, verdict.margin, sf.friction_needed(stance, com, 10.0)])
assert sys.argv[1] == "warm" or compiled_so_far() == 0
print(json.dumps(said))
"""


@pytest.mark.long
def test_hard_questions_are_answered_the_same(tmp_path: Path) -> None:
    """Warnings are errors: what compiled code computes in silence Python must, too."""
    said = []
    for way in ("cold", "warm"):
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
        if way == "cold":
            environment["NUMBA_CACHE_DIR"] = str(tmp_path)
        words = [sys.executable, "-W", "error", "-c", QUESTIONS, way]
        done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        said.append(json.loads(done.stdout))
    agree(*said)
