"""The stacks by name, one line each, and which of them can run here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.stacks.learned import LearnedStack
from benchmarks.stacks.peer import Peer
from benchmarks.stacks.stack import Stack, Surefoot
from surefoot.base.errors import ProblemError, unknown_name

PEERS = {
    "go2-convex-mpc": Peer("go2-convex-mpc", "go2_convex_mpc.py", ("go2",)),
}
"""Stacks that run from a user's checkout."""
NAMES = ("surefoot", *PEERS)


@dataclass(frozen=True)
class Chosen:
    """The stacks that run, and why others do not."""

    stacks: tuple[Stack, ...]
    absent: dict[str, str]


def choose_stacks(
    names: Sequence[str] | None, checkouts: Mapping[str, Path | None], policies: Sequence[Path] = ()
) -> Chosen:
    """Return the named stacks, or all that are here.

    Parameters
    ----------
    names
        None for all; a policy's name leaves out what is not named, too.
    checkouts
        Folders of peers; None for what the environment says.
    policies
        Networks of learned policies, each a stack more.

    Raises
    ------
    ProblemError
        For an unknown name, or a named stack that is not here.
    """
    present: list[Stack] = []
    absent: dict[str, str] = {}
    learned = [LearnedStack(policy) for policy in policies]
    known = (*NAMES, *(stack.name for stack in learned))
    for name in names or NAMES:
        if name not in known:
            raise ProblemError(unknown_name("stack", name, known))
        if name not in NAMES:
            continue
        stack = _made(name, checkouts.get(name))
        why = stack.missing()
        if why and names:
            raise ProblemError(f"--stack {name}: {why}")
        if why:
            absent[name] = why
        else:
            present.append(stack)
    for stack in learned:
        if stack.missing():
            raise ProblemError(f"--policy {stack.missing()}")
        present.append(stack)
    return Chosen(tuple(present), absent)


def _made(name: str, checkout: Path | None) -> Stack:
    if name == "surefoot":
        return Surefoot()
    return PEERS[name].at(checkout)
