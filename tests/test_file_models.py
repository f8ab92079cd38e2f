"""What a file's model refuses is one line: the place, what is wanted there, what is, what may be meant."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NotRequired

import pytest
from pydantic import Field, with_config
from typing_extensions import TypedDict

from surefoot.base.errors import ProblemError
from surefoot.base.file_models import FILE, TUPLE, WHOLE, YAML, AnyNumber, Name, Number, read_as, schema_of
from tests.test_startup import run


@with_config(FILE)
class Foot(TypedDict):
    """One foot."""

    mu: Annotated[float, Field(ge=0), YAML]
    place: Annotated[tuple[Number, ...], Field(min_length=3, max_length=3), TUPLE]
    kind: NotRequired[Literal["point", "patch"]]


@with_config(FILE)
class Robot(TypedDict, total=False):
    """A robot."""

    name: Name
    mass: Number
    most: AnyNumber
    steps: Annotated[int, Field(ge=1, le=64), WHOLE]
    round: bool
    load: Number | None
    gains: Number | list[Number] | dict[str, Number]
    mode: Literal["auto"] | Annotated[float, Field(ge=0, le=1), YAML]
    feet: list[Foot]
    more: dict[str, Foot]


FOOT = {"mu": 0.6, "place": [0, 0, 0]}


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (
            None,
            "the file must be a mapping of the keys name, mass, most, steps, round, load, gains, mode, feet",
        ),
        ({1: 2}, "the file must be a mapping of the keys name"),
        ({"mas": 1}, "the file: unknown key 'mas'; valid names: feet, gains, load, mass, mode, more, most"),
        ({"mas": 1, "mass": "x"}, "did you mean mass?"),
        ({"qqq": 1}, "round, steps"),
        ({"mass": True}, "mass must be a number, got True"),
        ({"mass": "1.0"}, "mass must be a number, got '1.0'"),
        ({"mass": "1e"}, "mass must be a number, got '1e'"),
        ({"mass": None}, "mass must be a number, got None"),
        ({"mass": float("nan")}, "mass is NaN"),
        ({"mass": float("-inf")}, "mass is infinite"),
        ({"mass": "1e999"}, "mass is infinite"),
        ({"mass": 10**400}, "mass must be a number, got 1000"),
        ({"steps": 0}, "steps must be a whole number from 1 to 64, got 0"),
        ({"steps": 1.5}, "steps must be a whole number from 1 to 64, got 1.5"),
        ({"steps": True}, "steps must be a whole number from 1 to 64, got True"),
        ({"round": 1}, "round must be true or false, got 1"),
        ({"name": False}, "name must be a text, got False"),
        ({"gains": "stiff"}, "gains must be a number, a list or a mapping of names, got 'stiff'"),
        ({"gains": [1, "a"]}, "gains[1] must be a number, got 'a'"),
        ({"gains": {"hip": [1]}}, "gains: hip must be a number, got [1]"),
        ({"mode": "atuo"}, "mode must be a number from 0 to 1, got 'atuo'; valid names: auto"),
        ({"feet": {}}, "feet must be a list, got {}"),
        ({"feet": [FOOT, 3]}, "feet[1] must be a mapping of the keys mu, place, kind, got 3"),
        ({"feet": [{"mu": 1}]}, "feet[0]: place is missing"),
        ({"feet": [{**FOOT, "pos": 1}]}, "feet[0]: unknown key 'pos'; valid names: kind, mu, place"),
        ({"feet": [{**FOOT, "mu": "-1e0"}]}, "feet[0]: mu must be a number >= 0, got '-1e0'"),
        ({"feet": [{**FOOT, "place": [1, 2]}]}, "feet[0]: place must be a list of 3 entries, got [1, 2]"),
        ({"feet": [{**FOOT, "kind": "ptach"}]}, "feet[0]: unknown kind 'ptach'; valid names: patch, point"),
        ({"more": {"a\nb": {}}}, r"more.a\nb: mu is missing"),
        ({"more": {3: FOOT}}, "more must be a mapping of names, got {3"),
    ],
)
def test_what_is_wrong_is_one_line(content: Any, told: str) -> None:
    with pytest.raises(ProblemError) as refused:
        read_as(Robot, content)
    assert told in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_what_a_file_says_is_what_is_read() -> None:
    said = {"name": 3, "mass": "1e3", "most": float("inf"), "steps": 4.0, "gains": {"hip": 2}, "mode": "5e-1"}
    assert read_as(Robot, said) == {**said, "name": "3", "mass": 1000.0, "steps": 4, "mode": 0.5}
    assert read_as(Robot, {"feet": [FOOT], "load": None}) == {
        "feet": [{**FOOT, "place": (0, 0, 0)}],
        "load": None,
    }
    assert read_as(Robot, {}) == {}


def test_an_entry_is_called_as_one_says_it() -> None:
    for content, told in (
        ({"feet": [{**FOOT, "mu": -1}]}, "feet[0] mu must be a number >= 0, got -1"),
        ({"feet": [{"mu": 1}]}, "feet[0] needs the key 'place'"),
        (
            {"feet": [{**FOOT, "plaec": 1}]},
            "unknown key of feet[0] 'plaec'; valid names: kind, mu, place; did you",
        ),
        ([1], "the file must be a mapping of keys, got [1]"),
    ):
        with pytest.raises(ProblemError) as refused:
            read_as(Robot, content, spoken=True)
        assert str(refused.value).startswith(told)


def test_a_schema_has_the_bounds_and_no_names_of_ours() -> None:
    schema = schema_of(Robot)
    assert schema["properties"]["steps"] == {"maximum": 64, "minimum": 1, "type": "integer"}
    assert "title" not in schema["$defs"]["Foot"]
    assert schema["additionalProperties"] is False


def test_pydantic_is_loaded_where_a_file_is_read_and_not_before(tmp_path: Any) -> None:
    code = f"""
import sys, numpy as np, surefoot as sf
from surefoot.app.cli.main import main
main(["--help"])
import surefoot.app.cli.stand, surefoot.app.cli.walk, surefoot.app.export
import surefoot.mechanics.stance, surefoot.motion.policy.spec
from surefoot.records.log.mapping import LogMapping
from surefoot.worlds.sweep import config
path = sf.Log({{"time": np.arange(3.0)}}, {{"mass": 1.0}}).save({str(tmp_path / "a.npz")!r})
sf.read_log(path).fact("mass")
print("pydantic" in sys.modules)
"""
    assert run(code).splitlines()[-1] == "False"
