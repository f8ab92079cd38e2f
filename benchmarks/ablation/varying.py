"""Values of settings, each compared with the value that the setting has.

A value is worse if a task is worse with it beyond noise: by a sign test of the trials that are lost (six of
six are more than chance, five of five are not), or by the 95 % interval of a measure. Tasks of a value are
carried out in turn until one is worse, and values on either side of the setting's own outwards until one is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.ablation.changes import make_settings
from benchmarks.ablation.comparing import Comparison, Records, compare
from benchmarks.ablation.parts import CLASS_TASKS, USUAL_TASKS
from benchmarks.ablation.trials import Change, Trials
from surefoot.base.errors import ProblemError, unknown_name
from surefoot.base.settings import SettingInfo, Settings, describe

FACTORS = (2.0,)
"""Values that are tried over the setting's own, and the setting's own over them."""
Known = Mapping[str, "Setting"]
"""Settings by "Class.setting"."""


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

    def values(
        self, given: Sequence[float] | None = None, factors: Sequence[float] | None = None
    ) -> list[Any]:
        """Return the values to try, rising, without its own.

        Parameters
        ----------
        given
            Values; None for those by factors.
        factors
            Above 1: of values over the setting's own, and of that over values; None for `FACTORS`.
            The numbers of a setting that has several are multiplied by the same one.
        """
        if isinstance(self.value, bool):
            return [not self.value]
        if isinstance(self.value, tuple) and given:
            raise ProblemError(f"{self.name} has several numbers: try --factor in place of --value")
        both = [f for one in factors or FACTORS for f in (1.0 / one, one)]
        if isinstance(self.value, tuple):
            tried: list[Any] = [tuple(self._allowed(f * part) for part in self.value) for f in both]
        else:
            tried = [self._allowed(v) for v in given or [self.value * f for f in both]]
        return sorted({*tried} - {self.value}, key=place)

    def _allowed(self, value: float) -> float:
        """Return the value of its type within the limits that is next to a number."""
        low, high = self.info.low, self.info.high
        kept = value if low is None else max(value, low)
        kept = kept if high is None else min(kept, high)
        return int(kept) if self.info.whole else float(kept)


def place(value: Any) -> float:
    """Return a number by which the values of a setting are in order."""
    return math.hypot(*value) if isinstance(value, tuple) else float(value)


def shown(value: Any) -> str:
    """Return a value in words, several numbers with commas."""
    return ", ".join(map(shown, value)) if isinstance(value, tuple) else f"{value:g}"


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


def known_settings() -> Known:
    """Return the settings of walking."""
    make_settings()
    return {
        f"{owner.__name__}.{one.name}": Setting(f"{owner.__name__}.{one.name}", one.value, one.info)
        for owner in Settings.__subclasses__()
        if owner.__module__.startswith("surefoot.motion.")
        for one in describe(owner)
        if "." not in one.name and one.info.source
    }


def find_settings(name: str) -> tuple[Setting, ...]:
    """Return a setting of walking by "Class.setting", or all of a class that have numbers.

    Raises
    ------
    ProblemError
        For an unknown name, and a setting that is no number.
    """
    known = known_settings()
    chosen = [one for key, one in known.items() if name in (key, key.partition(".")[0])]
    if not chosen:
        raise ProblemError(unknown_name("setting", name, tuple(known)))
    found = tuple(one for one in chosen if isinstance(one.value, bool | int | float | tuple))
    if not found:
        raise ProblemError(f"{name} is {chosen[0].value}: only numbers can be varied")
    return found


def try_values(
    setting: Setting, values: Sequence[Any], trials: Trials, tasks: Sequence[str], outwards: bool = True
) -> list[Tried]:
    """Return how values compare with the setting's own.

    Parameters
    ----------
    setting, values
        What is tried.
    trials, tasks
        Over what; the tasks of a value in turn, until one is worse.
    outwards
        Whether values beyond one that is worse are left out.
    """
    before, own = trials.of(Change("as it is"), tasks), place(setting.value)
    found = []
    for side in (1.0, -1.0):
        beyond = sorted(
            (v for v in values if side * (place(v) - own) > 0.0), key=lambda v: abs(place(v) - own)
        )
        for value in beyond:
            found.append(_try(setting, value, before, trials, tasks))
            if outwards and found[-1].worse:
                break
    return sorted(found, key=lambda one: place(one.value))


def _try(setting: Setting, value: Any, before: Records, trials: Trials, tasks: Sequence[str]) -> Tried:
    def is_worse(task: str, after: Records) -> bool:
        return compare(task, before, after).worse

    change = Change(f"{setting.name}={shown(value)}", changes={setting.name: value})
    after = trials.of(change, tasks, is_worse)
    compared = {one["task"] for one in after}
    return Tried(value, tuple(compare(task, before, after) for task in tasks if task in compared))


def verdict(setting: Setting, found: Sequence[Tried]) -> str:
    """Return whether the setting's choice is repeated, and the values that do as well."""
    better = [one.value for one in found if one.better]
    if better:
        return "better: " + "; ".join(map(shown, better))
    worse = [place(one.value) for one in found if one.worse]
    if not worse:
        return "not decided: all values tried do as well"
    own = place(setting.value)
    below = max((v for v in worse if v < own), default=-math.inf)
    above = min((v for v in worse if v > own), default=math.inf)
    good = [one.value for one in found if not one.worse and below < place(one.value) < above]
    good = sorted([setting.value, *good], key=place)
    return f"as good from {shown(good[0])} to {shown(good[-1])}"
