"""Where commands write: a new folder each time, and JSON that is JSON."""

from __future__ import annotations

import contextlib
import json
import os
from datetime import datetime
from pathlib import Path
from typing import Any

from surefoot.base.errors import ProblemError
from surefoot.base.text_files import plain_value

_made: list[Path] = []
"""Folders of the run, those above them that were not there among them."""


def drop_empty_folders() -> None:
    """Remove the folders of the run into which nothing was written: an interrupted run leaves none."""
    while _made:
        with contextlib.suppress(OSError):  # it holds something
            _made.pop().rmdir()


def new_run_folder(parent: Path, name: str) -> Path:
    """Make and return a new folder `parent/name-TIME`; nothing that exists is touched.

    Raises
    ------
    ProblemError
        If the folder cannot be made or written to.
    """
    stamp = datetime.now().strftime("%Y%m%d-%H%M%S")
    for attempt in range(1000):
        folder = parent / (f"{name}-{stamp}" + (f"-{attempt}" if attempt else ""))
        above = [path for path in reversed(folder.absolute().parents) if not path.exists()]
        try:
            folder.mkdir(parents=True)
        except FileExistsError as error:
            if not folder.exists():  # a parent is a file
                raise ProblemError(f"cannot write to --out {parent}: {error.strerror}") from error
            continue
        except OSError as error:
            raise ProblemError(f"cannot write to --out {parent}: {error.strerror}") from error
        if not os.access(folder, os.W_OK):
            raise ProblemError(f"cannot write to --out {parent}: not writable")
        _made.extend([*above, folder])
        return folder
    raise ProblemError(f"cannot find a free folder name under {parent}")


def check_out(parent: Path | None) -> None:
    """Refuse, before long work, a parent in which `new_run_folder` could not make a folder; None is fine.

    Raises
    ------
    ProblemError
        If it, or the nearest folder above it that exists, is no folder to write to.
    """
    if parent is None:
        return
    nearest = next(p for p in (parent.absolute(), *parent.absolute().parents) if p.exists())
    if not nearest.is_dir():
        raise ProblemError(f"cannot write to --out {parent}: {nearest} is not a folder")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise ProblemError(f"cannot write to --out {parent}: {nearest} is not writable")


def to_json(value: Any) -> str:
    """Return indented, strictly valid JSON."""
    return json.dumps(plain_value(value), indent=2, allow_nan=False)
