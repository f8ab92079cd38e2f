"""The story of a run: what happened, in order, and which cause came first."""

from __future__ import annotations

from dataclasses import replace

from surefoot.records.audit.log_context import Setting
from surefoot.records.audit.report import Finding
from surefoot.records.audit.story.causes import RULES, WRONG_FRAME, Rule, frame_sign
from surefoot.records.audit.story.counterfactuals import Without
from surefoot.records.audit.story.failure import fall, slid_far, slide, stray
from surefoot.records.audit.story.sign import Sign
from surefoot.records.audit.story.signals import Signals
from surefoot.records.audit.story.story_limits import STORY_LIMITS, StoryLimits
from surefoot.records.audit.story.told import Cause, Event, Story
from surefoot.records.log import Log

DRAWN_OUT = ("strays", "stands crooked")
"""Failures without a moment."""
MOST_PLACES = 4
"""Places of a cause that are named."""
MOST_ROWS = 200_000
"""Rows that a story is read from: of a longer log the last."""


def story_of(
    log: Log, setting: Setting, symptoms: tuple[Finding, ...], task_failed: str,
    limits: StoryLimits = STORY_LIMITS,
) -> Story:  # fmt: skip
    """Return the story of a log.

    Parameters
    ----------
    log, setting
        The log and what its audit knows of it.
    symptoms
        Of its audit, the strongest first.
    task_failed
        How the task failed; empty if it did not.
    limits
        What counts as an event, and as evidence.
    """
    if len(log) < 2 or "forces" not in log or not setting.names:
        return Story()
    if len(log) > MOST_ROWS:
        log = log.rows(slice(len(log) - MOST_ROWS, None))
    s = Signals(log, setting, limits)
    happened = [event for event in (fall(s), slide(s), stray(s)) if event is not None]
    failed = next(iter(happened), None)  # a fall says more than a slide, that more than a way
    if failed is None and task_failed:
        failed = Event("task failed", float(s.time[-1]), "body", task_failed)
    frame = next(WRONG_FRAME.find(s), None) or frame_sign(symptoms)
    if frame is not None and (failed is None or frame.time < failed.time):
        # what is read off such forces says nothing
        cause = _cause(WRONG_FRAME, frame)
        return Story((_event(cause),), (cause,), failed)
    cheap = [rule for rule in RULES if not rule.dear and (rule.alone or rule.outside)]
    rules = RULES if failed is not None or s.bolted else cheap
    found = [(rule, sign) for rule in rules if not (rule.acts and s.jointless) for sign in rule.find(s)]
    ordered, failed = _explain(found, s, failed, happened)
    asked = [(rule, sign, _without(rule, sign, s, failed)) for rule, sign in ordered]
    causes = tuple(
        replace(_cause(rule, sign), without="" if held is None else held.words)
        for rule, sign, held in asked
        if held is None or held.held
    )
    if failed is not None and causes:
        failed = replace(failed, because=causes[0].name)
    # in the order of the table where times are equal: a set's order is another one in each process
    events = dict.fromkeys([
        *(_with_its_cause(rule, sign, found, s) for rule, sign in found),
        *(failed if failed is not None and event.name == failed.name else event for event in happened),
    ])  # fmt: skip
    return Story(tuple(sorted(events, key=lambda e: e.time)), causes, failed)


def _explain(
    found: list[tuple[Rule, Sign]], s: Signals, failed: Event | None, happened: list[Event]
) -> tuple[list[tuple[Rule, Sign]], Event | None]:
    """Return the causes that may explain what went wrong, and that: the next where none explains the first.

    A foot that slides a little has not led a robot astray that loses its way later for another reason; after
    a fall nothing more has to be explained.
    """
    fell = failed is not None and failed.name == "fell"
    for event in [failed, *(() if fell else happened[1:])]:
        ordered = _order(found, s, event)
        if not ordered and event is not None and event.name in DRAWN_OUT:
            # who loses its way little by little may have done so before the cause of its end
            ordered = _order(found, s, replace(event, time=float(s.time[-1])))
        if not ordered and event is not None and event.name == "slides":
            ordered = _order([one for one in found if one[0].outside], s, replace(event, time=_slid_far(s)))
        if ordered:
            return ordered, event
    return [], failed


