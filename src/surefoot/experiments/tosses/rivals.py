"""Rival simulators of a thrown body by name, one line each: what `--rivals` chooses from."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

from surefoot.errors import check_name
from surefoot.estimation.toss_model import TossModel
from surefoot.experiments.tosses.mujoco_body import MujocoBody

RIVALS: dict[str, Callable[[], TossModel]] = {"mujoco": MujocoBody}
"""Name, which is that of the simulator's package as well, to what makes it."""


def present_rivals() -> list[str]:
    """Return the names of the rivals that can be run here."""
    return [name for name in RIVALS if find_spec(name) is not None]


def make_rival(name: str) -> TossModel:
    """Return a rival.

    Raises
    ------
    ProblemError
        For an unknown name.
    MissingExtra
        If its package is not installed.
    """
    check_name("rival", name, RIVALS)
    return RIVALS[name]()
