"""Ranges that a URDF leaves out: of joints of a limb that are continuous, or have a limit without numbers.

Limits that are written as infinite are none, but no number to the parser of URDF files.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

RANGE = math.pi
"""Half a turn either way [rad]: a limb does not wind up."""
ENDLESS = 1e300
"""Effort and speed that stand for no limit [N m, N, rad/s, m/s]: beyond 1e100 they are none to a `Robot`."""


def whole_turns(path: Path, feet: Sequence[str] = ()) -> tuple[str, tuple[str, ...]]:
    """Return the text of a URDF in which limbs have ranges, and the joints that got one; nothing without any.

    A continuous joint with moving joints or a foot behind it is part of a limb, and so is one that mimics
    another; a wheel is neither. A text without such
    joints is of a file whose infinite limits are no numbers to a parser. What is no XML is left to the parser
    of URDF files to complain about.
    """
    try:
        tree = ElementTree.parse(path)
    except ElementTree.ParseError:
        return "", ()
    joints = [one for one in tree.getroot().findall("joint") if one.get("type", "fixed") != "fixed"]
    behind = _links_with_joints(tree.getroot(), feet)
    changed, endless_limits = [], spell_infinities(tree.getroot())
    for one in joints:
        limit, child = one.find("limit"), one.find("child")
        limb = child is not None and child.get("link") in behind
        endless = one.get("type") == "continuous" and (limb or one.find("mimic") is not None)
        shut = (
            one.get("type") == "revolute" and limit is not None and not {"lower", "upper"} & set(limit.attrib)
        )
        if not (endless or shut):
            continue
        if limit is None:
            limit = ElementTree.SubElement(one, "limit", {"effort": repr(ENDLESS), "velocity": repr(ENDLESS)})
        one.set("type", "revolute")
        limit.set("lower", repr(-RANGE))
        limit.set("upper", repr(RANGE))
        changed.append(one.get("name", ""))
    text = ElementTree.tostring(tree.getroot(), encoding="unicode") if changed or endless_limits else ""
    return text, tuple(changed)


def spell_infinities(root: ElementTree.Element) -> bool:
    """Write infinite efforts and speeds as `ENDLESS`, and leave infinite ranges out; tell whether any was."""
    found = False
    for limit in root.iter("limit"):
        for key, text in list(limit.attrib.items()):
            if text.strip().lower().lstrip("+-") not in ("inf", "infinity"):
                continue
            found = True
            if key in ("effort", "velocity"):
                limit.set(key, repr(ENDLESS))
            else:
                del limit.attrib[key]
    return found


def _links_with_joints(root: ElementTree.Element, feet: Sequence[str]) -> set[str]:
    """Return the links that have a moving joint or a foot somewhere behind them, feet among them."""
    above: dict[str, str] = {}
    starts = list(feet)
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is None or child is None:
            continue
        above[child.get("link", "")] = parent.get("link", "")
        if joint.get("type", "fixed") != "fixed":
            starts.append(parent.get("link", ""))
    out: set[str] = set()
    for link in starts:
        while link and link not in out:
            out.add(link)
            link = above.get(link, "")
    return out
