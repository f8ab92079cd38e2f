"""A sweep over somebody's own function: a dict of settings in, a dict of results out.

The name is "module:function"; a module beside the sweep's file comes before installed ones. The function is
called once while the sweep is planned: what it returns then says which results there are, and of which kind.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import field, fields, make_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from surefoot.base.errors import ProblemError, one_line, shown
from surefoot.worlds.sweep.sample_experiment import SweepExperiment, number

_KINDS: tuple[tuple[tuple[type, ...], str, Callable[[Any], Any]], ...] = (
    ((bool, np.bool_), "bool", bool),
    ((int, float, np.number), "float", float),
    ((str,), "text", str),
)
"""Types of a result, the name of its column's kind, and what makes it plain."""


class FunctionExperiment(SweepExperiment):
    """An experiment that is somebody's function; `experiment_of` makes a subclass with its settings.

    Attributes
    ----------
    function, folder
        "module:function", and where the sweep's file lies.
    """

    function: ClassVar[str]
    folder: ClassVar[str]
    columns: ClassVar[Mapping[str, str]] = {}

    def run(self, seed: int) -> dict[str, Any]:
        """Return the function's results for the settings and a `seed` beside them."""
        given = {f.name: getattr(self, f.name) for f in fields(self)}
        found = _function(self.function, self.folder)({**given, "seed": seed})
        if (
            not isinstance(found, Mapping)
            or not found
            or (self.columns and found.keys() != self.columns.keys())
        ):
            wanted = f"with {', '.join(self.columns)}" if self.columns else "of results"
            raise ProblemError(f"{self.function} must return a dict {wanted}, got {shown(found)}")
        return {str(name): _plain(self.function, name, value)[1] for name, value in found.items()}

    def learn(self) -> None:
        """Call the function once, and take what it returns for what it always returns.

        Raises
        ------
        ProblemError
            If it fails, or says of no result whether a sample survived.
        """
        try:
            found = self.run(0)
        except ProblemError:
            raise
        except Exception as error:
            why = one_line(error)
            said = f"{self.function} failed when tried: {type(error).__name__}: {why}"
            raise ProblemError(said) from error
        kinds = {name: _plain(self.function, name, value)[0] for name, value in found.items()}
        if "bool" not in kinds.values():
            raise ProblemError(
                f"{self.function} must return a True or False among its results, whether a sample survived; "
                f"got {', '.join(kinds)}"
            )
        type(self).columns = dict(sorted(kinds.items(), key=lambda kind: kind[1] != "bool"))


def experiment_of(
    name: str, settings: Mapping[str, Any], ranges: Mapping[str, Any], folder: Path
) -> FunctionExperiment:
    """Return the experiment of a function, with its settings and what a sweep draws.

    Raises
    ------
    ProblemError
        If there is no such function.
    """
    source = _function(name, str(folder)).__code__
    parts: list[Any] = []
    for key, value in {**dict.fromkeys(ranges), **settings}.items():
        drawn = ranges.get(key, value)
        first = drawn[0] if isinstance(drawn, list) and drawn else drawn
        if isinstance(first, str):
            parts.append((str(key), str, field(default=first)))
        elif key in ranges or (isinstance(value, (int, float)) and not isinstance(value, bool)):
            parts.append((str(key), Any, number(value, -np.inf, np.inf)))
        else:
            parts.append((str(key), Any, field(default=value)))
    code = hashlib.sha256(source.co_code + repr(source.co_consts).encode()).hexdigest()
    own = {"function": name, "folder": str(folder), "code": code}
    made = make_dataclass("FunctionTrial", parts, bases=(FunctionExperiment,), namespace=own, frozen=True)
    experiment: FunctionExperiment = made()
    return experiment


def _plain(function: str, name: object, value: Any) -> tuple[str, Any]:
    """Return the kind of a result's column, and the value as that; None stays where a number is missing."""
    for types, kind, make in _KINDS:
        if isinstance(value, types):
            return kind, make(value)
    raise ProblemError(
        f"{function}: the result {name!r} must be a number, a text or True or False, got {shown(value)}"
    )


@lru_cache(8)
def _function(name: str, folder: str) -> Callable[[dict[str, Any]], Any]:
    """Return the function of a name "module:function"."""
    module, _, title = name.partition(":")
    file = Path(folder) / f"{module}.py"
    try:
        if file.is_file():
            spec = importlib.util.spec_from_file_location(module, file)
            assert spec is not None
            assert spec.loader is not None
            loaded = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(loaded)
        else:
            loaded = importlib.import_module(module)
    except Exception as error:
        why = f"{type(error).__name__}: {one_line(error)}"
        raise ProblemError(f"experiment {name}: {module} cannot be loaded: {why}") from error
    found = getattr(loaded, title, None)
    if not hasattr(found, "__code__"):
        raise ProblemError(f"experiment {name}: {module} has no function {title!r}")
    return found  # type: ignore[return-value]
