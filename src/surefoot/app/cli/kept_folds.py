"""Folds of a cross-validation on several processes: each law of each is kept as soon as it is judged."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.app.cli.processes import results_of
from surefoot.base.errors import writing
from surefoot.records.identification.cross_validation import KINDS, JudgedLaw, judge_fold
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.toss_fit import BodyNumbers, Estimate
from surefoot.records.identification.toss_model import TossModel
from surefoot.records.identification.tosses import Tosses

KIND = 4
"""Of what is kept: another one for each change of what a fit finds, so that no table mixes two kinds."""


@dataclass(frozen=True)
class FoldFiles:
    """The laws of a fold as files of a folder.

    Attributes
    ----------
    folder
        Where they are.
    fold, folds
        Number of the fold, from 0, and how many there are.
    """

    folder: Path
    fold: int
    folds: int

    def read(self, model: TossModel) -> JudgedLaw | None:
        """Return what is kept of a law; None without it."""
        place = self.place(model)
        return _read(place) if place.is_file() else None

    def write(self, model: TossModel, judged: JudgedLaw) -> None:
        """Keep a law, as a whole file or none."""
        with writing(self.folder):
            _write(self.place(model), judged)

    def place(self, model: TossModel) -> Path:
        """Return the file of a law; that of a package's simulator has its version in its name."""
        try:
            release = f"-{version(model.name)}"
        except PackageNotFoundError:
            release = ""
        return self.folder / f"fold-{self.fold + 1}-of-{self.folds}-{model.name}{release}.npz"


def judge_folds(
    tosses: Tosses,
    models: Sequence[TossModel],
    folds: int,
    folder: Path,
    jobs: int | None,
    show: Callable[[float], None] | None,
    **settings: Any,
) -> list[dict[str, JudgedLaw]]:
    """Return all folds in their order; what the folder holds is read and not judged anew.

    Parameters
    ----------
    tosses, models, folds, settings
        See `cross_validate`.
    folder
        Of the folds; a new one is made.
    jobs
        Processes; None for all cores.
    show
        Called now and then with how many laws are judged, over all folds.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)

    def count() -> None:
        if show is not None:
            show(float(count_kept(models, folds, folder)))

    tasks = [(tosses, models, folds, fold, folder, settings) for fold in range(folds)]
    out: dict[int, dict[str, JudgedLaw]] = {}
    for fold, judged in results_of(_judge, tasks, jobs, count):
        out[fold] = judged
        count()
    return [out[fold] for fold in range(folds)]


def count_kept(models: Sequence[TossModel], folds: int, folder: Path) -> int:
    """Return how many of the laws of all folds a folder holds."""
    return sum(FoldFiles(folder, fold, folds).place(m).is_file() for fold in range(folds) for m in models)


def read_folds(models: Sequence[TossModel], folds: int, folder: Path) -> list[dict[str, JudgedLaw] | None]:
    """Return all folds in their order; None for one of which a folder does not hold all laws."""
    out: list[dict[str, JudgedLaw] | None] = []
    for fold in range(folds):
        files = FoldFiles(folder, fold, folds)
        laws = {model.name: files.read(model) for model in models}
        whole = {name: law for name, law in laws.items() if law is not None}
        out.append(whole if len(whole) == len(models) else None)
    return out


def folds_folder(parent: Path, tosses: Tosses, first: TossModel, settings: dict[str, Any]) -> Path:
    """Return where folds of these tosses, settings and first law are kept: a name of its own for each."""
    told = hashlib.sha256()
    for array in (tosses.states, tosses.starts, np.array(tosses.dt)):
        told.update(np.ascontiguousarray(array).tobytes())
    told.update(repr(tosses.cube).encode())
    for key, value in sorted(settings.items()):
        is_file = isinstance(value, Path) and value.is_file()
        told.update(value.read_bytes() if is_file else f"{key}={value}".encode())
    told.update(f"{FoldFiles(Path(), 0, 1).place(first).name} {version('surefoot')} {KIND}".encode())
    return parent / f"folds-{told.hexdigest()[:8]}"


def _judge(
    tosses: Tosses, models: Sequence[TossModel], folds: int, fold: int, folder: Path, settings: dict[str, Any]
) -> dict[str, JudgedLaw]:
    """Judge a fold, and keep its laws."""
    return judge_fold(tosses, models, folds, fold, kept=FoldFiles(folder, fold, folds), **settings)


def _write(place: Path, judged: JudgedLaw) -> None:
    """Write a law as an .npz without pickles."""
    numbers = judged.numbers
    arrays: dict[str, Any] = {f"error/{kind}": getattr(judged.errors, kind) for kind in KINDS}
    arrays |= {f"found/{name}": np.float64(value) for name, value in judged.values.items()}
    arrays |= {f"value/{name}": np.float64(value) for name, value in numbers.values.items()}
    arrays |= {f"draw/{name}": draws for name, draws in numbers.draws.items()}
    arrays |= {f"estimate/{name}": np.array(astuple(e)[:3]) for name, e in numbers.parameters.items()}
    arrays |= {f"unit/{name}": np.array(e.unit) for name, e in numbers.parameters.items()}
    for name, own in (("scale", numbers.scale), ("growth", numbers.growth)):
        arrays[f"{name}/"] = np.empty(0) if own is None else own
    draft = place.with_name(f"{place.stem}.{os.getpid()}.part")
    with draft.open("wb") as file:
        np.savez(file, **arrays)
    draft.replace(place)


def _read(place: Path) -> JudgedLaw:
    """Read a law that `_write` wrote."""
    parts: dict[str, dict[str, Any]] = {}
    with np.load(place, allow_pickle=False) as file:
        for key in file:
            part, name = key.split("/", 1)
            parts.setdefault(part, {})[name] = file[key]
    found, values = ({name: float(x) for name, x in parts[part].items()} for part in ("found", "value"))
    units = parts["unit"]
    estimates = {
        name: Estimate(float(value), float(low), float(high), str(units[name]))
        for name, (value, low, high) in parts["estimate"].items()
    }
    loss = (parts[name][""] for name in ("scale", "growth"))
    numbers = BodyNumbers(values, parts["draw"], estimates, *(own if own.size else None for own in loss))
    return JudgedLaw(TossErrors(**parts["error"]), found, numbers)
