"""The one console of the commands: what is said is text, never markup."""

from __future__ import annotations

from typing import Any

from rich.console import Console


def plain_console(**settings: Any) -> Console:
    """Return a console that prints square brackets as they are: units, file names, extras of pip."""
    return Console(markup=False, emoji=False, **settings)
