"""`--scenario FILE`: what happens to a simulated robot that no option says, as YAML.

The keys, their units and their bounds stand in `scenario.schema.json` beside this file, and nowhere else: it
is what a file is checked against, and what an editor may be given.
"""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError, check_name, located
from surefoot.base.text_files import read_yaml

SCHEMA = Path(__file__).with_name("scenario.schema.json")
GROUND = frozenset({"ice", "law", "solref", "solimp", "substeps"})
"""Keys of the ground."""
FAULTS = frozenset({"delay", "weak_joint", "torque_loss"})
"""Keys of what is wrong between robot and controller."""
STAND_KEYS = GROUND | FAULTS
WALK_KEYS = GROUND | FAULTS | {
    "estimator", "noise", "believed_mu", "period", "velocity_file", "control_rate", "latency",
}  # fmt: skip


@dataclass(frozen=True)
class ScenarioFile:
    """What a scenario file says; see `scenario.schema.json` for each key's unit and bounds."""

    ice: tuple[dict[str, Any], ...] = ()
    law: Mapping[str, Any] | None = None
    solref: tuple[float, ...] | None = None
    solimp: tuple[float, ...] | None = None
    substeps: int | None = None
    delay: float = 0.0
    weak_joint: str = ""
    torque_loss: float = 0.0
    estimator: str = "inekf"
    noise: float | None = None
    believed_mu: float | str | None = None
    period: float | None = None
    velocity_file: Path | None = None
    control_rate: float = 1000.0
    latency: float | str = "auto"

    @staticmethod
    def read(path: Path | None, keys: Collection[str]) -> ScenarioFile:
        """Return what a file says in these keys; None says nothing.

        Raises
        ------
        ProblemError
            Naming the file and the entry at fault: a key that is unknown, missing or of another command, a
            value that is not what it should be.
        """
        if path is None:
            return ScenarioFile()
        content = read_yaml(path, "the scenario") or {}
        with located(path):
            said = checked("", content, schema())
            for key in said:
                check_name("key for this command", key, keys)
        if "velocity_file" in said:
            said["velocity_file"] = path.parent / said["velocity_file"]
        return ScenarioFile(**said)

    @property
    def given(self) -> list[str]:
        """The keys that say something else than the default."""
        return [f.name for f in fields(self) if getattr(self, f.name) != f.default]


@cache
def schema() -> dict[str, Any]:
    """Return the JSON schema of scenario files."""
    found: dict[str, Any] = json.loads(SCHEMA.read_text(encoding="utf-8"))
    return found


def checked(where: str, value: Any, form: Mapping[str, Any]) -> Any:
    """Return a value if it is of a JSON schema's form, numbers as numbers and lists as tuples.

    Parameters
    ----------
    where
        What the value is called in messages; empty for the whole file.
    value
        As YAML has it, which reads 2e5 as text.
    form
        Of the keywords of JSON Schema those that `scenario.schema.json` uses.

    Raises
    ------
    ProblemError
        For a value of another form.
    """
    if "anyOf" in form:
        words, number = form["anyOf"]
        return checked(where, value, words if value in words["enum"] else number)
    if "enum" in form:
        check_name(where, value, form["enum"])
        return value
    return _FORMS[form["type"]](where, value, form)


def _mapping(where: str, value: Any, form: Mapping[str, Any]) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ProblemError(f"{where or 'the file'} must be a mapping of keys, got {value!r:.60}")
    known = form["properties"]
    for key in value:
        check_name(f"key of {where}" if where else "key", key, known)
    for key in form.get("required", ()):
        if key not in value:
            raise ProblemError(f"{where} needs the key {key!r}")
    return {key: checked(f"{where} {key}".strip(), each, known[key]) for key, each in value.items()}


def _sequence(where: str, value: Any, form: Mapping[str, Any]) -> tuple[Any, ...]:
    least, most = form.get("minItems", 0), form.get("maxItems", math.inf)
    if not isinstance(value, list) or not least <= len(value) <= most:
        size = (
            "" if most == math.inf else f" of {least} entries" if least == most else f" of {least} to {most}"
        )
        raise ProblemError(f"{where} must be a list{size}, got {value!r:.60}")
    return tuple(checked(f"{where}[{k}]", each, form["items"]) for k, each in enumerate(value))


def _number(where: str, value: Any, form: Mapping[str, Any]) -> float:
    low, high = form.get("minimum", -math.inf), form.get("maximum", math.inf)
    try:
        number = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    whole = form["type"] == "integer"
    if not (math.isfinite(number) and low <= number <= high and (not whole or number == int(number))):
        bounds = (
            f" from {low:g} to {high:g}" if high < math.inf else f" >= {low:g}" if low > -math.inf else ""
        )
        raise ProblemError(f"{where} must be a {'whole ' if whole else ''}number{bounds}, got {value!r:.60}")
    return int(number) if whole else number


def _text(where: str, value: Any, form: Mapping[str, Any]) -> str:
    if not isinstance(value, str):
        raise ProblemError(f"{where} must be a text, got {value!r:.60}")
    return value


_FORMS = {"object": _mapping, "array": _sequence, "number": _number, "integer": _number, "string": _text}
