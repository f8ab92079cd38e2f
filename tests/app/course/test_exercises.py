"""Each exercise tells right answers from wrong ones of the usual kind, by properties alone."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import yaml

from surefoot.app.course.answer import Answer
from surefoot.app.course.child import find_failure
from surefoot.app.course.exercises import TITLES, functions_of, solution_text, stub_text
from surefoot.app.course.properties import properties_of
from tests.app.course.wrong_answers import WRONG

ROOT = Path(__file__).resolve().parents[3]
CASES = [(number, name) for number, wrong in WRONG.items() for name in wrong]


def functions(text: str) -> dict[str, Any]:
    """Return what a file defines."""
    module = ModuleType("answer")
    exec(compile(text, "answer.py", "exec"), vars(module))
    return vars(module)


def failures(number: str, text: str, seed: int = 0) -> list[tuple[str, str, str]]:
    """Return properties that fail, the last call of each, and what was said."""
    answer, out = Answer(functions(text), "answer.py"), []
    for place, one in enumerate(properties_of(number)):
        if (said := find_failure(answer, one, [seed, place])) is not None:
            out.append((one.words, answer.last, said))
    return out


def test_they_are_the_chapters() -> None:
    contents = yaml.safe_load((ROOT / "course" / "contents.yaml").read_text(encoding="utf-8"))
    assert [*TITLES] == [*contents["exercises"]] == [*WRONG]
    assert len(TITLES) == 24


@pytest.mark.parametrize("number", TITLES)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
def test_the_solution_has_all_properties(number: str, seed: int) -> None:
    assert failures(number, solution_text(number), seed) == []


@pytest.mark.parametrize(("number", "name"), CASES)
@pytest.mark.sampled(60)
def test_a_wrong_answer_lacks_one(number: str, name: str) -> None:
    old, new = WRONG[number][name]
    text = solution_text(number)
    assert text.count(old) >= 1, "the solution has changed"
    for seed in (0, 1):
        found = failures(number, text.replace(old, new), seed)
        assert found, "it passes"
        assert all(call.partition("(")[0] in functions_of(number) and said for _, call, said in found)


def single(value: Any) -> Any:
    """Return numbers in single precision, as a student's tensors have them."""
    if isinstance(value, tuple):
        return tuple(map(single, value))
    array = np.asarray(value)
    return array.astype(np.float32) if array.dtype == float else value


def listed(value: Any) -> Any:
    """Return arrays and tuples as lists."""
    if isinstance(value, tuple):
        return [listed(one) for one in value]
    return value.tolist() if hasattr(value, "tolist") else value


def upright(value: Any) -> Any:
    """Return lists of numbers as columns, and a number as an array of one."""
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype != bool:
        return value[:, None]
    return np.array([value]) if isinstance(value, float | bool | np.bool_) else value


@pytest.mark.parametrize("form", [single, listed, upright])
@pytest.mark.parametrize("number", TITLES)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2))])
@pytest.mark.sampled(36)
def test_a_right_answer_may_come_in_another_form(number: str, form: Callable[[Any], Any], seed: int) -> None:
    plain = functions(solution_text(number))  # whose functions call each other as they were written
    own = {name: lambda *given, right=plain[name]: form(right(*given)) for name in functions_of(number)}
    answer = Answer(own, "answer.py")
    found = [find_failure(answer, one, [seed, place]) for place, one in enumerate(properties_of(number))]
    assert not any(found), (answer.last, found)


@pytest.mark.parametrize("number", TITLES)
def test_a_stub_says_what_to_write_and_nothing_of_how(number: str) -> None:
    text = stub_text(number)
    names = functions_of(number)
    defined = functions(text)
    assert all(callable(defined[name]) and defined[name].__doc__ for name in names)
    assert text.count("raise NotImplementedError") == len(names)
    assert "return" not in [
        line.split()[0] for line in text.splitlines() if line.startswith("    ") and line.strip()
    ]
    assert any("\u4e00" <= letter <= "\u9fff" for letter in text)
    assert {"it is not written yet"} == {said for _, _, said in failures(number, text)}


@pytest.mark.parametrize(
    ("returns", "said"),
    [
        ("None", "not numbers"),
        ("'0.5'", "expected numbers of the shape"),
        ("np.full(2, np.nan)", "not finite"),
        ("(1.0, 2.0, 3.0)", "expected numbers of the shape (2,)"),
        ("np.array(1 + 2j)", "not numbers"),
        ("1 / 0", "ZeroDivisionError: division by zero (line 3)"),
        ("exit(0)", "SystemExit"),
        ("[].pop()", "IndexError"),
    ],
)
def test_whatever_is_returned_is_told_in_a_line(returns: str, said: str) -> None:
    text = f"import numpy as np\ndef errors(k, fit):\n    return {returns}\n"
    found = {call.partition("(")[0]: message for _, call, message in failures("52.2.1", text)}
    assert said in found["errors"]
    assert "\n" not in found["errors"]
    assert found["corners"] == "there is no such function in the file"


def test_an_answer_cannot_spoil_its_input() -> None:
    text = solution_text("52.4.1").replace(
        "    total = np.cumsum(angles)\n", "    total = np.cumsum(angles)\n    angles[:] = 0.0\n"
    )
    assert failures("52.4.1", text) == []
