"""Worlds that a success is carried to, as texts: an engine, and what is changed of it."""

from __future__ import annotations

import re
from dataclasses import dataclass

from surefoot.base.errors import ProblemError, check_name, shown

STANDARD = (
    "mujoco", "mujoco-exact", "mujoco:stiff", "mujoco:half-step", "mujoco-exact:half-step",
    "mujoco-exact:mu-20%", "mujoco-exact:mu+20%",
)  # fmt: skip
"""Worlds where none are named: Coulomb's law, stiffer ground, half the step, other friction."""
_FRICTION = re.compile(r"mu([+-]\d{1,2}(?:\.\d+)?)%")


@dataclass(frozen=True)
class Variant:
    """A world that is another one in one or more respects.

    Attributes
    ----------
    name
        As it was asked for, ``engine:change:change``.
    engine
        Name of the world.
    stiff
        Whether MuJoCo's ground is as stiff as its step allows: a time constant of two steps.
    halved
        Whether the step is half as long; the controller's stays.
    friction
        Factor of all friction.
    """

    name: str
    engine: str
    stiff: bool = False
    halved: bool = False
    friction: float = 1.0

    @classmethod
    def read(cls, text: str, engines: tuple[str, ...]) -> Variant:
        """Return what a text as ``mujoco-exact:half-step:mu-20%`` asks for.

        Raises
        ------
        ProblemError
            For an engine or a change that is not known, or softness of what has none.
        """
        if not isinstance(text, str):
            raise ProblemError(f"a world to transfer to must be a text, got {shown(text)}")
        engine, *changes = text.split(":")
        check_name("world", engine, engines)
        stiff, halved, friction = False, False, 1.0
        for change in changes:
            found = _FRICTION.fullmatch(change)
            if found is not None:
                friction *= 1.0 + float(found[1]) / 100.0
            elif change in ("stiff", "half-step"):
                stiff, halved = stiff or change == "stiff", halved or change == "half-step"
            else:
                raise ProblemError(
                    f"a world is changed by stiff, half-step and mu-20% or such, got {change!r} in {text!r}"
                )
        if stiff and engine != "mujoco":
            raise ProblemError(f"stiff is of the world mujoco, got {text!r}")
        return cls(text, engine, stiff, halved, friction)
