"""Option values with a form of their own: pushes, ice, lifts, velocities, lists of feet."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from surefoot.base.arrays import real_number
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import finite_in_text

if TYPE_CHECKING:  # loading a simulation takes longer than most commands
    from surefoot.motion.standing.standing_plan import Lift
    from surefoot.worlds.running.scenario import Ice, IcePatch, Push

MU_MAX = 1e3
"""Friction beyond which nothing changes: a cone that is 0.06 deg short of the half-space."""
FORCE_MAX = 1e5
"""Largest push [N]: a hundred times the weight of the heaviest robots."""
PAYLOAD_MAX, PAYLOAD_FAR = 1e4, 10.0
"""Heaviest payload [kg], and how far from the base's origin it may be along an axis [m]."""
SHORTEST_PUSH = 1e-3
"""A step of the worlds [s]; what is shorter can fall between two of them."""
LONGEST_RUN = 3600.0
FOREVER = 1e6
"""Longest that something is served in real time [s]: eleven days."""
FASTEST = 100.0
"""Largest velocity that is asked for along an axis [m/s], or about one [rad/s]."""


def numbers(option: str, text: str, form: str, example: str) -> list[float]:
    """Return the finite numbers of a text whose colons, commas and @ stand as in a form.

    >>> numbers("--dropout", "2:0.5", "T:DURATION", "2:0.5")
    [2.0, 0.5]
    """
    parts, wanted = ([part.split(",") for part in re.split("[:@]", one)] for one in (text, form))
    if [len(part) for part in parts] != [len(part) for part in wanted]:
        raise ProblemError(f"{option} {text!r} is not of the form {form}, e.g. {example}")
    return [finite_in_text(option, entry) for part in parts for entry in part]


def push(text: str) -> Push:
    """Return the push of "T:FX,FY,FZ:DURATION".

    >>> push("1:60,0,0:0.2")
    Push(start=1.0, force=(60.0, 0.0, 0.0), duration=0.2)
    """
    from surefoot.worlds.running.scenario import Push

    start, x, y, z, duration = numbers("--push", text, "T:FX,FY,FZ:DURATION", "1:60,0,0:0.2")
    if start < 0.0 or duration < SHORTEST_PUSH:
        raise ProblemError(f"--push {text!r}: T must be >= 0 and DURATION >= {SHORTEST_PUSH:g} s")
    if math.hypot(x, y, z) > FORCE_MAX:
        raise ProblemError(f"--push {text!r}: the force must not exceed {FORCE_MAX:g} N")
    return Push(start, (x, y, z), duration)


def ice(entry: Mapping[str, Any]) -> Ice | IcePatch:
    """Return the change of friction of an entry of a scenario: from a time on, or in a rectangle.

    >>> ice({"lower": (1.0, -1.0), "upper": (2.0, 1.0), "mu": 0.1})
    IcePatch(lower=(1.0, -1.0), upper=(2.0, 1.0), mu=0.1)
    """
    from surefoot.worlds.running.scenario import Ice, IcePatch

    keys = sorted(entry)
    if keys == ["from", "mu"]:
        return Ice(entry["from"], entry["mu"])
    if keys == ["lower", "mu", "upper"]:
        return IcePatch(entry["lower"], entry["upper"], entry["mu"])
    raise ProblemError(f"ice takes from and mu, or lower, upper and mu, got {', '.join(keys)}")


def dropout(text: str) -> tuple[float, float]:
    """Return start and duration of "T:DURATION" [s]."""
    start, duration = numbers("--dropout", text, "T:DURATION", "2:0.5")
    if start < 0.0 or duration < 0.0:
        raise ProblemError(f"--dropout {text!r}: T and DURATION must be >= 0")
    return start, duration


def payload(text: str) -> tuple[float, tuple[float, float, float]]:
    """Return mass [kg] and place in base axes [m] of "KG" or "KG@X,Y,Z".

    >>> payload("5@0.1,0.08,0.08")
    (5.0, (0.1, 0.08, 0.08))
    >>> payload("5")
    (5.0, (0.0, 0.0, 0.0))
    """
    whole = text if "@" in text else f"{text}@0,0,0"
    mass, x, y, z = numbers("--payload", whole, "KG@X,Y,Z", "5@0.1,0.08,0.08")
    real_number("--payload", mass, low=0.0, high=PAYLOAD_MAX)
    for part in (x, y, z):
        real_number("--payload", part, low=-PAYLOAD_FAR, high=PAYLOAD_FAR)
    return mass, (x, y, z)


def lift(text: str) -> Lift:
    """Return the lifted foot of "FOOT:T0:T1"."""
    from surefoot.motion.standing.standing_plan import Lift

    parts = text.split(":")
    if len(parts) != 3 or not parts[0]:
        raise ProblemError(f"--lift {text!r} is not of the form FOOT:T0:T1, e.g. FL:1:2")
    return Lift(parts[0], finite_in_text("--lift", parts[1]), finite_in_text("--lift", parts[2]))


def friction(option: str, mu: float) -> float:
    """Return a friction coefficient from 0 to `MU_MAX`."""
    return real_number(option, mu, low=0.0, high=MU_MAX)


def seed(number: int | None) -> None:
    """Refuse a seed that is not a whole number from 0 to 2⁶⁴ - 1; None stands for no seed."""
    if number is not None and not 0 <= number < 2**64:
        raise ProblemError(f"--seed must be a whole number from 0 to 2^64 - 1, got {number!s:.40}")


def within_run(option: str, texts: Iterable[str], starts: Iterable[float], duration: float) -> None:
    """Refuse what would start when the run is over.

    Raises
    ------
    ProblemError
        Naming the first of the option's texts that starts at `duration` [s] or later.
    """
    for text, start in zip(texts, starts, strict=True):
        if start >= duration:
            raise ProblemError(
                f"{option} {text!r} starts at {start:g} s, when the run is over: --duration is {duration:g} s"
            )


def names(option: str, text: str | None) -> list[str] | None:
    """Return the names of a comma-separated list, or None; an empty name is refused."""
    if text is None:
        return None
    listed = [name.strip() for name in text.split(",")]
    if not all(listed):
        raise ProblemError(f"{option}: {text!r} holds an empty name; names are separated by single commas")
    return listed


def velocity(text: str) -> tuple[float, float, float]:
    """Return forward, left [m/s] and yaw rate [rad/s] of "VX,VY,WZ"; missing ones are zero.

    >>> velocity("0.5")
    (0.5, 0.0, 0.0)
    """
    parts = text.split(",")
    if not 1 <= len(parts) <= 3:
        raise ProblemError(f"--velocity {text!r} is not of the form VX,VY,WZ, e.g. 0.5,0,0.2")
    said = [
        real_number("--velocity", finite_in_text("--velocity", p), low=-FASTEST, high=FASTEST) for p in parts
    ]
    x, y, turn = (*said, 0.0, 0.0)[:3]
    return x, y, turn
