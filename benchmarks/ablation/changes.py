"""Other defaults of settings for one process, given before the modules that define them are imported."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from dataclasses import Field
from typing import Any

from surefoot.base.settings import Settings

MODULES = ("walking.walking_controller", "walking.biped.walking", "ground.elevation_map")
"""Of `surefoot.motion`: with them all settings of walking are made; some wait for a robot or a map."""


def make_settings() -> None:
    """Import what makes all settings of walking."""
    for name in MODULES:
        importlib.import_module(f"surefoot.motion.{name}")


class Changes:
    """Gives settings other defaults as their classes are made.

    Compiled code folds the settings that it reads, so a process has one set of values from its start on.

    Parameters
    ----------
    values
        By "Class.setting".
    """

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.left = dict(values)
        changes = self

        def changed(cls: type[Settings], /, **_: Any) -> None:
            for name, part in list(vars(cls).items()):
                if isinstance(part, Field) and f"{cls.__name__}.{name}" in changes.left:
                    part.default = changes.left.pop(f"{cls.__name__}.{name}")

        Settings.__init_subclass__ = classmethod(changed)  # type: ignore[assignment]

    def check(self) -> None:
        """Raise an error if a setting that should be changed has not been met."""
        if self.left:
            raise LookupError(f"no such settings, or their modules were imported before: {self.left}")
