"""A sweep as data: which experiment, over which ranges, how many samples, from which seed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from surefoot import __version__
from surefoot.base.arrays import whole_number
from surefoot.base.errors import ProblemError, check_name, located, shown
from surefoot.base.text_files import path_of, read_yaml, table_of
from surefoot.worlds.sweep.function import experiment_of
from surefoot.worlds.sweep.sample_experiment import SweepExperiment, make_experiment
from surefoot.worlds.sweep.space import MOST, Space, read_range

_KEYS = ("experiment", "samples", "seed", "settings", "ranges", "maps")
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
        Ranges and seed; a sample's values take the place of the experiment's settings.
    samples
        How many; more can be asked for later, the first ones stay what they are.
    maps
        Pairs of parameters that survival is drawn over; empty to choose.
    """

    name: str
    experiment: SweepExperiment
    space: Space
    samples: int = SAMPLES
    maps: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        whole_number("seed", self.space.seed)
        if whole_number("samples", self.samples, low=1) > MOST:
            raise ProblemError(f"samples must be at most 2^30, got {self.samples}")
        ranges = self.space.ranges
        first: dict[str, Any] = {name: drawn.ends[0] for name, drawn in ranges.items()}
        replace(self.experiment, **first).check()
        for name, drawn in ranges.items():
            for end in drawn.ends[1:]:  # what an experiment refuses is refused before long work
                replace(self.experiment, **{**first, name: end})
        for name in (name for pair in self.maps for name in pair):
            check_name("drawn number", name, self.space.drawn, "maps")

    def identity(self) -> dict[str, Any]:
        """Return what decides about every sample's results: all but how many, and what is drawn of them.

        Another version of Surefoot may come to other results; another one of SciPy may draw other points.
        """
        code = {"code": self.experiment.code} if self.experiment.code else {}
        return {
            **code,
            "surefoot": __version__,
            "experiment": self.name,
            "seed": self.space.seed,
            "settings": asdict(self.experiment),
            "ranges": {name: asdict(drawn) for name, drawn in self.space.ranges.items()},
            "first": dict(self.space.sample([1])[0].values),
        }

    def fingerprint(self) -> str:
        """Return a short text that two sweeps share if their samples are the same."""
        text = json.dumps(self.identity(), sort_keys=True, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def label(self, name: str) -> str:
        """Return a parameter's name with its unit, such as "delay [s]"."""
        unit = self.experiment.unit(name)
        return f"{name} [{unit}]" if unit else name

    def with_numbers(self, samples: int | None, seed: int | None) -> SweepConfig:
        """Return the sweep with another number of samples or seed, None for the same."""
        space = self.space if seed is None else replace(self.space, seed=seed)
        return replace(self, space=space, samples=self.samples if samples is None else samples)


def read_sweep(path: str | Path, allow_code: bool = False) -> SweepConfig:
    """Read a sweep's file; docs/sweeps.md describes it.

    With `allow_code` its experiment may be a function, "module:function", which is run.

    Raises
    ------
    ProblemError
        Naming the file and the entry at fault.
    """
    source = path_of(path)
    content = read_yaml(source)
    with located(source):
        return sweep_from_dict(content, source.parent, allow_code)


def sweep_from_dict(content: Any, folder: Path | None = None, allow_code: bool = False) -> SweepConfig:
    """Return the sweep that parsed YAML stands for; `folder` is what files in it are relative to."""
    top = table_of("the file", content, _KEYS, required=("experiment",))
    name = str(top["experiment"])
    settings = table_of("settings", top.get("settings") or {})
    entries = table_of("ranges", top.get("ranges") or {})
    if ":" in name and not allow_code:
        raise ProblemError(
            f"experiment {name} is code, which would be run: allow it with --allow-code "
            "(sf.read_sweep(..., allow_code=True))"
        )
    own = experiment_of(name, settings, entries, (folder or Path()).resolve()) if ":" in name else None
    experiment = own or make_experiment(name, settings)
    read = {n: read_range(experiment, n, entry) for n, entry in entries.items()}
    ranges = {n: read[n] for n in experiment.parameters() if n in read}  # the file's order does not matter
    if own is not None:
        replace(own, **{name: drawn.ends[0] for name, drawn in ranges.items()}).learn()
    maps = top.get("maps") or []
    if type(maps) is not list or any(type(p) is not list or len(p) != 2 or p[0] == p[1] for p in maps):
        raise ProblemError(f"maps must be a list of pairs of parameters, got {shown(maps)}")
    samples = whole_number("samples", top.get("samples", SAMPLES))
    space = Space(ranges, whole_number("seed", top.get("seed", 0)))
    return SweepConfig(name, experiment, space, samples, tuple((str(x), str(y)) for x, y in maps))
