"""Functions of the module ``mujoco`` replaced for a while, wherever a module holds them by their names."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from types import ModuleType
from typing import Any

Replacement = Callable[[str, Callable[..., Any]], Callable[..., Any]]
"""From a function's name and the function to what takes its place."""


class ReplacedFunctions:
    """Functions of MuJoCo that other ones take the place of, also after ``from mujoco import mj_step``.

    Parameters
    ----------
    mujoco
        The module.
    """

    def __init__(self, mujoco: Any) -> None:
        self._mujoco = mujoco
        self._replaced: list[tuple[ModuleType, str, Any, Any]] = []

    def install(self, made: Mapping[str, Replacement]) -> None:
        """Replace the functions, in every module that holds them."""
        originals = {name: getattr(self._mujoco, name) for name in made if hasattr(self._mujoco, name)}
        replacements = {name: made[name](name, function) for name, function in originals.items()}
        for module in list(sys.modules.values()):
            held = getattr(module, "__dict__", None)
            if not isinstance(held, dict):
                continue
            for name, original in originals.items():
                if held.get(name) is original:
                    self._replaced.append((module, name, original, replacements[name]))
                    held[name] = replacements[name]

    def remove(self) -> None:
        """Put the functions back."""
        while self._replaced:
            module, name, original, _ = self._replaced.pop()
            module.__dict__[name] = original
