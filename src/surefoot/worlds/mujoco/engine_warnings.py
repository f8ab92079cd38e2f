"""MuJoCo's warnings as text: by itself it writes them to stderr and to a file in the working folder."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def engine_warnings() -> Iterator[list[str]]:
    """Collect MuJoCo's warnings while the context lasts, each once; nothing happens without MuJoCo."""
    said: list[str] = []
    mujoco = sys.modules.get("mujoco")
    if mujoco is None:
        yield said
        return

    def note(message: str) -> None:
        text = f"MuJoCo: {message}"
        if text not in said:
            said.append(text)

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(note)
    try:
        yield said
    finally:
        mujoco.set_mju_user_warning(before)