def _slid_far(s: Signals) -> float:
    """Return when a slide had gone so far that it matters [s]: feet that slip now and then begin it early."""
    row = slid_far(s)
    return float(s.time[-1 if row is None else row[0]])


def _without(rule: Rule, sign: Sign, s: Signals, failed: Event | None) -> Without | None:
    """Return what would have been without a cause; None where nothing failed, or the log does not tell."""
    return None if failed is None or rule.without is None else rule.without(s, sign, failed)


def _cause(rule: Rule, sign: Sign) -> Cause:
    return Cause(rule.name, sign.time, sign.where, sign.evidence, rule.refuted, rule.remedy)


def _event(cause: Cause) -> Event:
    return Event(cause.name, cause.time, cause.where, cause.evidence)


def _with_its_cause(rule: Rule, sign: Sign, found: list[tuple[Rule, Sign]], s: Signals) -> Event:
    """Return the event of a sign, with the cause that brought it about: the one that explains a failure then.

    What comes from outside nothing brings about, nor what other links of the same cause have begun.
    """
    event = _event(_cause(rule, sign))
    if rule.outside:
        return event
    before = [(r, x) for r, x in found if x.time < sign.time and r.name != rule.name and not r.residual]
    first = next(iter(_order(before, s, event)), None)
    return event if first is None else replace(event, because=first[0].name)


def _order(found: list[tuple[Rule, Sign]], s: Signals, failed: Event | None) -> list[tuple[Rule, Sign]]:
    """Return the causes that may explain the failure, one of a name, the likeliest first."""
    left = [(rule, sign) for rule, sign in found if _may_explain(rule, sign, s, failed)]
    steps = [sign for _, sign in left if sign.since is not None]
    left.sort(key=lambda one: (one[0].residual, _is_of_a_step(one, steps), _rank(one, s)))
    names = dict.fromkeys(rule.name for rule, _ in left)
    return [_join_signs([one for one in left if one[0].name == name], s) for name in names]


def _join_signs(same: list[tuple[Rule, Sign]], s: Signals) -> tuple[Rule, Sign]:
    """Return the first sign of a cause, with the figures of the strongest and all its places."""
    rule, first = same[0]
    near = [sign for _, sign in same if sign.time - first.time <= s.limits.brief]
    near.sort(key=lambda sign: -sign.strength)
    places = list(dict.fromkeys(sign.where for sign in near))
    more = f"; so do {len(places) - 1} more" if len(places) > 1 else ""
    best = near[0]
    where = ", ".join(places[:MOST_PLACES])
    return rule, Sign(first.time, where, best.evidence + more, best.strength, first.since)


def _is_of_a_step(one: tuple[Rule, Sign], steps: list[Sign]) -> bool:
    """Return whether a robot's own trouble began within a step that went wrong: it comes with it."""
    rule, sign = one
    own = not rule.outside and not rule.leads and sign.since is None
    return own and any(x.since <= sign.time <= x.time for x in steps if x.since is not None)


def _rank(one: tuple[Rule, Sign], s: Signals) -> tuple[float, bool]:
    """Return what orders causes: when they began, those from outside before what follows from them."""
    rule, sign = one
    begun = sign.time if sign.shown is None else sign.shown
    return begun - (s.limits.window if rule.outside or rule.leads else 0.0), not rule.outside


def _may_explain(rule: Rule, sign: Sign, s: Signals, failed: Event | None) -> bool:
    """Return whether a cause began before the failure, and not so long before that it has faded."""
    if failed is None:
        return not rule.residual and (rule.alone or not s.floating or not s.torques.shape[1])
    shown = sign.time if sign.shown is None else sign.shown
    if sign.time > failed.time + 0.5 * s.limits.brief:
        return False
    if rule.leads and failed.name == "fell" and failed.time - sign.time < 0.5 * s.pendulum_time:
        return False  # nothing falls that fast: it was falling already
    return rule.lasts or failed.time - shown < s.limits.fades
