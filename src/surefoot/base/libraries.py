"""Libraries of the extra `robot`, or the word that says how to get them."""

from __future__ import annotations

from typing import Any

from surefoot.base.errors import needs


def import_pinocchio() -> Any:
    """Return Pinocchio.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    with needs("pin", "robot"):
        import pinocchio
    return pinocchio


def import_casadi() -> Any:
    """Return the module casadi.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    with needs("casadi", "plan"):
        import casadi
    return casadi
