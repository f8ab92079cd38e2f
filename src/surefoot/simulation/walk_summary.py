"""Moved: see `surefoot.audit.summarise_walk`; this works for one release."""

from __future__ import annotations

import warnings
from typing import Any

from surefoot.audit import summarise_walk as _new
from surefoot.log import Log


def summarise_walk(log: Log) -> dict[str, Any]:
    """Return the summary as a dictionary; now `surefoot.audit.summarise_walk`."""
    warnings.warn("summarise_walk is now surefoot.audit.summarise_walk", DeprecationWarning, stacklevel=2)
    return _new(log).as_dict()
