"""Sweep files: what is read, what is refused and how."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from surefoot.base.errors import ProblemError
from surefoot.worlds.sweep import NumberRange, read_sweep, sweep_from_dict

DROP = {"experiment": "drop", "ranges": {"mu": [0.2, 0.8]}}


def drop(**ranges: Any) -> Any:
    return {"experiment": "drop", "ranges": ranges}


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ([], "the file must be a mapping"),
        ({}, "experiment is missing"),
        ({"experiment": "jump"}, "unknown experiment 'jump'; valid names: drop, walk"),
        ({**DROP, "sample": 3}, "unknown key 'sample'; valid names: experiment, maps"),
        ({**DROP, "samples": 0}, "samples must be a whole number >= 1, got 0"),
        ({**DROP, "samples": 2**31}, "at most 2"),
        ({**DROP, "seed": -1}, "seed must be a whole number >= 0, got -1"),
        ({**DROP, "settings": {"bdy": 1}}, "unknown setting of drop 'bdy'; valid names: body"),
        ({**DROP, "settings": {"body": "cat"}}, "unknown body 'cat'; valid names: ball, box"),
        ({**DROP, "settings": {"dt": 1.0}}, "dt must be a number between 1e-05 and 0.05, got 1"),
        ({**DROP, "settings": {"tumble": "yes"}}, "tumble must be true or false"),
        ({**DROP, "settings": 3}, "settings must be a mapping"),
        ({**DROP, "maps": [["mu", "mass"]]}, "maps: unknown drawn number 'mass'; valid names: mu"),
        ({**DROP, "maps": [["mu", "mu"]]}, "maps must be a list of pairs"),
        ({**DROP, "maps": [["mu", []]]}, "maps: unknown drawn number"),
        (drop(mue=[0, 1]), "unknown parameter 'mue'; valid names: body, body_mass"),
        (drop(tumble=True), "unknown parameter 'tumble'"),
        (drop(body=["box", "cat"]), "unknown body 'cat'; valid names: ball, box"),
        (drop(mu=[0.8, 0.2]), r"mu must have low <= high, got \[0.8, 0.2\]"),
        (drop(mu=[-0.1, 0.2]), "mu must be a number between 0 and 1000, got -0.1"),
        (drop(mu=[0.1, float("nan")]), "mu must be a number, got nan"),
        (drop(mu=[0.1]), r"mu must be \[low, high\], got \[0.1\]"),
        (drop(mu=True), "mu must be a number, got True"),
        (drop(mu={"low": 0.1}), "mu: high is missing"),
        (drop(mu={"low": 0.1, "high": 1, "scal": 1}), "mu: unknown key 'scal'"),
        (drop(mu={"low": 0.1, "high": 1, "scale": "cubic"}), "mu: unknown scale 'cubic'"),
        (drop(mu={"low": 0, "high": 1, "scale": "log"}), "a log scale needs low > 0, got 0"),
        (drop(stiffness=0), "stiffness must be a number between 0.001 and 1e[+]12, got 0"),
        (drop(damping=3), "damping goes with stiffness"),
        (drop(stiffness=1e4, restitution=0.2), "restitution is of rigid ground"),
        (drop(terrain="moon"), "terrain 'moon' is not one of: flat"),
        (drop(terrain="flat", slope=3), "terrain and slope are each a ground of their own"),
        ({"experiment": "walk", "ranges": {"stiffness": 1e4}}, "stiffness is of world rigid"),
        ({"experiment": "walk", "settings": {"world": "rigid"}, "ranges": {"time_constant": 0.1}},
         "time_constant is of world mujoco, the settings say world rigid"),
        ({"experiment": "walk", "settings": {"robot": "asimov"}}, "unknown robot 'asimov'"),
        ({"experiment": "walk", "settings": {"robot": "/etc/x.urdf"}}, "robot must be the name"),
        ({"experiment": "walk", "settings": {"world": ["rigid"]}}, "unknown world"),
        ({"experiment": "walk", "settings": {"world": "bullet", "armature": 1}}, "armature is of the worlds"),
        ({"experiment": "walk", "settings": {"gait": "hop"}}, "unknown gait 'hop'"),
        ({"experiment": "walk", "settings": {"robot": "g1"}}, "g1 cannot walk here"),
        ({"experiment": "walk", "settings": {"duration": 0.5}, "ranges": {"push_x": 9}},
         "push_time 1 s is after"),
    ],
)  # fmt: skip
def test_what_is_refused_is_named(content: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        sweep_from_dict(content)


def test_numbers_as_yaml_reads_them(tmp_path: Path) -> None:
    """YAML 1.1 takes 1e4 for a text: it is the number that was meant."""
    (tmp_path / "a.yaml").write_text("experiment: drop\nranges:\n  stiffness: [1e4, 1e6]\n  mu: 0.5\n")
    ranges = read_sweep(tmp_path / "a.yaml").space.ranges
    assert ranges["stiffness"] == NumberRange(1e4, 1e6)
    assert ranges["mu"] == NumberRange(0.5, 0.5)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("!!python/object/apply:os.system ['true']", "is not YAML: could not determine a constructor"),
        ("experiment: drop\nranges: {mu: [1, 0]}", r"a.yaml: mu must have low <= high"),
    ],
)
def test_files_that_are_no_sweep(text: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(ProblemError, match=told):
        read_sweep(tmp_path / "a.yaml")


def test_the_fingerprint_is_of_what_decides_the_results() -> None:
    one = sweep_from_dict({**DROP, "samples": 10})
    assert sweep_from_dict({**DROP, "samples": 99, "maps": []}).fingerprint() == one.fingerprint()
    for other in ({**DROP, "seed": 1}, {**DROP, "settings": {"size": 0.2}}, drop(mu=[0.2, 0.81])):
        assert sweep_from_dict(other).fingerprint() != one.fingerprint()
    assert one.with_numbers(3, 5).space.seed == 5
    assert one.with_numbers(None, None) == one
