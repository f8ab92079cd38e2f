"""Folds of a cross-validation on several processes, each kept in a folder as soon as it is judged."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from importlib.metadata import version
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.cores import cores
from surefoot.base.errors import writing
from surefoot.records.identification.cross_validation import KINDS, JudgedFold, judge_fold
from surefoot.records.identification.toss_errors import TossErrors
from surefoot.records.identification.tosses import Tosses


def judge_folds(
    tosses: Tosses,
    models: Sequence[Any],
    folds: int,
    folder: Path,
    jobs: int | None,
    show: Callable[[float], None] | None,
    **settings: Any,
) -> list[JudgedFold]:
    """Return all folds in their order, those that the folder holds as they are there.

    Parameters
    ----------
    tosses, models, folds, settings
        See `cross_validate`.
    folder
        Of the folds; a new one is made.
    jobs
        Processes; None for all cores.
    show
        Called with how many folds are judged.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    places = {fold: folder / f"fold-{fold + 1}-of-{folds}.npz" for fold in range(folds)}
    done = {fold: _read(place) for fold, place in places.items() if place.is_file()}
    left = [fold for fold in places if fold not in done]
    judged = _judge(tosses, models, folds, left, min(len(left), jobs or cores()), settings)
    for fold, one in judged:
        with writing(places[fold]):
            _write(places[fold], one)
        done[fold] = one
        if show is not None:
            show(float(len(done)))
    return [done[fold] for fold in range(folds)]


def folds_folder(parent: Path, tosses: Tosses, models: Sequence[Any], settings: dict[str, Any]) -> Path:
    """Return where folds of these tosses, laws and settings are kept: a name of its own for each of them."""
    told = hashlib.sha256()
    for array in (tosses.states, tosses.starts, np.array(tosses.dt)):
        told.update(np.ascontiguousarray(array).tobytes())
    told.update(repr(tosses.cube).encode())
    for key, value in sorted(settings.items()):
        is_file = isinstance(value, Path) and value.is_file()
        told.update(value.read_bytes() if is_file else f"{key}={value}".encode())
    packages = {"surefoot", *(model.name for model in models)}
    versions = [f"{name} {version(name)}" for name in sorted(packages) if find_spec(name)]
    told.update(repr([[model.name for model in models], versions]).encode())
    return parent / f"folds-{told.hexdigest()[:8]}"


def _judge(
    tosses: Tosses, models: Sequence[Any], folds: int, left: list[int], workers: int, settings: dict[str, Any]
) -> Iterator[tuple[int, JudgedFold]]:
    """Yield numbers and judgements of folds as they are done."""
    if workers <= 1:
        for fold in left:
            yield fold, judge_fold(tosses, models, folds, fold, **settings)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        waiting = {pool.submit(judge_fold, tosses, models, folds, fold, **settings): fold for fold in left}
        try:
            for future in as_completed(waiting):
                yield waiting[future], future.result()
        except BaseException:  # an interrupt, or a fold that fails: the others are not waited for
            for process in list(pool._processes.values()):
                process.terminate()
            raise


def _write(place: Path, fold: JudgedFold) -> None:
    """Write a fold as an .npz without pickles; whole or not at all."""
    arrays: dict[str, Any] = {}
    for law, errors in fold.errors.items():
        arrays |= {f"{law}/{kind}": getattr(errors, kind) for kind in KINDS}
        arrays |= {f"{law}/value/{name}": np.float64(value) for name, value in fold.values[law].items()}
    draft = place.with_name(f"{place.stem}.{os.getpid()}.npz")
    np.savez(draft, **arrays)
    draft.replace(place)


def _read(place: Path) -> JudgedFold:
    """Read a fold that `_write` wrote."""
    errors: dict[str, dict[str, Any]] = {}
    values: dict[str, dict[str, float]] = {}
    with np.load(place, allow_pickle=False) as file:
        for key in file:
            law, *rest = key.split("/")
            if rest[0] == "value":
                values.setdefault(law, {})[rest[1]] = float(file[key])
            else:
                errors.setdefault(law, {})[rest[0]] = np.array(file[key])
    return JudgedFold({law: TossErrors(**own) for law, own in errors.items()}, values)
