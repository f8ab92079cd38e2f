"""A sweep as data: which experiment, over which ranges, how many samples, from which seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from surefoot import __version__
from surefoot.arrays import whole_number
from surefoot.errors import ProblemError, unknown_name
from surefoot.sweep.experiments import Experiment, make_experiment
from surefoot.sweep.parameters import PARAMETERS
from surefoot.sweep.ranges import read_range
from surefoot.sweep.space import MOST, Space

_KEYS = ("experiment", "samples", "seed", "settings", "ranges", "maps")
VERSION = "surefoot"
"""Key of the version in a sweep's identity: another version may come to other results."""
SAMPLES = 1000
"""Samples of a file that does not say how many."""


@dataclass(frozen=True)
class SweepConfig:
    """What a sweep runs.

    Attributes
    ----------
    name
        Of the experiment.
    experiment
        With its settings.
    space
        Ranges and seed.
    samples
        How many; more can be asked for later, the first ones stay what they are.
    maps
        Pairs of parameters that survival is drawn over; empty to choose.
    """

    name: str
    experiment: Experiment
    space: Space
    samples: int = SAMPLES
    maps: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        whole_number("seed", self.space.seed)
        if whole_number("samples", self.samples, low=1) > MOST:
            raise ProblemError(f"samples must be at most 2^30, got {self.samples}")
        self.experiment.check(self.space)
        for pair in self.maps:
            for name in pair:
                if name not in self.space.drawn():
                    raise ProblemError("maps: " + unknown_name("drawn number", name, self.space.drawn()))

    def identity(self) -> dict[str, Any]:
        """Return what decides about every sample's results: all but how many, and what is drawn of them."""
        return {
            VERSION: __version__,
            "experiment": self.name,
            "seed": self.space.seed,
            "settings": self.experiment.as_dict(),
            "ranges": {name: self.space.ranges[name].as_dict() for name in self.space.names},
        }

    def fingerprint(self) -> str:
        """Return a short text that two sweeps share if their samples are the same."""
        text = json.dumps(self.identity(), sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def with_numbers(self, samples: int | None, seed: int | None) -> SweepConfig:
        """Return the sweep with another number of samples or seed, None for the same."""
        space = self.space if seed is None else replace(self.space, seed=seed)
        return replace(self, space=space, samples=self.samples if samples is None else samples)


def read_sweep(path: str | Path) -> SweepConfig:
    """Read a sweep's file; docs/sweeps.md describes it.

    Raises
    ------
    ProblemError
        Naming the file and the entry at fault.
    """
    import yaml

    source = Path(path)
    try:
        content = yaml.safe_load(source.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not text"
        raise ProblemError(f"cannot read {source}: {reason}") from error
    except (yaml.YAMLError, RecursionError) as error:
        raise ProblemError(f"{source} is not YAML: {' '.join(str(error).split())}") from error
    try:
        return sweep_from_dict(content, source.parent)
    except ProblemError as error:
        raise ProblemError(f"{source}: {error}") from error


def sweep_from_dict(content: Any, folder: Path | None = None) -> SweepConfig:
    """Return the sweep that parsed YAML stands for; `folder` is what files in it are relative to."""
    top = _mapping("the file", content)
    for key in top:
        if key not in _KEYS:
            raise ProblemError(unknown_name("key", key, _KEYS))
    if "experiment" not in top:
        raise ProblemError("the file lacks 'experiment'")
    name = str(top["experiment"])
    settings = _mapping("settings", top.get("settings") or {})
    ranges = _mapping("ranges", top.get("ranges") or {})
    experiment = make_experiment(name, settings)
    for given in ranges:
        if given in PARAMETERS and given not in experiment.parameters:
            raise ProblemError(unknown_name(f"parameter of {name}", given, experiment.parameters))
    place = Path() if folder is None else folder
    space = Space({n: read_range(n, entry, place) for n, entry in ranges.items()}, _whole("seed", top, 0))
    return SweepConfig(name, experiment, space, _whole("samples", top, SAMPLES), _maps(top.get("maps") or []))


def _whole(name: str, top: Mapping[str, Any], otherwise: int) -> int:
    return whole_number(name, top.get(name, otherwise))


def _maps(entry: Any) -> tuple[tuple[str, str], ...]:
    """Return pairs of different names."""
    pairs = entry if isinstance(entry, list) else None
    if pairs is None or not all(isinstance(p, list) and len(p) == 2 and p[0] != p[1] for p in pairs):
        raise ProblemError(f"maps must be a list of pairs of parameters, got {entry!r:.60}")
    return tuple((str(x), str(y)) for x, y in pairs)


def _mapping(name: str, value: Any) -> dict[str, Any]:
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise ProblemError(f"{name} must be a mapping of names, got {value!r:.60}")
    return value
