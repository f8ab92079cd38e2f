"""`surefoot course`: stubs, grades, and files that cannot be graded."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import pytest

from surefoot.app.cli.main import main
from surefoot.app.course.exercises import TITLES, solution_text


def grade(number: str, text: str, folder: Path, *more: str) -> int:
    """Grade a text as a file of a folder."""
    (folder / "mine.py").write_text(text, encoding="utf-8")
    return main(["course", number, "--check", str(folder / "mine.py"), *more])


def test_all_exercises_are_listed_in_both_languages(printed: Any) -> None:
    said = printed("course")
    assert all(number in said and en in said and zh in said for number, (en, zh) in TITLES.items())


def test_a_students_way(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "mine.py"
    assert main(["course", "52.2.1"]) == 0
    assert main(["course", "52.2.1", "--stub", str(mine)]) == 0
    assert "corners, rows, errors" in capfd.readouterr().out
    assert main(["course", "52.2.1", "--check", str(mine)]) == 1
    assert "it is not written yet" in capfd.readouterr().out
    assert main(["course", "52.2.1", "--stub", str(mine)]) == 2  # nobody's work is overwritten
    assert "is left as it is" in capfd.readouterr().err
    assert grade("52.2.1", solution_text("52.2.1").replace("mu / np.cos(np.pi / k)", "mu"), tmp_path) == 1
    said = capfd.readouterr().out
    assert '"sides of the outer pyramid touch the circle" fails at corners(' in said
    assert "expected" in said
    assert "不成立：“外切棱锥的边与圆相切”（corners(" in said
    assert "边到中心的距离为 [" in said
    assert "5 条性质中 3 条成立" in said
    assert main(["course", "52.2.1", "--solution", str(tmp_path / "theirs.py")]) == 0
    assert main(["course", "52.2.1", "--check", str(tmp_path / "theirs.py")]) == 0
    assert "5 of 5 properties hold" in capfd.readouterr().out


def test_json_and_seeds(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    wrong = solution_text("52.1.1").replace("np.tan", "np.sin") + "\nprint('mine')\n"
    calls = set()
    for seed in ("0", "1", "0"):
        assert grade("52.1.1", wrong, tmp_path, "--json", "--seed", seed) == 1
        out, err = capfd.readouterr()
        facts = json.loads(out)  # what the file prints is no part of it
        assert "mine" in err
        assert facts["right"] is False
        (failed,) = (one for one in facts["properties"] if not one["holds"])
        calls.add(failed["call"])
    assert len(calls) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("def f(:\n", "line 1: invalid syntax"),
        ("import math\n\nmath.nothing\n", "line 3: AttributeError"),
        ("import sys\nsys.exit(3)\n", "it exits with 3"),
        ("import os\nos._exit(0)\n", "ended by itself, with code 0, before its functions"),
        ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n", "SIGSEGV"),
        ("input()\n", "EOFError"),
        ("\0", "null bytes"),
    ],
)
def test_a_file_that_does_not_run_is_bad_input(
    text: str, said: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert grade("52.1.1", text, tmp_path) == 2
    err = capfd.readouterr().err
    assert said in err
    assert "mine.py" in err
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["52.2.9"], "52.2.9"),
        (["52.2.1", "--check", "nowhere.py"], "does not exist"),
        (["52.2.1", "--check", "/dev/zero"], "is no file"),
        (["52.2.1", "--check", "."], "is no file"),
        (["--check", "mine.py"], "say which exercise"),
        (["52.2.1", "--check", "a.py", "--stub", "b.py"], "give one of them"),
        (["52.2.1", "--stub", "no/such/folder/mine.py"], "mine.py"),
    ],
)
def test_wrong_words(words: list[str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["course", *words]) == 2
    assert said in capfd.readouterr().err


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf"])
def test_a_time_limit_is_a_number_of_seconds(
    limit: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert grade("52.1.1", "", tmp_path, f"--time-limit={limit}") == 2
    assert "time limit" in capfd.readouterr().err


@pytest.mark.long
def test_what_hangs_is_ended(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    start = time.monotonic()
    assert grade("52.1.1", "while True: pass\n", tmp_path, "--time-limit", "1") == 2
    assert "no answer within 1 s" in capfd.readouterr().err
    hangs = solution_text("52.1.1").replace(
        "    return float(np.tan", "    while True: pass\n    return float(np.tan"
    )
    assert grade("52.1.1", hangs, tmp_path, "--time-limit", "6") == 1
    assert "fails at least_mu(" in capfd.readouterr().out
    assert time.monotonic() - start < 60.0


def test_it_runs_as_python_would_and_nothing_else(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Its own imports are found; files that only have names of ours are not run by the grading."""
    for name in ("surefoot", "numpy", "json", "conftest", "sitecustomize"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'a').write({name!r})\n")
    (tmp_path / "friction.py").write_text("import math\n\ndef tan(x): return math.tan(x)\n")
    text = (
        solution_text("52.1.1")
        .replace("np.tan(", "friction.tan(")
        .replace("import numpy", "import friction\nimport numpy")
    )
    text += "\nimport sys\nassert __name__ == '__main__' and sys.argv == [__file__]\n"
    text += "if __name__ == '__main__':\n    sys.exit(0)\n"
    before = os.getcwd()
    os.chdir(tmp_path)
    try:
        assert grade("52.1.1", text, tmp_path) == 0
    finally:
        os.chdir(before)
    capfd.readouterr()
    assert not (tmp_path / "ran").exists()
    assert not (tmp_path / "__pycache__" / "mine.cpython-311.pyc").exists()


def test_a_process_that_it_leaves_behind_is_ended(tmp_path: Path) -> None:
    text = "import subprocess\nchild = subprocess.Popen(['sleep', '300'])\n"
    text += f"open({str(tmp_path / 'pid')!r}, 'w').write(str(child.pid))\n"
    assert grade("52.1.1", text + solution_text("52.1.1"), tmp_path) == 0
    pid = int((tmp_path / "pid").read_text())
    for _ in range(100):
        try:
            state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
        except OSError:
            return
        if state == "Z":
            return
        time.sleep(0.05)
    pytest.fail("it runs on")
