"""Options that go together: a command takes a group of them as one parameter, a dataclass of options."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import is_dataclass
from functools import wraps
from typing import Any


def ungrouped(command: Callable[..., int]) -> Callable[..., int]:
    """Return a command for Typer: in the place of each parameter that is a dataclass stand its fields."""
    options: list[inspect.Parameter] = []
    groups: dict[str, tuple[Any, list[str]]] = {}
    for parameter in inspect.signature(command, eval_str=True).parameters.values():
        kind = parameter.annotation
        if not is_dataclass(kind):
            options.append(parameter)
            continue
        fields = [*inspect.signature(kind, eval_str=True).parameters.values()]  # type: ignore[arg-type]
        groups[parameter.name] = kind, [field.name for field in fields]
        options += [field.replace(kind=inspect.Parameter.KEYWORD_ONLY) for field in fields]
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
