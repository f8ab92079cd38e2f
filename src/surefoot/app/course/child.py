"""The process that runs a student's file and tests its functions; it reports on a pipe, line by line."""

from __future__ import annotations

import json
import os
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

import numpy as np

from surefoot.app.course.answer import Answer, Property, PropertyError
from surefoot.app.course.properties import properties_of


class Channel:
    """The way to the process that grades."""

    def __init__(self, descriptor: int) -> None:
        os.set_inheritable(descriptor, False)  # not for what the file starts
        self._descriptor = descriptor

    def send(self, **facts: Any) -> None:
        """Report facts in one line."""
        os.write(self._descriptor, (json.dumps(facts) + "\n").encode())


def run(number: str, file: str, seed: str, descriptor: str) -> NoReturn:
    """Run a file as `python FILE` does, test what it defines, report, and end the process."""
    channel = Channel(int(descriptor))
    properties = list(properties_of(number))  # imported before the file's folder is looked into
    channel.send(stage="file")
    try:
        functions = run_file(Path(file))
    except SystemExit as error:
        if error.code not in (None, 0):
            _end(channel, bad=f"it exits with {error.code!r}")
        functions = vars(sys.modules["__main__"])
    except BaseException as error:
        _end(channel, bad=describe(error, file))
    channel.send(stage="checks")
    answer = Answer(functions, file, lambda call: channel.send(call=call))
    for place, one in enumerate(properties):
        channel.send(property=one.words)
        failed = find_failure(answer, one, [int(seed), place])
        channel.send(
            **({"passed": one.trials} if failed is None else {"failed": failed, "last": answer.last})
        )
    _end(channel, done=True)


def run_file(path: Path) -> dict[str, Any]:
    """Run a file as the program `__main__`, with its folder the first place of its imports."""
    code = compile(path.read_bytes(), str(path), "exec")
    module = ModuleType("__main__")
    module.__file__ = str(path)
    sys.modules["__main__"] = module
    sys.argv = [str(path)]
    sys.path.insert(0, str(path.resolve().parent))
    exec(code, vars(module))
    return vars(module)


def find_failure(answer: Answer, one: Property, seed: list[int]) -> str | None:
    """Return what a property says of the first input for which it fails, or None."""
    for trial in range(one.trials):
        try:
            one.check(answer, np.random.default_rng([*seed, trial]))
        except PropertyError as error:
            return str(error)
        except (ValueError, TypeError, IndexError) as error:  # what was returned is no such array
            return f"what it returns cannot be used: {type(error).__name__}: {error}"
    return None


def describe(error: BaseException, file: str) -> str:
    """Return an error of a file in one line, with the line of the file."""
    if isinstance(error, SyntaxError):
        return f"line {error.lineno}: {error.msg}"
    lines = [s.lineno for s in traceback.extract_tb(error.__traceback__) if s.filename == file]
    where = f"line {lines[-1]}: " if lines else ""
    return f"{where}{type(error).__name__}: {' '.join(str(error).split())}"


def _end(channel: Channel, **facts: Any) -> NoReturn:
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    channel.send(**facts)
    os._exit(0)
