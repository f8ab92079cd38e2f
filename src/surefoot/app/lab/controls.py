"""What a page takes: sliders, choices, ticks and buttons, each checking what a browser sends."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, TypeAlias

from surefoot.base.errors import ProblemError, check_name, shown, unknown_name


@dataclass(frozen=True)
class Slider:
    """A number from `low` to `high` in steps of `step`.

    Attributes
    ----------
    name
        Under which the page knows it.
    label
        What stands beside it, with the unit.
    folder
        Heading that it stands below; empty for none.
    hint
        One line more.
    """

    name: str
    label: str
    low: float
    high: float
    step: float
    value: float
    folder: str = ""
    hint: str = ""

    def checked(self, raw: object) -> float:
        """Return what was sent as a number, or raise `ProblemError`."""
        if isinstance(raw, bool) or not isinstance(raw, int | float) or not math.isfinite(raw):
            raise ProblemError(f"{self.label} must be a finite number, got {shown(raw)}")
        if not self.low - 1e-9 <= raw <= self.high + 1e-9:
            raise ProblemError(f"{self.label} must be from {self.low:g} to {self.high:g}, got {raw:g}")
        return float(raw)


@dataclass(frozen=True)
class Choice:
    """One of some words; see `Slider` for the other attributes."""

    name: str
    label: str
    options: tuple[str, ...]
    value: str
    folder: str = ""

    def checked(self, raw: object) -> str:
        """Return what was sent if it is one of the words, or raise `ProblemError`."""
        check_name(self.label, raw if isinstance(raw, str) else repr(raw)[:40], self.options)
        return str(raw)


@dataclass(frozen=True)
class Checkbox:
    """On or off; see `Slider` for the other attributes."""

    name: str
    label: str
    value: bool
    folder: str = ""

    def checked(self, raw: object) -> bool:
        """Return what was sent if it is true or false, or raise `ProblemError`."""
        if not isinstance(raw, bool):
            raise ProblemError(f"{self.label} must be true or false, got {shown(raw)}")
        return raw


@dataclass(frozen=True)
class Button:
    """Something to press; it has no value."""

    name: str
    label: str
    folder: str = ""


Control: TypeAlias = Slider | Choice | Checkbox | Button


class Values(dict[str, Any]):
    """The controls of a page and their values.

    Parameters
    ----------
    controls
        Each with the value that it starts with.

    Examples
    --------
    >>> values = Values([Slider("mu", "friction", 0.0, 1.5, 0.01, 0.6), Button("go", "go")])
    >>> values.change("mu", 0.8)
    >>> values["mu"], "go" in values
    (0.8, False)
    """

    def __init__(self, controls: tuple[Control, ...] | list[Control]) -> None:
        self.controls = tuple(controls)
        self._by_name = {control.name: control for control in self.controls}
        super().__init__({c.name: c.value for c in self.controls if not isinstance(c, Button)})

    def change(self, name: str, raw: object) -> None:
        """Take a value for a control.

        Raises
        ------
        ProblemError
            For a control that does not exist or has no value, or a value that is none of its own.
        """
        control = self._by_name.get(name)
        if control is None or isinstance(control, Button):
            raise ProblemError(unknown_name("control", name, self))
        self[name] = control.checked(raw)

    def within(self, name: str, value: float) -> None:
        """Give a slider the nearest value that it can have."""
        control = self._by_name[name]
        assert isinstance(control, Slider)
        self[name] = min(max(float(value), control.low), control.high)
