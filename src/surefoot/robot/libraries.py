"""Libraries of the extra `robot`, or the word that says how to get them."""

from __future__ import annotations

from typing import Any

from surefoot.errors import MissingExtra


def import_pinocchio() -> Any:
    """Return Pinocchio.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    try:
        import pinocchio
    except ImportError as error:
        raise MissingExtra("pin", "robot") from error
    return pinocchio


def import_casadi() -> Any:
    """Return the module casadi.

    Raises
    ------
    MissingExtra
        If it is not installed.
    """
    try:
        import casadi
    except ImportError as error:
        raise MissingExtra("casadi", "plan") from error
    return casadi
