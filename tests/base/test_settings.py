"""Settings: fields of frozen dataclasses with unit, meaning, limits and source."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from surefoot.base.errors import ProblemError
from surefoot.base.settings import (
    JUDGEMENT,
    Settings,
    bounded_number,
    check_settings,
    describe,
    info_of,
    setting,
)

COMMAND = "`python -m benchmarks.limits laws.pull`, 2026-11-25"


@dataclass(frozen=True)
class Inner(Settings):
    share: float = setting(0.5, "m g", "share of the weight", low=0.0, high=1.0, tuned=COMMAND)


@dataclass(frozen=True)
class Outer(Settings):
    gain: float = setting(2.0, "1/s", "rate of the error", low=0.0)
    rows: int = setting(3, "-", "rows in a row", low=1)
    quick: bool = setting(True, "-", "whether the first answer is taken")
    name: str = setting("trot", "-", "gait at the start")
    longest: float = setting(math.inf, "s", "longest stance", low=0.0, high=math.inf)
    height: float | None = setting(None, "m", "height of the base; None for the robot's own", low=0.0)
    inner: Inner = field(default_factory=Inner)


def test_a_value_is_described_with_its_own_numbers() -> None:
    found = {one.name: one for one in describe(Outer(gain=4, inner=Inner(0.25)))}
    assert list(found) == ["gain", "rows", "quick", "name", "longest", "height", "inner.share"]
    assert found["gain"].value == 4.0
    assert found["inner.share"].value == 0.25
    assert (found["gain"].info.unit, found["gain"].info.source) == ("1/s", JUDGEMENT)
    assert found["inner.share"].info.measured
    assert not found["gain"].info.measured
    assert [one.value for one in describe(Outer)] == [2.0, 3, True, "trot", math.inf, None, 0.5]


def test_numbers_are_stored_in_the_type_of_the_default() -> None:
    made = Outer(gain=4, rows=5.0, height=1)  # type: ignore[arg-type]
    assert [type(x) for x in (made.gain, made.rows, made.height)] == [float, int, float]
    assert replace(made, gain=1.0).rows == 5


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"gain": -1.0}, r"gain must be a number >= 0, got -1"),
        ({"gain": math.nan}, r"gain must be a number >= 0, got nan"),
        ({"gain": math.inf}, r"gain must be finite, got inf"),
        ({"gain": True}, r"gain must be a number, got True"),
        ({"gain": "fast"}, r"gain must be a number, got 'fast'"),
        ({"gain": None}, r"gain must be a number, got None"),
        ({"rows": 2.5}, r"rows must be a whole number .*, got 2.5"),
        ({"rows": 0}, r"rows must be a number >= 1, got 0"),
        ({"quick": 1}, r"quick must be True or False, got 1"),
        ({"name": 3}, r"name must be a text, got 3"),
    ],
)
def test_what_is_not_allowed_is_named_with_what_is(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ProblemError, match=said):
        Outer(**given)
    with pytest.raises(ProblemError, match=r"share must be a number between 0 and 1, got 1\.5"):
        Inner(1.5)


def test_a_setting_without_unit_meaning_or_source_is_refused() -> None:
    for unit, meaning in (("", "share"), ("m", "")):
        with pytest.raises(ProblemError, match="a setting needs a unit and a meaning"):
            setting(1.0, unit, meaning)
    for source in ("", "by hand", "`make bench`", "2026-11-25"):
        with pytest.raises(ProblemError, match="tuned must be a command with a date, or 'judgement"):
            setting(1.0, "m", "height", tuned=source)


def test_a_number_of_a_user_is_checked_and_tuned_by_nobody() -> None:
    @dataclass(frozen=True)
    class Trial:
        mass: float = bounded_number(1, 0.0, 2.0, "kg")
        name: str = "box"

        def __post_init__(self) -> None:
            check_settings(self)

    assert Trial(0.5).mass == 0.5
    with pytest.raises(ProblemError, match="mass must be a number between 0 and 2, got 3"):
        Trial(3.0)
    info = info_of(Trial, "mass")
    assert info is not None
    assert (info.unit, info.source) == ("kg", "")
    assert info_of(Trial, "name") is None


def test_several_numbers_of_one_setting_are_checked_one_by_one() -> None:
    @dataclass(frozen=True)
    class Weights(Settings):
        linear: tuple[float, float] = setting((2.0, 3.0), "-", "weights", low=0.0)

    assert Weights().linear == (2.0, 3.0)
    assert Weights(linear=[1, 4]).linear == (1.0, 4.0)  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match=r"linear\[1\]"):
        Weights(linear=(1.0, -1.0))
    with pytest.raises(ProblemError, match="linear"):
        Weights(linear=(1.0, 2.0, 3.0))  # type: ignore[arg-type]
