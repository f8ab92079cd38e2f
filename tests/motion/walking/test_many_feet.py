"""Gaits for any number of point feet, from one rule: who steps when, and made-up robots that walk so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import surefoot as sf
from benchmarks.legged import leg_places, write_legged
from surefoot.base.errors import ModelError
from surefoot.motion.gaits.library import gait_names, patterns_of
from surefoot.motion.walking.walkers import default_gait, walking_controller


@pytest.mark.parametrize("feet", [3, 5, 6, 7, 8, 10])
def test_who_is_in_the_air(feet: int) -> None:
    """Wave: never more than one; ripple: one of a side; tripod: no two neighbours of a side, both halves."""
    names = gait_names(feet)
    assert names == (("stand", "wave") if feet < 5 else ("stand", "tripod", "ripple", "wave"))
    times = np.arange(0.0, 1.0, 1e-3)
    left = np.array([y >= 0.0 for _, y in leg_places(feet).values()])
    for name in names[1:]:
        gait = sf.named_gait(name, feet)
        air = ~gait.contacts(times * gait.period)
        assert air.any(axis=0).all()
        most = {"wave": 1, "ripple": 2, "tripod": (feet + 1) // 2}[name]
        assert air.sum(axis=1).max() <= most
        if name == "ripple":
            assert max(air[:, left].sum(axis=1).max(), air[:, ~left].sum(axis=1).max()) == 1
        if name == "tripod":
            assert not (air[:, :-2:2] & air[:, 2::2])[:, : feet // 2 - 1].any()


def test_phases_go_by_place_not_by_order() -> None:
    places = np.array(list(leg_places(6).values()))
    order = np.random.default_rng(0).permutation(6)
    for name, pattern in patterns_of(6, places).items():
        assert patterns_of(6, places[order])[name].offset == tuple(np.array(pattern.offset)[order])
        assert pattern == patterns_of(6)[name]  # the order that is taken without places


def robot_of(folder: Path, legs: int) -> sf.Robot:
    path, feet = write_legged(folder, legs)
    return sf.load_robot(path, feet=feet)


def walk(robot: sf.Robot, gait: str | None, speed: float, duration: float, seed: int = 0) -> sf.Log:
    controller = walking_controller(robot, sf.VelocityCommand.constant(speed), gait)
    return sf.run(sf.MujocoWorld(robot), controller, sf.Scenario(duration, 0.6, seed=seed))


@pytest.mark.long
def test_a_hexapod_walks_by_tripods(tmp_path: Path) -> None:
    robot = robot_of(tmp_path, 6)
    assert default_gait(robot) == "tripod"
    log = walk(robot, None, 0.4, 2.5)
    summary = sf.summarise_walk(log)
    assert summary.good
    assert summary.velocity.forward.measured == pytest.approx(0.4, rel=0.1)
    assert sf.audit_log(log).verdict == "lawful"


@pytest.mark.long
@pytest.mark.parametrize(
    ("legs", "gait", "speed"),
    [(3, "wave", 0.1), (5, "ripple", 0.3), (5, "tripod", 0.3), (6, "ripple", 0.3), (6, "wave", 0.2),
     (8, "tripod", 0.4), (8, "wave", 0.15)],
)  # fmt: skip
def test_others_walk_too(tmp_path: Path, legs: int, gait: str, speed: float) -> None:
    log = walk(robot_of(tmp_path, legs), gait, speed, 4.0)
    assert sf.summarise_walk(log).good
    assert sf.audit_log(log).verdict == "lawful"


@pytest.mark.long
@pytest.mark.parametrize(("legs", "seeds"), [(5, 10), (6, 20), (8, 10)])
def test_all_walks_by_tripods_but_one_are_lawful(tmp_path: Path, legs: int, seeds: int) -> None:
    robot, lawful = robot_of(tmp_path, legs), 0
    for seed in range(seeds):
        log = walk(robot, "tripod", 0.4 if legs > 5 else 0.3, 2.5, seed)
        lawful += sf.summarise_walk(log).good and sf.audit_log(log).verdict == "lawful"
    assert lawful >= seeds - 1, f"{legs} feet: {lawful} of {seeds} lawful"


def test_feet_that_cannot_stand_are_refused_before_the_run(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"legged2 cannot walk here: .* three or more point feet, it has 2"):
        walk(robot_of(tmp_path, 2), None, 0.3, 1.0)
    with pytest.raises(sf.ProblemError, match="unknown gait for 6 feet 'trot'; valid names: ripple, stand"):
        walk(robot_of(tmp_path, 6), "trot", 0.3, 1.0)
