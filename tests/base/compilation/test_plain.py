"""Kernels as ordinary `numba.njit`, from an empty cache: the same answers, kept for the next process."""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import surefoot
from surefoot.base.compilation import plain

ROOT = Path(__file__).parents[3]
SOURCES = Path(surefoot.__file__).parents[1]
FILES = {
    "below.py": """
from surefoot.base.kernels import inline_kernel, kernel, takes_kernels

FACTOR = {factor}

@inline_kernel
def scaled(x):
    return FACTOR * x

@kernel
@takes_kernels
def applied(f, a):
    total = 0.0
    for x in a:
        total += f(x)
    return total
""",
    "above.py": """
import json, sys
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple
import numpy as np
from surefoot.base import compilation, kernels
from surefoot.base.kernels import MATRIX, REAL, VECTOR, entry_point, kernel, releasing_kernel
from surefoot.base.kernels import borrowed, keep, window
import below

class Form(NamedTuple):
    of: object

FORM = Form(below.scaled)

@kernel
def through_a_tuple(a):
    return below.applied(FORM.of, a)

@kernel
def of_windows(a):
    memory = np.zeros(30)
    for turn in range(100):
        part, out = window(a, turn % 5, 2, 3), window(memory, 4, 3, 4)
        for i in range(2):
            for j in range(3):
                out[i, j] += part[i, j] / (borrowed(part)[0, 0] + 1.0)
    keep(memory)
    return memory

@releasing_kernel
def long_sum(a, times):
    total = 0.0
    for k in range(times):
        for x in a:
            total += x / (k + 1.0)
    return total

@kernel
def first(A, b, t):
    return A[0, 0] * b[0] / (t - 1.0)

@kernel
def given(a):
    return below.applied(below.scaled, a)

def main():
    a = np.random.default_rng(2).uniform(0.5, 1.0, (4, 6))
    with ThreadPoolExecutor(4) as four:
        sums = list(four.map(lambda k: long_sum(a[k], 1000), range(4)))
    fixed = a.copy()
    fixed.setflags(write=False)
    call = entry_point(first, MATRIX, VECTOR, REAL)
    values = [given(a[0]), through_a_tuple(a[1]), *of_windows(a), *sums]
    values += [call(fixed, a[0], 3), call(a, a[0], 1)]
    print(json.dumps({
        "values": values, "compiled": compilation.compiled_so_far(), "folders": compilation.cache_folders(),
        "private": "surefoot.base.compilation.numba_internals" in sys.modules,
    }))
""",
}


def answers(
    folder: Path, factor: float = 2.0, plain: str = "1", code: str = "import above; above.main()"
) -> dict[str, Any]:
    """Return what a new process computes by the kernels of two files."""
    for name, text in FILES.items():
        text, file = text.replace("{factor}", str(factor)), folder / name
        if not file.exists() or file.read_text() != text:  # older versions of Numba go by a file's time
            file.write_text(text)
    kept = {"NUMBA_CACHE_DIR": str(folder / "kept"), "PYTHONDONTWRITEBYTECODE": "1"}
    environment = os.environ | kept | {"SUREFOOT_PLAIN_NUMBA": plain}
    environment["PYTHONPATH"] = os.pathsep.join([str(folder), str(SOURCES)])
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.long
def test_answers_are_those_of_the_other_way_and_kept(tmp_path: Path) -> None:
    """Threads, folded kernels, kernels given to kernels, alone and in tuples, and parts of arrays' memory."""
    usual, first, later = (answers(tmp_path, plain=way) for way in "011")
    assert usual["private"] is True
    assert first["private"] is later["private"] is False
    assert np.array_equal(first["values"], usual["values"])
    assert np.array_equal(later["values"], usual["values"])
    assert first["values"][-1] == np.inf
    assert first["compiled"] > 6
    assert later["compiled"] == 0
    assert all(Path(folder).is_relative_to(tmp_path / "kept") for folder in later["folders"])


@pytest.mark.long
def test_code_of_a_callee_in_another_file_is_not_kept(tmp_path: Path) -> None:
    """Numba alone would go by the caller's file."""
    ask = "import above, json, numpy as np; print(json.dumps({'values': [above.given(np.ones(3))]}))"
    before, after, again = (answers(tmp_path, factor, code=ask)["values"] for factor in (2.0, 3.0, 2.0))
    assert (before, after, again) == ([6.0], [9.0], [6.0])


def test_old_folders_are_removed_but_for_the_newest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plain.numba.config, "CACHE_DIR", str(tmp_path))
    for age in range(6):
        folder = tmp_path / f"plain-{age}"
        folder.mkdir()
        os.utime(folder, (1000 - age, 1000 - age))
    new = plain._folder.__wrapped__(str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {"plain-0", "plain-1", "plain-2", Path(new).name}


def test_nowhere_to_write_is_no_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(plain, "_roots", lambda: [tmp_path / "file"])
    monkeypatch.setattr(plain, "_folder", plain._folder.__wrapped__)
    monkeypatch.setattr(plain, "_kernels", [])
    monkeypatch.setattr(logging.getLogger("surefoot.compilation"), "propagate", True)
    kernel = plain.compiled(lambda x: x + 1.0)
    assert kernel(1.0) == 2.0
    assert "not kept" in caplog.text
    assert plain.cache_folders() == []


@pytest.mark.long
@pytest.mark.parametrize("room", ["base/numerics", "contact/cones"])
def test_a_rooms_tests_pass(room: str, tmp_path: Path) -> None:
    environment = os.environ | {"SUREFOOT_PLAIN_NUMBA": "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"tests/{room}"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
