"""Rival simulators of a tossed cube by name, one line each: what `--rivals` chooses from."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import NamedTuple

from surefoot.errors import ProblemError, unknown_name
from surefoot.estimation.toss_model import TossModel
from surefoot.simulation import drake_python
from surefoot.simulation.tosses.drake_cube import DrakeCube
from surefoot.simulation.tosses.mujoco_cube import MujocoCube


class Rival(NamedTuple):
    """A simulator: how to make it, whether it is there, and how many tosses it is tuned on (None: all).

    Drake takes a second per toss: fewer of them, by the same search.
    """

    make: Callable[[], TossModel]
    present: Callable[[], bool]
    most: int | None = None


RIVALS = {
    "mujoco": Rival(MujocoCube, lambda: find_spec("mujoco") is not None),
    "drake": Rival(DrakeCube, drake_python.present, most=48),
}


def present_rivals() -> list[str]:
    """Return the names of the rivals that can be run here."""
    return [name for name, rival in RIVALS.items() if rival.present()]


def make_rival(name: str) -> TossModel:
    """Return a rival.

    Raises
    ------
    ProblemError
        For an unknown name.
    MissingExtra
        If its package is not installed.
    """
    if name not in RIVALS:
        raise ProblemError(unknown_name("rival", name, RIVALS))
    return RIVALS[name].make()
