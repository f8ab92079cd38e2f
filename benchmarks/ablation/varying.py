"""Values of one setting, each compared with the value that it has."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.ablation.comparing import Comparison, compare
from benchmarks.ablation.parts import CLASS_TASKS, USUAL_TASKS
from benchmarks.ablation.trials import Change, Trials
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.settings import SettingInfo, Settings, describe

FACTORS = (0.5, 2.0)
"""Values that are tried, over the setting's own."""


@dataclass(frozen=True)
class Setting:
    """A setting: "Class.setting", its value, and what is known of it beside."""

    name: str
    value: Any
    info: SettingInfo

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks that it is varied over."""
        return CLASS_TASKS.get(self.name.partition(".")[0], USUAL_TASKS)

    def values(self, given: Sequence[float] | None) -> list[Any]:
        """Return the values to try, rising, without its own."""
        if isinstance(self.value, bool):
            return [not self.value]
        tried = given or [self.value * factor for factor in FACTORS]
        low, high = self.info.low, self.info.high
        kept = {min(max(v, v if low is None else low), v if high is None else high) for v in tried}
        kind = int if self.info.whole else float
        return sorted({kind(v) for v in kept} - {self.value})


@dataclass(frozen=True)
class Tried:
    """A value of a setting and how it compares with the setting's own, task by task."""

    value: Any
    comparisons: tuple[Comparison, ...]

    @property
    def worse(self) -> bool:
        """Whether any task is worse beyond noise."""
        return any(one.worse for one in self.comparisons)

    @property
    def better(self) -> bool:
        """Whether a task is better beyond noise, and none is worse."""
        return not self.worse and any(one.better for one in self.comparisons)


def find_setting(name: str) -> Setting:
    """Return a setting of walking by "Class.setting".

    Raises
    ------
    ProblemError
        For an unknown name, and a setting that is not one number.
    """
    importlib.import_module("surefoot.motion.walking.walking_controller")
    importlib.import_module("surefoot.motion.walking.biped.walking")
    known = {
        f"{owner.__name__}.{one.name}": Setting(f"{owner.__name__}.{one.name}", one.value, one.info)
        for owner in Settings.__subclasses__()
        if owner.__module__.startswith("surefoot.motion.")
        for one in describe(owner)
        if "." not in one.name
    }
    if name not in known:
        raise ProblemError(unknown_name("setting", name, tuple(known)))
    if not isinstance(known[name].value, bool | int | float):
        raise ProblemError(f"{name} is {known[name].value}: only a single number can be varied")
    return known[name]


def try_values(setting: Setting, values: Sequence[Any], trials: Trials, tasks: Sequence[str]) -> list[Tried]:
    """Return how each value compares with the setting's own."""
    before = trials.of(Change("as it is"), tasks)
    found = []
    for value in values:
        after = trials.of(Change(f"{setting.name}={value:g}", changes={setting.name: value}), tasks)
        found.append(Tried(value, tuple(compare(task, before, after) for task in tasks)))
    return found


def verdict(setting: Setting, found: Sequence[Tried]) -> str:
    """Return whether the setting's choice is repeated, and the values that do as well."""
    better = [one.value for one in found if one.better]
    if better:
        return "better: " + ", ".join(f"{value:g}" for value in better)
    worse = [one.value for one in found if one.worse]
    if not worse:
        return "not decided: all values tried do as well"
    below = [v for v in worse if v < setting.value]
    above = [v for v in worse if v > setting.value]
    good = sorted(
        [setting.value]
        + [
            one.value
            for one in found
            if not one.worse
            and one.value > max(below, default=-1e300)
            and one.value < min(above, default=1e300)
        ]
    )
    return f"as good from {good[0]:g} to {good[-1]:g}"
