"""Vary the limits of an audit's story, one at a time, over strangers' loops that fail of known causes.

Run: python -m benchmarks.story_limits [NAME...] [--seeds 10] [--lawful 15] [--cause NAME] [--untold]
[--keep FOLDER] [--json]. NAME is a limit of `surefoot.records.audit.story.story_limits.StoryLimits`; all
without one. FOLDER keeps the runs, which are simulated once. Only the seeds for tuning are looked at, never
those that are held back. With --cause only runs that fail of it (may be repeated); with --untold what a loop
changed in its model is left out of its log, as it is out of one that no `sf.record` made.

A run is told right if its first cause is the one that was injected, in name, place and time, or if it is a
lawful control and no cause is named (`benchmarks.foreign.race`). Each limit is moved away from its value in
both directions until fewer runs are told right, by more than one: one is a matter of a seed. Printed are the
range over which as many are, and how many are beyond it. The choice of a limit is repeated if no value that
was tried tells more runs right, and at least one tells fewer; a limit whose value makes no difference is not
decided by these runs.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import surefoot as sf
from benchmarks.foreign.causes import CAUSES
from benchmarks.foreign.fault import Fault, Run
from benchmarks.foreign.loops import LOOPS, failed
from benchmarks.foreign.race import LAWFUL, TUNING, is_right, plan
from benchmarks.limit_choice import Choice, vary
from surefoot.base.errors import check_name
from surefoot.base.settings import DescribedSetting, describe
from surefoot.records.audit import auditor
from surefoot.records.audit.story import story
from surefoot.records.audit.story.causes import RULES, WRONG_FRAME, Rule
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.story_limits import STORY_LIMITS, StoryLimits
from surefoot.records.log import Log
from surefoot.records.log.reading import read_log

SEED = 1
"""Difference of runs told right that may be a matter of one seed."""


@dataclass(frozen=True)
class Told:
    """A run, and what its audit gives the story to read.

    Attributes
    ----------
    run, given
        The run, and the first arguments of `story_of`.
    known
        By rule: the limits that it reads in this run, and what it finds with their own values.
    """

    run: Run
    given: tuple[Any, ...]
    known: Mapping[Rule, tuple[set[str], tuple[Sign, ...]]]

    def right(self, limits: StoryLimits, changed: str) -> bool:
        """Return whether the story says the right thing with these limits, of which one may be changed.

        Rules that do not read it find what they have found.
        """
        rules = [self._known_rule(rule, changed) for rule in RULES]
        with replaced(story, RULES=rules, WRONG_FRAME=self._known_rule(WRONG_FRAME, changed)):
            log, setting, symptoms, reason = self.given
            causes = story.story_of(log, setting, symptoms, reason, limits).causes
        if self.run.fault is None:
            return not causes
        return bool(causes) and is_right(self.run, causes[0].name, str(causes[0].where), causes[0].time)

    def _known_rule(self, rule: Rule, changed: str) -> Rule:
        read, found = self.known[rule]
        return rule if changed in read else replace(rule, find=lambda s: iter(found))


@contextmanager
def replaced(module: Any, **values: Any) -> Iterator[None]:
    """Give names of a module other values for a while."""
    before = {name: getattr(module, name) for name in values}
    vars(module).update(values)
    try:
        yield
    finally:
        vars(module).update(before)


def limits_read(rule: Rule, given: tuple[Any, ...]) -> tuple[set[str], tuple[Sign, ...]]:
    """Return the names of the limits that a rule reads of a run, and what it finds there."""
    read: set[str] = set()
    names = {one.name for one in fields(StoryLimits)}

    def get(self: Any, name: str) -> Any:
        if name in names:
            read.add(name)
        return object.__getattribute__(self, name)

    noted = type("NotedLimits", (StoryLimits,), {"__getattribute__": get})()
    read.clear()
    log, setting = given[:2]
    return read, tuple(rule.find(Signals(log.rows(slice(-story.MOST_ROWS, None)), setting, noted)))


def told_runs(
    seeds: int, lawful: int, keep: Path | None, causes: Sequence[str] = (), untold: bool = False
) -> Iterator[Told]:
    """Yield the runs of the seeds for tuning and lawful controls, audited once.

    Parameters
    ----------
    seeds, lawful
        Of each cause, and lawful controls of each loop.
    keep
        Folder of the runs; None to simulate them.
    causes
        Names; none for all.
    untold
        Whether logs are left without what the loop changed in its model.
    """
    loops = {loop.name: loop for loop in LOOPS}
    caught: list[tuple[Any, ...]] = []
    whole = story.story_of

    def noting(*given: Any) -> Any:
        caught.append(given)
        return whole(*given)

    for loop, cause, seed in plan(range(min(seeds, TUNING)), lawful, causes):
        make = partial(failed, cause, seed) if cause else partial(loops[loop].lawful, seed)
        run = make() if keep is None else _kept(keep / f"{cause or loop} {seed}", make)
        if untold:
            facts = {name: fact for name, fact in run.log.facts.items() if not name.startswith("change_")}
            run = replace(run, log=Log(dict(run.log.arrays), facts))
        with replaced(auditor, story_of=noting):
            sf.audit_log(run.log)
        given = caught.pop()
        yield Told(run, given, {rule: limits_read(rule, given) for rule in (*RULES, WRONG_FRAME)})


def _kept(path: Path, make: Callable[[], Run]) -> Run:
    """Return a run from its file and the truth beside it, made where there is none."""
    log, truth = path.with_suffix(".npz"), path.with_suffix(".json")
    if not truth.exists():
        run = make()
        run.log.save(log)
        fault = None if run.fault is None else [run.fault.cause, list(run.fault.places)]
        said = [run.loop, run.seed, run.attempt, fault, run.onset, run.failure, run.failed_at]
        truth.write_text(json.dumps(said), encoding="utf-8")
    loop, seed, attempt, fault, onset, failure, at = json.loads(truth.read_text(encoding="utf-8"))
    known = None if fault is None else Fault(fault[0], tuple(fault[1]))
    return Run(loop, seed, attempt, read_log(log), known, onset, failure, at)


def vary_limit(one: DescribedSetting, runs: Sequence[Told]) -> Choice:
    """Return what comes of varying a limit over runs: how many are told right."""
    whole = int if one.info.whole else float
    changed = partial(replace, STORY_LIMITS)
    return vary(one, lambda value: _count(runs, changed(**{one.name: whole(value)}), one.name), SEED)


def _count(runs: Sequence[Told], limits: StoryLimits, changed: str) -> int:
    return sum(run.right(limits, changed) for run in runs)


def main() -> None:
    """Print a line for each limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="limits (default: all)")
    parser.add_argument("--seeds", type=int, default=TUNING, help="seeds of each cause")
    parser.add_argument("--lawful", type=int, default=LAWFUL, help="lawful controls of each loop")
    parser.add_argument("--cause", action="append", default=[], help="only this cause; repeatable")
    parser.add_argument("--untold", action="store_true", help="logs without what loops changed")
    parser.add_argument("--keep", type=Path, help="folder of the runs")
    parser.add_argument("--json", action="store_true", help="print JSON")
    given = parser.parse_args()
    every = {one.name: one for one in describe(STORY_LIMITS)}
    for name in given.names:
        check_name("limit of a story", name, tuple(every))
    for name in given.cause:
        check_name("cause", name, [one.name for one in CAUSES])
    if given.keep is not None:
        given.keep.mkdir(parents=True, exist_ok=True)
    runs = list(told_runs(given.seeds, given.lawful, given.keep, given.cause, given.untold))
    found = []
    for name in given.names or every:
        one = vary_limit(every[name], runs)
        found.append(asdict(one) | {"verdict": one.verdict})
        if not given.json:
            told = f"{one.verdict}; {one.score} of {len(runs)}"
            print(f"{name:12} {one.value:8.4g} {every[name].info.unit:9} {told}")
            print(f"{'':12} " + ", ".join(f"{value:.4g}: {right}" for value, right in one.tried), flush=True)
    if given.json:
        print(json.dumps(found))
    else:
        print(f"{sum(one['verdict'].startswith('as good') for one in found)} of {len(found)} limits decided")


if __name__ == "__main__":
    main()
