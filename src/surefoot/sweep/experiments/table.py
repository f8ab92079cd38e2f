"""Experiments by name, one line each: what a sweep's file chooses from."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.experiments.experiment import Experiment, with_settings

EXPERIMENTS: dict[str, str | type[Experiment]] = {
    "drop": "surefoot.sweep.experiments.drop:Drop",
    "stand": "surefoot.sweep.experiments.stand:Stand",
    "walk": "surefoot.sweep.experiments.walk:Walk",
    "worlds": "surefoot.sweep.experiments.worlds:Worlds",
}
"""Name to the class, or "module:class", imported when asked for."""


def make_experiment(name: str, settings: Mapping[str, Any] | None = None) -> Experiment:
    """Return an experiment of the table with its settings.

    Raises
    ------
    ProblemError
        For an unknown name or setting.
    """
    if name not in EXPERIMENTS:
        raise ProblemError(unknown_name("experiment", name, EXPERIMENTS))
    kind = EXPERIMENTS[name]
    if isinstance(kind, str):
        module, _, title = kind.partition(":")
        kind = getattr(importlib.import_module(module), title)
    return with_settings(kind, name, settings or {})
