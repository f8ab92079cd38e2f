"""Moved: see `surefoot.audit.summarise_stand`; this works for one release."""

from __future__ import annotations

import warnings
from typing import Any

from surefoot.audit import summarise_stand as _new
from surefoot.log import Log


def summarise(log: Log) -> dict[str, Any]:
    """Return the summary as a dictionary; now `surefoot.audit.summarise_stand`."""
    warnings.warn("summarise is now surefoot.audit.summarise_stand", DeprecationWarning, stacklevel=2)
    return _new(log).as_dict()
