"""Each property of an exercise finds by itself what it is for, and says so, in narrowly wrong answers."""

from __future__ import annotations

import pytest

from surefoot.app.course.answer import Answer
from surefoot.app.course.child import find_failure
from surefoot.app.course.exercises import solution_text
from surefoot.app.course.properties import properties_of
from tests.app.course.narrow_answers import NARROW, Narrow
from tests.app.course.test_exercises import functions


def found_by(wrong: Narrow, seed: int) -> str:
    """Return what a property says of an answer, "" where it passes."""
    text = solution_text(wrong.number)
    assert wrong.old in text, "the solution has changed"
    (place,) = [
        k for k, one in enumerate(properties_of(wrong.number)) if one.words.startswith(wrong.property)
    ]
    one = list(properties_of(wrong.number))[place]
    answer = Answer(functions(text.replace(wrong.old, wrong.new)), "answer.py")
    return find_failure(answer, one, [seed, place]) or ""


@pytest.mark.parametrize("wrong", NARROW, ids=lambda w: f"{w.number} {w.property}, {w.words}")
def test_a_narrowly_wrong_answer_is_found_by_the_property_it_lacks(wrong: Narrow) -> None:
    for seed in (0, 1):
        assert wrong.words in found_by(wrong, seed)
