"""Revisions of the checkout: which one each group is held against, and a copy of one to run."""

from __future__ import annotations

import io
import os
import re
import shutil
import subprocess
import tarfile
from pathlib import Path
from typing import Any

from tests.same_logs.recording import ROOT
from tests.same_logs.scenarios import GROUPS

BASE = Path(__file__).with_name("BASE")
"""A line `GROUP COMMIT` for each group: where a law is replaced on purpose, its group's line is moved on."""
EXPORTED = ("src", "pyproject.toml")
"""What of a revision is copied."""
DATA_ONLY: Any = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}
"""How archives are unpacked: Python 3.11.0 to 3.11.3 have no filters, and from 3.12 on none is a warning."""


def read_base(text: str) -> dict[str, str]:
    """Return the commit of every group, from the lines of `BASE`; `#` begins a comment.

    Raises
    ------
    ValueError
        Naming the line at fault, or a group that is not there.
    """
    found: dict[str, str] = {}
    for number, line in enumerate(text.splitlines(), 1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        if len(words) != 2 or words[0] not in GROUPS or not re.fullmatch(r"[0-9a-f]{7,40}", words[1]):
            raise ValueError(f"line {number} is no group ({', '.join(GROUPS)}) and commit: {line!r}")
        if words[0] in found:
            raise ValueError(f"line {number} names {words[0]} again")
        found[words[0]] = words[1]
    if missing := [group for group in GROUPS if group not in found]:
        raise ValueError(f"no commit for {', '.join(missing)}")
    return found


def commit(revision: str) -> str | None:
    """Return a revision's whole commit number; None where the history does not have it."""
    done = _git("rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}")
    return done.stdout.decode().strip() if done.returncode == 0 else None


def export(number: str, folder: Path) -> None:
    """Copy a commit's package into a folder, unless it is there."""
    if folder.exists():
        return
    done = _git("archive", "--format=tar", number, *EXPORTED)
    if done.returncode != 0:
        raise ValueError(f"git archive {number}: {done.stderr.decode().strip()}")
    begun = folder.with_name(f"{folder.name}.{os.getpid()}.part")
    with tarfile.open(fileobj=io.BytesIO(done.stdout)) as archive:
        archive.extractall(begun, **DATA_ONLY)
    try:
        begun.rename(folder)  # last: a copy that was cut short is none
    except OSError:
        if not folder.exists():
            raise
        shutil.rmtree(begun)  # another process was sooner


def _git(*words: str) -> subprocess.CompletedProcess[bytes]:
    """Call git in this checkout."""
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, check=False)
