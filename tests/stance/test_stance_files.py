"""Stance files read back what was written, and say what is wrong with them."""

from pathlib import Path

import numpy as np
import pytest

from surefoot import PatchContact, PointContact, ProblemError, Stance, can_stand, read_stance, write_stance
from surefoot.stance import StanceQuestion

EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "stances").glob("*.yaml"))


def test_round_trip(tmp_path):
    tilted = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    stance = Stance(
        [
            PointContact([0.1, 0.2, 0.3], tilted, 0.7, "a", normal_min=1.0, normal_max=90.0),
            PatchContact([1, 2, 3], 0.2, 0.1, tilted, 0.5, "b", heading=[0.3, 1.0, 0.0]),
        ]
    )
    push = np.arange(6.0)
    asked = StanceQuestion("test", stance, 12.5, np.array([0.0, 0.1, 0.9]), push)
    back = read_stance(write_stance(asked, tmp_path / "s.yaml"))
    assert (back.name, back.mass, back.com.tolist()) == ("test", 12.5, [0.0, 0.1, 0.9])
    np.testing.assert_array_equal(back.external_wrench, push)
    for old, new in zip(stance, back.stance, strict=True):
        assert type(old) is type(new)
        assert (old.name, old.mu, old.normal_min, old.normal_max) == (
            new.name,
            new.mu,
            new.normal_min,
            new.normal_max,
        )
        np.testing.assert_array_equal(old.position, new.position)
        np.testing.assert_allclose(old.rotation_world_contact, new.rotation_world_contact, atol=1e-15)
    assert (back.stance.contacts[1].length, back.stance.contacts[1].width) == (0.2, 0.1)


def test_nothing_is_overwritten(tmp_path):
    asked = StanceQuestion("test", Stance([]), 1.0, np.zeros(3))
    write_stance(asked, tmp_path / "s.yaml")
    with pytest.raises(ProblemError, match="cannot write"):
        write_stance(asked, tmp_path / "s.yaml")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_examples_can_be_read_and_stood_on(path):
    asked = read_stance(path)
    assert asked.name
    verdict = can_stand(asked.stance, asked.com, asked.mass, asked.external_wrench)
    assert verdict
    assert verdict.verify()


GOOD = "mass: 10\ncom: [0, 0, 0.5]\ncontacts:\n  - {name: a, position: [0, 0, 0]}\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "must be a mapping"),
        ("- 1\n", "must be a mapping"),
        ("mass: [\n", "not YAML"),
        ("com: [0, 0, 0]\n", "mass is missing"),
        (GOOD.replace("mass: 10", "mass: -1"), "mass must be positive"),
        (GOOD.replace("mass: 10", "mass: heavy"), "mass must be a number"),
        (GOOD.replace("[0, 0, 0.5]", "[0, 0]"), "com must have shape"),
        (GOOD.replace("[0, 0, 0.5]", "[0, 0, .nan]"), r"com\[2\] is NaN"),
        (GOOD.replace("name: a", "nmae: a"), r"contacts\[0\]: unknown key 'nmae'; valid names"),
        (GOOD.replace("name: a", "normal: [0, 0, 2]"), r"contacts\[0\]: normal must have length 1"),
        (GOOD.replace("name: a", "length: 0.1"), "a patch needs length and width"),
        (GOOD.replace("position: [0, 0, 0]", "mu: 0.5"), r"contacts\[0\]: position is missing"),
        (GOOD.replace("name: a", "mu: -3"), r"contacts\[0\]: mu"),
        (GOOD + "colour: red\n", "unknown key 'colour'"),
        ("mass: 1\ncom: [0, 0, 0]\ncontacts: 3\n", "contacts must be a list"),
    ],
)
def test_what_is_wrong_is_named_with_the_file(tmp_path, text, message):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ProblemError, match=f"(?s)bad.yaml.*{message}"):
        read_stance(path)


def test_missing_and_binary_files(tmp_path):
    with pytest.raises(ProblemError, match="cannot read"):
        read_stance(tmp_path / "none.yaml")
    (tmp_path / "b.yaml").write_bytes(bytes(range(128, 256)))
    with pytest.raises(ProblemError, match="cannot read"):
        read_stance(tmp_path / "b.yaml")


def test_no_contacts_is_a_stance_that_cannot_stand(tmp_path):
    (tmp_path / "air.yaml").write_text("mass: 10\ncom: [0, 0, 1]\n")
    asked = read_stance(tmp_path / "air.yaml")
    assert len(asked.stance) == 0
    assert not can_stand(asked.stance, asked.com, asked.mass)
