"""Option values with a form of their own: pushes, ice, lifts, velocities, terrains, facets, lists of feet."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeVar

from surefoot.control.standing_plan import Lift
from surefoot.errors import ProblemError
from surefoot.simulation.run import Ice, Push
from surefoot.simulation.walk_terrain import rough_ground
from surefoot.stance import FlatTerrain, SlopeTerrain, StairsTerrain, Terrain

T = TypeVar("T")


def number(option: str, text: str) -> float:
    """Return a finite number.

    Raises
    ------
    ProblemError
        Naming the option, if it is not one.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ProblemError(f"{option}: {text!r} is not a finite number")
    return value


def push(text: str) -> Push:
    """Return the push of "T:FX,FY,FZ:DURATION".

    >>> push("1:60,0,0:0.2")
    Push(start=1.0, force=(60.0, 0.0, 0.0), duration=0.2)
    """
    parts = text.split(":")
    force = parts[1].split(",") if len(parts) == 3 else []
    if len(force) != 3:
        raise ProblemError(f"--push {text!r} is not of the form T:FX,FY,FZ:DURATION, e.g. 1:60,0,0:0.2")
    start, duration = number("--push", parts[0]), number("--push", parts[2])
    if start < 0.0 or duration <= 0.0:
        raise ProblemError(f"--push {text!r}: T must be >= 0 and DURATION > 0")
    x, y, z = (number("--push", f) for f in force)
    return Push(start, (x, y, z), duration)


def ice(text: str) -> Ice:
    """Return the change of friction of "T:MU"."""
    parts = text.split(":")
    if len(parts) != 2:
        raise ProblemError(f"--ice {text!r} is not of the form T:MU, e.g. 2:0.05")
    start, mu = number("--ice", parts[0]), number("--ice", parts[1])
    if start < 0.0 or mu < 0.0:
        raise ProblemError(f"--ice {text!r}: T and MU must be >= 0")
    return Ice(start, mu)


def lift(text: str) -> Lift:
    """Return the lifted foot of "FOOT:T0:T1"."""
    parts = text.split(":")
    if len(parts) != 3 or not parts[0]:
        raise ProblemError(f"--lift {text!r} is not of the form FOOT:T0:T1, e.g. FL:1:2")
    return Lift(parts[0], number("--lift", parts[1]), number("--lift", parts[2]))


def facets(text: str) -> int | None:
    """Return the number of facets, or None for "exact"."""
    if text == "exact":
        return None
    try:
        count = int(text)
    except ValueError:
        count = 0
    if count < 3:
        raise ProblemError(f"--facets must be a whole number >= 3 or 'exact', got {text!r}")
    return count


def names(text: str | None) -> list[str] | None:
    """Return the names of a comma-separated list, or None."""
    if text is None:
        return None
    return [name.strip() for name in text.split(",") if name.strip()]


def each(parse: Callable[[str], T], texts: list[str] | None) -> list[T]:
    """Return the parsed values of a repeatable option."""
    return [parse(text) for text in texts or []]


def velocity(text: str) -> tuple[float, float, float]:
    """Return forward, left [m/s] and yaw rate [rad/s] of "VX,VY,WZ"; missing ones are zero.

    >>> velocity("0.5")
    (0.5, 0.0, 0.0)
    """
    parts = text.split(",")
    if not 1 <= len(parts) <= 3:
        raise ProblemError(f"--velocity {text!r} is not of the form VX,VY,WZ, e.g. 0.5,0,0.2")
    x, y, turn = ([number("--velocity", p) for p in parts] + [0.0, 0.0])[:3]
    return x, y, turn


STAIRS = 10
"""Steps of the stairs of --terrain."""
TERRAINS = "flat, slope:DEG, stairs:HEIGHT,DEPTH, rough:SEED,HEIGHT"


def terrain(text: str) -> Terrain:
    """Return the terrain of "flat", "slope:DEG", "stairs:HEIGHT,DEPTH" or "rough:SEED,HEIGHT" [m].

    >>> terrain("slope:15")
    SlopeTerrain(15)
    """
    kind, _, rest = text.partition(":")
    values = [number("--terrain", part) for part in rest.split(",")] if rest else []
    if kind == "flat" and not values:
        return FlatTerrain()
    if kind == "slope" and len(values) == 1:
        return SlopeTerrain(values[0])
    if kind == "stairs" and len(values) == 2:
        return StairsTerrain(values[0], values[1], steps=STAIRS)
    if kind == "rough" and len(values) == 2 and values[0] >= 0.0 and values[0] == int(values[0]):
        return rough_ground(int(values[0]), values[1])
    raise ProblemError(f"--terrain {text!r} is not one of: {TERRAINS}")
