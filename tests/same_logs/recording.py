"""Write the logs of a tree: every scenario in a process of its own, which finds the tree's package first."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.same_logs.scenarios import SCENARIOS

ROOT = Path(__file__).resolve().parents[2]
AT_ONCE = 2
"""Processes at most."""
PATIENCE = 1800.0
"""How long a scenario may take, compilation of all kernels included [s]."""
RAN = (0, 1)
"""Exit codes of a run that left a log: nothing broken, something broken."""
_FROM = "import pathlib, surefoot; assert pathlib.Path(surefoot.__file__).resolve().is_relative_to({!r})"
"""Fails where another package than the tree's is found, which would be compared with itself."""


class RecordError(Exception):
    """A tree has no package, or a scenario left no log."""


def environment(tree: Path, kernels: Path | None = None) -> dict[str, str]:
    """Return what a process of a tree is started with; compiled kernels go to a folder, None for the usual.

    Linear algebra has one thread: with more, sums are grouped by how many there are.
    """
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    own = os.environ | threads | {"PYTHONPATH": str(tree / "src")}
    return own if kernels is None else own | {"NUMBA_CACHE_DIR": str(kernels)}


def record(
    tree: Path, folder: Path, names: Sequence[str], kernels: Path | None = None, *, tell: bool = True
) -> None:
    """Write NAME.npz into a folder for every scenario; what is there of that name is replaced.

    Parameters
    ----------
    tree
        Checkout whose `src` is run.
    folder
        Is made if there is none.
    names
        Of `SCENARIOS`.
    kernels
        Where compiled kernels are kept; None for where the package keeps them.
    tell
        Whether each scenario is named on the way.

    Raises
    ------
    RecordError
        For a folder without the package, or a scenario that leaves no log.
    """
    tree = tree.resolve()
    if not (tree / "src" / "surefoot" / "__init__.py").is_file():
        raise RecordError(f"{tree} is no checkout: it has no src/surefoot")
    folder.mkdir(parents=True, exist_ok=True)
    started = environment(tree, kernels)
    _call("the package", ["-c", _FROM.format(str(tree / "src"))], folder, started)
    with ThreadPoolExecutor(AT_ONCE) as pool:
        made = [pool.submit(_record, name, folder, started) for name in names]
        try:
            for name, one in zip(names, made, strict=True):
                one.result()
                if tell:
                    print(f"{tree.name}: {name}", flush=True)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise


def _record(name: str, folder: Path, started: dict[str, str]) -> None:
    """Write one scenario's log."""
    with tempfile.TemporaryDirectory(prefix="surefoot-same-") as made:
        place = Path(made)
        words = SCENARIOS[name].arguments(place)
        if SCENARIOS[name].command:
            _call(name, ["-m", "surefoot", *words, "--out", str(place)], place, started)
        else:
            _call(name, ["-m", "tests.same_logs.outing", str(place / "out.npz")], ROOT, started)
        logs = [*place.glob("*/log.npz"), *place.glob("out.npz")]
        if len(logs) != 1:
            raise RecordError(f"{name} left {len(logs)} logs in place of one")
        shutil.move(logs[0], folder / f"{name}.npz")


def _call(name: str, words: Sequence[str], place: Path, started: dict[str, str]) -> None:
    """Run Python in a folder, or raise `RecordError` with the last lines of what it said."""
    try:
        done = subprocess.run(
            [sys.executable, *words], cwd=place, env=started, capture_output=True, text=True,
            timeout=PATIENCE, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired as error:
        raise RecordError(f"{name} took more than {PATIENCE:.0f} s") from error
    if done.returncode not in RAN or "Traceback" in done.stderr:
        said = "\n".join(done.stderr.splitlines()[-12:])
        raise RecordError(f"{name} ended with exit code {done.returncode}:\n{said}")
