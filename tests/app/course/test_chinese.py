"""What a check says has its Chinese: every sentence of the sources, and what wrong answers are told."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from surefoot.app import course
from surefoot.app.course.chinese import chinese, sentences
from surefoot.app.course.exercises import solution_text
from tests.app.course.test_exercises import failures
from tests.app.course.wrong_answers import WRONG

SOURCES = Path(course.__file__).parent
PLACE = {"holds": 1, "expect": 1, "near": 2, "PropertyError": 0}
"""Which argument of a call is the sentence."""


def template(node: ast.expr) -> str | None:
    """Return a text with `{}` for its values; None for what is no text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(str(p.value) if isinstance(p, ast.Constant) else "{}" for p in node.values)
    return None


def written() -> set[str]:
    """Return the sentences that stand in the sources."""
    found = set()
    for path in [*SOURCES.glob("*.py"), *(SOURCES / "properties").glob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            name = getattr(node.func, "id", "") if isinstance(node, ast.Call) else ""
            if isinstance(node, ast.Call) and name in PLACE and len(node.args) > PLACE[name]:
                found.add(template(node.args[PLACE[name]]))
    return {sentence for sentence in found if sentence is not None}


def test_every_sentence_is_in_the_table() -> None:
    assert len(written()) > 180
    missing = {one for one in written() if chinese(one) == one}
    assert missing == set()


def test_a_translation_has_the_values_of_its_sentence() -> None:
    for english, translated in sentences().items():
        count = english.count("{}")
        filled = translated.format(*(f"<{k}>" for k in range(count)))
        assert sorted(re.findall("<.>", filled)) == [f"<{k}>" for k in range(count)], english


def test_values_stay_and_sentences_within_sentences_are_translated() -> None:
    assert chinese("the area is 1.5, expected [2.0, 3.0]") == "面积为 1.5，应为 [2.0, 3.0]"
    assert chinese("it returns the shape (2,), expected one number") == "返回的形状为 (2,)，应为一个数"
    assert chinese("it raises ValueError: no (line 7)") == "抛出异常 ValueError: no（第 7 行）"
    assert chinese("the process ended by the signal SIGSEGV") == "进程被信号 SIGSEGV 终止"
    assert chinese("it says True, but 97% of the friction of 5.0 N is used") == (
        "答案是 True，而法向力 5.0 N 下摩擦用去 97%"
    )
    assert chinese("unheard of") == "unheard of"


@pytest.mark.parametrize("number", WRONG)
def test_a_wrong_answer_is_told_in_chinese(number: str) -> None:
    old, new = next(iter(WRONG[number].values()))
    for words, _, said in failures(number, solution_text(number).replace(old, new)):
        for text in (chinese(words), chinese(said)):
            assert re.search(r"[\u4e00-\u9fff]", text), text
