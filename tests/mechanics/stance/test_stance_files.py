"""Stance files are read as they are written down, and it is said what is wrong with them."""

from pathlib import Path

import numpy as np
import pytest

from surefoot import ProblemError, can_stand, read_stance

EXAMPLES = sorted((Path(__file__).parents[3] / "examples" / "stances").glob("*.yaml"))


def test_what_a_file_says_is_what_is_read(tmp_path):
    path = tmp_path / "s.yaml"
    path.write_text(
        "name: test\nmass: 12.5\ncom: [0, 0.1, 0.9]\nexternal_wrench: [0, 1, 2, 3, 4, 5]\ncontacts:\n"
        "  - {name: a, position: [1, 2, 3], normal: [0.6, 0, 0.8], mu: 0.7, normal_max: 90, normal_min: 1}\n"
        "  - {name: b, position: [1, 2, 3], length: 0.2, width: 0.1, heading: [0, 1, 0]}\n"
    )
    asked = read_stance(path)
    assert (asked.name, asked.mass, asked.com.tolist()) == ("test", 12.5, [0.0, 0.1, 0.9])
    np.testing.assert_array_equal(asked.external_wrench, np.arange(6.0))
    point, patch = asked.stance
    assert (point.name, point.mu, point.normal_min, point.normal_max) == ("a", 0.7, 1.0, 90.0)
    np.testing.assert_allclose(point.normal, [0.6, 0.0, 0.8])
    assert (patch.name, patch.mu, patch.sole.length, patch.sole.width) == ("b", 0.6, 0.2, 0.1)
    np.testing.assert_allclose(patch.rotation_world_contact[:, 0], [0.0, 1.0, 0.0])


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
        ("com: [0, 0, 0]\n", "mass is missing"),
        (GOOD.replace("mass: 10", "mass: -1"), "mass must be positive"),
        (GOOD.replace("mass: 10", "mass: heavy"), "mass must be a number"),
        (GOOD.replace("[0, 0, 0.5]", "[0, 0]"), "com must have shape"),
        (GOOD.replace("[0, 0, 0.5]", "[0, 0, .nan]"), r"com\[2\] is NaN"),
        (GOOD.replace("name: a", "nmae: a"), r"contacts\[0\]: unknown key 'nmae'; valid names"),
        (GOOD.replace("name: a", "normal: [0, 0, 2]"), r"contacts\[0\]: normal must have length 1"),
        (GOOD.replace("name: a", "length: 0.1"), "a sole needs length and width"),
        (GOOD.replace("position: [0, 0, 0]", "mu: 0.5"), r"contacts\[0\]: position is missing"),
        (GOOD.replace("name: a", "mu: -3"), r"contacts\[0\]: mu"),
        ("mass: 1\ncom: [0, 0, 0]\ncontacts: 3\n", "contacts must be a list"),
    ],
)
def test_what_is_wrong_is_named_with_the_file(tmp_path, text, message):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(ProblemError, match=f"(?s)bad.yaml.*{message}"):
        read_stance(path)


def test_binary_files(tmp_path):
    (tmp_path / "b.yaml").write_bytes(bytes(range(128, 256)))
    with pytest.raises(ProblemError, match="cannot read"):
        read_stance(tmp_path / "b.yaml")


def test_no_contacts_is_a_stance_that_cannot_stand(tmp_path):
    (tmp_path / "air.yaml").write_text("mass: 10\ncom: [0, 0, 1]\n")
    asked = read_stance(tmp_path / "air.yaml")
    assert len(asked.stance) == 0
    assert not can_stand(asked.stance, asked.com, asked.mass)
