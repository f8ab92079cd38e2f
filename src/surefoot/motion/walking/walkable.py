"""Which robots can walk: refusals that say what it would take."""

from __future__ import annotations

from surefoot.base.errors import ModelError
from surefoot.base.spatial import rotation_from_quaternion
from surefoot.mechanics import Robot, leg_rank

DIRECTIONS = 6
"""Of a sole: three along which it moves, three about which it turns."""
LEAST_UP = 0.866
"""Cosine of the base's z axis and the vertical, of 30 degrees."""


def check_upright(robot: Robot) -> None:
    """Refuse a robot whose base has another axis than z up: falls and leans are measured by it.

    Raises
    ------
    ModelError
        If that axis is more than 30 degrees off the vertical in the nominal pose.
    """
    if robot.floating and rotation_from_quaternion(robot.nominal[3:7])[2, 2] < LEAST_UP:
        raise ModelError(
            f"{robot.name} cannot stand or walk here: the z axis of its base does not point up where it "
            "stands, and falls are told by it. Give it a base link whose z axis does (a fixed joint turns "
            "the rest)"
        )


def _check_free(robot: Robot) -> None:
    """Refuse a robot that is bolted to the world."""
    if not robot.floating:
        raise ModelError(
            f"{robot.name} cannot walk here: its base is bolted to the world. One that walks has a free "
            "base: of an MJCF file a <freejoint/> in its first body, of a URDF fixed_base=False"
        )


def check_point_feet(robot: Robot) -> None:
    """Refuse a robot that cannot walk on point feet.

    Raises
    ------
    ModelError
        Without a free base, with fewer than three feet, or with soles.
    """
    check_upright(robot)
    _check_free(robot)
    flat = sum(foot.flat for foot in robot.feet)
    if len(robot.feet) > 2 and not flat:
        return
    lines = [
        f"{robot.name} cannot walk here: that takes three or more point feet, "
        f"it has {len(robot.feet)}{f', {flat} of them flat' if flat else ''}"
    ]
    if len(robot.feet) == 2 and flat < 2:
        pointed = next(foot for foot in robot.feet if not foot.flat)
        lines.append(
            "on two feet it takes soles, which points do not have (a box, a mesh or four spheres under each "
            f"foot). {pointed.why}"
        )
    raise ModelError("; ".join(lines))


def check_soles(robot: Robot) -> None:
    """Refuse a robot that cannot walk on two soles.

    Raises
    ------
    ModelError
        Without a free base or two soles, or with legs that cannot lay their soles level wherever they step.
    """
    _check_free(robot)
    if len(robot.feet) != 2 or not all(f.flat for f in robot.feet):
        raise ModelError(f"{robot.name} cannot walk here: it needs two flat feet")
    check_upright(robot)
    for foot in robot.feet:
        rank = leg_rank(robot.model, foot.frame)
        if rank < DIRECTIONS:
            raise ModelError(
                f"{robot.name} cannot walk here: the leg of {foot.name} moves its sole in {rank} of 6 "
                "directions, and a level sole under a body that sways takes all 6, so an ankle that pitches "
                "and rolls. Standing takes less: surefoot stand"
            )
