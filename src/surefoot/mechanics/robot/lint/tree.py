"""Rules on the file and its tree: what cannot be read, what hangs on nothing, what stands there twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

from surefoot.mechanics.robot.lint.finding import Offence, Rule
from surefoot.mechanics.robot.lint.subject import Subject


def _faults(rule: str) -> Callable[[Subject], Iterator[Offence]]:
    def check(subject: Subject) -> Iterator[Offence]:
        for fault in subject.facts.faults:
            if fault.rule == rule:
                yield Offence(fault.place, fault.value, fault.detail or "a finite number is needed")

    return check


def _broken_trees(subject: Subject) -> Iterator[Offence]:
    yield from _faults("tree-broken")(subject)
    facts = subject.facts
    if facts.format != "urdf":
        return
    links = {link.name for link in facts.links}
    for joint in facts.joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                yield Offence(
                    f"joint {joint.name}", f"{end} link {name or 'missing'}", "the file has no such link"
                )
    for name, count in Counter(joint.child for joint in facts.joints if joint.child in links).items():
        if count > 1:
            joints = ", ".join(joint.name for joint in facts.joints if joint.child == name)
            yield Offence(
                f"link {name}", f"child of {count} joints", f"joints {joints}; a tree has one above each link"
            )
    roots = [link.name for link in facts.links if all(joint.child != link.name for joint in facts.joints)]
    if len(roots) > 1:
        yield Offence(f"link {roots[1]}", f"{len(roots)} roots", f"no joint ties it to {roots[0]}")
    elif links and not roots:
        yield Offence(f"link {facts.links[0].name}", "no root", "the joints close a loop")


def _repeated_names(subject: Subject) -> Iterator[Offence]:
    if subject.facts.format != "urdf":  # MuJoCo refuses them itself
        return
    for kind, parts in (("link", subject.facts.links), ("joint", subject.facts.joints)):
        for name, count in Counter(part.name for part in parts).items():
            if count > 1 or not name:
                yield Offence(
                    f"{kind} {name or '(no name)'}", f"{count} times", "each needs a name of its own"
                )


def _lone_mimics(subject: Subject) -> Iterator[Offence]:
    names = {joint.name for joint in subject.facts.joints}
    for joint in subject.facts.joints:
        if joint.mimics and joint.mimics not in names:
            yield Offence(f"joint {joint.name}", f"mimics {joint.mimics}", "the file has no such joint")


def _refusals(subject: Subject) -> Iterator[Offence]:
    if subject.refusal and not any(fault.rule == "file-unreadable" for fault in subject.facts.faults):
        yield Offence(f"file {subject.facts.path.name}", "does not load", subject.refusal)


def _second_bases(subject: Subject) -> Iterator[Offence]:
    robot, facts = subject.robot, subject.facts
    for joint in facts.joints:
        if facts.format == "urdf" and joint.kind == "floating" and robot is not None and robot.floating:
            detail = "the loader adds a free base of its own: two of them make the mass matrix singular"
            yield Offence(f"joint {joint.name}", "type floating", detail)


TREE_RULES = (
    Rule(
        "file-unreadable",
        "the file",
        "error",
        "Give a .urdf, or an .xml that is MJCF.",
        _faults("file-unreadable"),
    ),
    Rule(
        "load-refused",
        "what loading the robot said",
        "error",
        "Mend what the message names; findings above it are the usual causes.",
        _refusals,
    ),
    Rule("not-a-number", "numbers of the file", "error", "Write a finite number.", _faults("not-a-number")),
    Rule(
        "tree-broken",
        "parents and children of joints",
        "error",
        "Name links that exist, one joint above each but the root.",
        _broken_trees,
    ),
    Rule(
        "base-twice",
        "free joints of a URDF",
        "error",
        "Remove the floating joint and its massless root link, or load with fixed_base=True.",
        _second_bases,
    ),
    Rule("name-twice", "names of links and joints", "error", "Rename one of them.", _repeated_names),
    Rule("mimic-unknown", "<mimic> of joints", "error", "Name the joint that it follows.", _lone_mimics),
)
"""The family."""
