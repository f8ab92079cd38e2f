"""Help texts that are shown as they are written, units in square brackets included."""

from __future__ import annotations

from typing import Any

from rich.markup import escape
from typer.core import TyperCommand


class LiteralHelpCommand(TyperCommand):
    """A command whose help is no markup: Rich would take `[deg]` for a style and leave it out."""

    def __init__(self, name: str | None, **settings: Any) -> None:
        if settings.get("rich_markup_mode") == "rich":
            for part in (settings, *(vars(p) for p in settings.get("params") or ())):
                if part.get("help"):
                    part["help"] = escape(part["help"])
        super().__init__(name, **settings)
