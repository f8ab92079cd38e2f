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
