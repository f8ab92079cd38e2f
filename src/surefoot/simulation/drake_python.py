"""The interpreter that runs Drake: this one, or that of an environment of Drake's own.

Drake's wheel is large and bound to single Python versions, so it may live elsewhere: SUREFOOT_DRAKE_PYTHON
names an interpreter that can import pydrake. Workers run in it as scripts and import nothing of Surefoot.
"""

from __future__ import annotations

import importlib.util
import os
import sys

PACKAGE, EXTRA = "drake", "drake"
VARIABLE = "SUREFOOT_DRAKE_PYTHON"


def named() -> str:
    """Return the interpreter that the environment names, empty if none."""
    return os.environ.get(VARIABLE, "")


def interpreter() -> str:
    """Return the interpreter to run a worker with."""
    return named() or sys.executable


def present() -> bool:
    """Return whether Drake is importable here, or another interpreter is named for it; it is not tried."""
    return bool(named()) or importlib.util.find_spec("pydrake") is not None
