"""Robots that tests share: each is loaded once in a process."""

from __future__ import annotations

from functools import cache

from surefoot.mechanics.robot import Robot, load_robot


@cache
def robot_of(name: str) -> Robot:
    """Return a robot of the catalogue, which no test may change."""
    return load_robot(name)


def go2() -> Robot:
    """Return the robot of most tests."""
    return robot_of("go2")
