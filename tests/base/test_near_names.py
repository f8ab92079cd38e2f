"""A name that is nearly right is answered with the right one: in Python and on the command line."""

from __future__ import annotations

import pytest

import surefoot as sf
from surefoot.app.cli.main import main
from surefoot.base.errors import near_name


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("trott", " (did you mean trot?)"),
        ("TROT", " (did you mean trot?)"),
        ("gallop", ""),
        (3, ""),
        ("", ""),
    ],
)
def test_a_near_name(name: object, hint: str) -> None:
    assert near_name(name, ["trot", "walk"]) == hint


def test_names_of_the_package() -> None:
    with pytest.raises(AttributeError, match=r"'FrictionCon' \(did you mean FrictionCone\?\)"):
        _ = sf.FrictionCon
    with pytest.raises(AttributeError, match=r"did you mean PointContact, SoleContact or ContactProblem\?\)"):
        _ = sf.Contact
    with pytest.raises(AttributeError, match=r"did you mean picture or ANSWER\.plot\(\)\?\)"):
        _ = sf.plot
    with pytest.raises(AttributeError, match=r"did you mean FrictionCone, StanceCone or wrench_cone\?\)"):
        _ = sf.Cone
    with pytest.raises(AttributeError, match=r"has no attribute 'zebra'$"):
        _ = sf.zebra


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["chek"], "No such command 'chek' (did you mean check?)"),
        (["check", "got2"], "did you mean go2?"),
        (["cone", "--facet", "4"], "--facets"),
    ],
)
def test_the_command_line(words: list[str], hint: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert hint in capsys.readouterr().err


def test_a_cone_without_friction_says_what_is_true(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cone", "--mu", "0", "--no-picture"]) == 0
    said = capsys.readouterr().out
    assert "one ray, the normal" in said
    assert "f_x = f_y = 0 and f_z >= 0" in " ".join(said.split())
    assert "gives up" not in said
    assert "│" not in said  # no table of eight times the same ray
