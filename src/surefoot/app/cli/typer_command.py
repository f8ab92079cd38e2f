"""What Typer is given: commands whose help is literal, and whose parameters may be groups of options."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import is_dataclass
from functools import wraps
from typing import Any, get_type_hints

from rich.markup import escape
from typer.core import TyperCommand

PANELS = {
    "Robot": ("feet", "actuators"),
    "Controller": (
        "gait", "planner", "velocity", "terrain_knowledge", "commands", "policy", "policy_spec", "trust",
    ),
    "Ground": ("terrain", "slope", "mu"),
    "Disturbances": ("push", "lift", "payload", "dropout", "seed", "scenario"),
    "World": ("world", "collision", "duration", "anyway", "resume", "at"),
    "Output": ("view", "out", "video", "hd", "report", "as_json", "keep_states"),
}  # fmt: skip
"""Panel of the help of a simulated run to the options that stand in it."""
PANEL_OF = {name: panel for panel, names in PANELS.items() for name in names}


ORDER = [*PANEL_OF]
"""In which the help has them."""


class LiteralHelpCommand(TyperCommand):
    """A command whose help is no markup: Rich would take `[deg]` for a style and leave it out."""

    def __init__(self, name: str | None, **settings: Any) -> None:
        if settings.get("rich_markup_mode") == "rich":
            for part in (settings, *(vars(p) for p in settings.get("params") or ())):
                if part.get("help"):
                    part["help"] = escape(part["help"])
        if name in ("stand", "walk"):
            params = settings.setdefault("params", [])
            for part in params:
                part.rich_help_panel = PANEL_OF.get(part.name)
            params.sort(key=lambda part: ORDER.index(part.name) if part.name in ORDER else -1)
        super().__init__(name, **settings)


def flatten_parameters(command: Callable[..., int]) -> Callable[..., int]:
    """Return a command for Typer: in the place of each parameter that is a dataclass stand its fields."""
    options: list[inspect.Parameter] = []
    groups: dict[str, tuple[Any, list[str]]] = {}
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        kind = parameter.annotation
        if not is_dataclass(kind):
            options.append(parameter)
            continue
        types = get_type_hints(kind, include_extras=True)  # each class's words by its own module
        fields = inspect.signature(kind).parameters.values()  # type: ignore[arg-type]
        groups[parameter.name] = kind, [field.name for field in fields]
        options += [
            inspect.Parameter(f.name, f.KEYWORD_ONLY, default=f.default, annotation=types[f.name])
            for f in fields
        ]
    if not groups:
        return command

    @wraps(command)
    def flat(**given: Any) -> int:
        for name, (kind, names) in groups.items():
            given[name] = kind(**{field: given.pop(field) for field in names})
        return command(**given)

    flat.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    flat.__annotations__ = {option.name: option.annotation for option in options}
    return flat
