"""Signals of a story from arrays made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

import surefoot as sf
from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.story.signals import Signals


def made_signals(
    arrays: dict[str, Any], facts: dict[str, Any], names: tuple[str, ...], weight: float, dt: float
) -> Signals:
    """Return the signals of a log whose contacts are points, each of a link of its own name."""
    setting = Setting(
        names, np.arange(len(names)), names, weight, dt, 0.0, 0.002, 0.0, 0.0, 0.0, np.zeros(3), None, ""
    )
    return Signals(sf.Log(arrays, facts), setting)
