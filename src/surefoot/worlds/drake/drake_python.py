"""The interpreter that runs Drake: this one, or that of an environment of Drake's own.

Drake's wheel is large and bound to single Python versions, so it may live elsewhere: SUREFOOT_DRAKE_PYTHON
names an interpreter that can import pydrake. Workers run in it as scripts and import nothing of Surefoot.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from surefoot.base.errors import MissingExtra, ModelError

PACKAGE, EXTRA = "drake", "drake"
VARIABLE = "SUREFOOT_DRAKE_PYTHON"


def interpreter() -> str:
    """Return the interpreter to run a worker with."""
    return os.environ.get(VARIABLE) or sys.executable


def present() -> bool:
    """Return whether Drake is importable here, or another interpreter is named for it; it is not tried."""
    return bool(os.environ.get(VARIABLE)) or importlib.util.find_spec("pydrake") is not None


class Worker:
    """A process of Drake's that answers a line of JSON with another; it lives until `close`.

    Parameters
    ----------
    script
        File that it runs; an answer with "error" in it is a failure.

    Raises
    ------
    MissingExtra
        If Drake cannot be imported, and no other interpreter is named.
    """

    def __init__(self, script: Path) -> None:
        if not present():
            raise MissingExtra(PACKAGE, EXTRA)
        self._script = script
        self._process: subprocess.Popen[str] | None = None

    def ask(self, task: Any) -> dict[str, Any]:
        """Return the answer to a task.

        Raises
        ------
        ModelError
            If the interpreter cannot be run, or its run fails.
        """
        process = self._start_worker()
        pipe_in, pipe_out = process.stdin, process.stdout
        assert pipe_in is not None and pipe_out is not None  # noqa: PT018 - asked for
        try:
            pipe_in.write(json.dumps(task) + "\n")
            pipe_in.flush()
            answer: dict[str, Any] = json.loads(pipe_out.readline())
        except (BrokenPipeError, json.JSONDecodeError) as error:
            self.close()
            raise ModelError("Drake's process ended before it answered; its message stands above") from error
        if "error" in answer:
            raise ModelError(f"Drake's run failed: {answer['error']}")
        return answer

    def _start_worker(self) -> subprocess.Popen[str]:
        if self._process is None:
            python = interpreter()
            try:
                self._process = subprocess.Popen(
                    [python, str(self._script)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
                )
            except OSError as error:
                raise ModelError(f"{VARIABLE}={python!r} cannot be run: {error}") from error
        return self._process

    def close(self) -> None:
        """End the other process."""
        if self._process is None:
            return
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(BrokenPipeError):  # it ended before it read all
                    pipe.close()
        self._process.wait(timeout=20)
        self._process = None

    def __del__(self) -> None:
        if getattr(self, "_process", None) is not None:
            self.close()
