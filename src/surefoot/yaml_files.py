"""What people write by hand: YAML files, and tables in them whose keys are known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from surefoot.errors import ProblemError, check_name


def read_yaml(path: Path, what: str = "") -> Any:
    """Return what a YAML file holds; `what` it is of, for the message.

    Raises
    ------
    ProblemError
        If it cannot be read, or is not YAML.
    """
    try:
        return parse_yaml(path.read_text(encoding="utf-8"), path)
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not text"
        raise ProblemError(f"cannot read {what}{' ' if what else ''}{path}: {reason}") from error


def parse_yaml(text: str, name: object) -> Any:
    """Return what a YAML text holds; `name` is what errors call it."""
    import yaml

    try:
        return yaml.safe_load(text)
    except (yaml.YAMLError, RecursionError) as error:
        raise ProblemError(f"{name} is not YAML: {' '.join(str(error).split())[:200]}") from error


def table_of(
    where: str, value: Any, keys: Sequence[str] | None = None, required: Sequence[str] = ()
) -> dict[str, Any]:
    """Return a table of names if it holds no other keys than `keys` (None: any), and the required ones.

    Raises
    ------
    ProblemError
        Naming what is wrong `where`.
    """
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        named = "names" if keys is None else f"the keys {', '.join(keys)}"
        raise ProblemError(f"{where} must be a mapping of {named}, got {value!r:.60}")
    for key in value if keys is not None else ():
        check_name("key", key, keys or (), where)
    for key in required:
        if key not in value:
            raise ProblemError(f"{where}: {key} is missing")
    return value
