"""The command; see the package."""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import tests.same_logs
from tests.same_logs.comparing import differences
from tests.same_logs.recording import ROOT, RecordError, record
from tests.same_logs.revisions import commit, export
from tests.same_logs.scenarios import chosen
from tests.same_logs.step_times import race


def record_revision(number: str, cache: Path, names: Sequence[str], *, tell: bool = True) -> Path:
    """Return the record of a commit, made anew from the copy and the compiled kernels in a cache folder."""
    place = cache.resolve() / number[:12]
    place.mkdir(parents=True, exist_ok=True)
    export(number, place / "tree")
    record(place / "tree", place / "logs", names, place / "kernels", tell=tell)
    return place / "logs"


def reported(first: Path, second: Path, names: Sequence[str]) -> int:
    """Print every scenario's first difference, and return the exit code."""
    found = differences(first, second, names)
    for difference in found:
        print(difference)
    print(f"{len(names) - len(found)} of {len(names)} logs are the same to the last digit")
    return 1 if found else 0


def main(arguments: Sequence[str] | None = None) -> int:
    """Carry out what the command's words say and return the exit code."""
    parser = argparse.ArgumentParser(
        "python -m tests.same_logs", description=tests.same_logs.__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    actions = parser.add_subparsers(dest="action", required=True)
    for action, words in {
        "record": ["folder"], "compare": ["first", "second"], "check": ["folder"], "against": ["revision"],
        "time": ["first", "second"],
    }.items():  # fmt: skip
        own = actions.add_parser(action)
        for word in words:
            own.add_argument(word, type=str if word == "revision" else Path)
        if action == "time":
            own.add_argument("--pairs", type=int, default=5, help="pairs of runs")
            continue
        own.add_argument("--only", default="", help="scenarios or groups, with commas between")
        if action != "compare":
            own.add_argument("--tree", type=Path, default=ROOT, help="checkout that is run, by default this")
        if action == "against":
            own.add_argument("--cache", type=Path, help="folder that keeps the revision's compiled kernels")
    given = parser.parse_args(arguments)
    if given.action == "time":
        race(given.first, given.second, given.pairs)
        return 0
    try:
        return _carried_out(given, chosen([name for name in given.only.split(",") if name]))
    except (RecordError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2


def _carried_out(given: argparse.Namespace, names: Sequence[str]) -> int:
    """Return the exit code of an action on scenarios."""
    if given.action == "compare":
        return reported(given.first, given.second, names)
    if given.action == "record":
        record(given.tree, given.folder, names)
        return 0
    with ExitStack() as stack:
        made = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="surefoot-same-")))
        if given.action == "check":
            base = given.folder
        else:
            number = commit(given.revision)
            if number is None:
                raise ValueError(f"the history of {ROOT} has no revision {given.revision!r}")
            base = record_revision(number, given.cache or made / "base", names)
        record(given.tree, made / "logs", names)
        return reported(base, made / "logs", names)


if __name__ == "__main__":
    sys.exit(main())
