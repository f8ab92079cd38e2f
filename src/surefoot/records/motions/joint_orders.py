"""Orders in which files give the joints of a robot, and which joints files leave out."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np

from surefoot.base.errors import ProblemError, shown, unknown_name

if TYPE_CHECKING:
    from surefoot.base.arrays import FloatArray
    from surefoot.mechanics import Robot

LEFT_OUT: tuple[str, ...] = (
    "wrist",
    r"waist_(roll|pitch)|wrist_(pitch|yaw)",
    r"wrist_(pitch|yaw)",
    r"waist_(roll|pitch)",
    "gripper|hand|finger|thumb",
    "gripper|hand|finger|thumb|wrist",
    "head|neck",
    "gripper|hand|finger|thumb|head|neck",
    "wrist|head|neck",
    "wrist|arm|shoulder|elbow|hand|head|neck|gripper|finger|thumb",
    "wrist|arm|shoulder|elbow|hand|head|neck|gripper|finger|thumb|waist|torso",
)
"""Patterns of the joints that motions of a robot leave out, likely ones first: PHC's and ASAP's 23 of the
G1's 29 are without wrists, Unitree's own 23 without waist roll and pitch and two of each wrist's three, legs
alone.
"""
MOST_LIMBS = 6
"""Limbs that are put into every order: 720 orders of six."""
USUAL = {"depth": "depth first", "mujoco": "depth first", "urdf": "depth first", "pinocchio": "depth first",
         "breadth": "breadth first", "isaaclab": "breadth first"}  # fmt: skip
"""Names by which an order may be given: of MuJoCo, the URDF and Pinocchio, and of Isaac Lab."""
_SIDES = (
    ("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"),
    (r"(?<![A-Za-z])l(?![A-Za-z])", "r"), (r"(?<![A-Za-z])L(?=[FHRB]?(?![A-Za-z]))", "R"),
    (r"(?<=[FRHB])L(?![A-Za-z])", "R"),
)  # fmt: skip


@dataclass(frozen=True)
class JointOrder:
    """Joints in the order of a file's columns.

    Attributes
    ----------
    name
        What the order is called.
    joints
        Name of every column's joint.
    surprise
        What the order must win by to be believed: none for usual ones.
    by_limbs
        Whether it is an order of whole limbs that is no usual one: tried where angles leave the ranges in
        all others.
    """

    name: str
    joints: tuple[str, ...]
    surprise: float = 0.0
    by_limbs: bool = False


def bare_name(name: str) -> str:
    """Return a joint's name without what tools put around it: `robot/left_knee_joint` is `left_knee`."""
    bare = name.strip().strip("'\"").lower().replace(" ", "_").split("/")[-1].split(".")[-1]
    while True:
        less = re.sub(r"(_joint|_link|_dof|_pos|_position|_q|_rad|_deg)$", "", bare)
        if less == bare or not less:
            return bare
        bare = less


def match_names(robot: Robot, names: Sequence[str]) -> tuple[str | None, ...]:
    """Return the robot's joint that each name of a file means, None for a name of none.

    Raises
    ------
    ProblemError
        For a name that stands twice.
    """
    known = {bare_name(name): name for name in robot.joint_names}
    found = tuple(known.get(bare_name(str(name))) for name in names)
    for k, joint in enumerate(found):
        if joint is not None and joint in found[:k]:
            raise ProblemError(f"the joint {joint} stands twice among the file's columns")
    return found


def order_of_names(robot: Robot, names: Sequence[str]) -> tuple[JointOrder, tuple[int, ...]]:
    """Return the order that names say, and the columns that are joints of the robot.

    Raises
    ------
    ProblemError
        Where neither the file has all of the robot's joints nor the robot all of the file's.
    """
    found = match_names(robot, names)
    kept = tuple(k for k, joint in enumerate(found) if joint is not None)
    joints = tuple(joint for joint in found if joint is not None)
    missing = [name for name in robot.joint_names if name not in joints]
    if not joints or (len(joints) < len(found) and missing):
        strange = next(str(name) for name, joint in zip(names, found, strict=True) if joint is None)
        raise ProblemError(f"its joints are not those of {robot.name}: "
                           f"{unknown_name('joint', strange, missing or robot.joint_names)}")  # fmt: skip
    return JointOrder("by the file's names", joints), kept


def children(robot: Robot) -> dict[int, list[int]]:
    """Return the joints below every joint of the model, in its order."""
    model = robot.model
    first = 2 if robot.floating else 1
    below: dict[int, list[int]] = {}
    for joint in range(first, model.njoints):
        below.setdefault(int(model.parents[joint]), []).append(joint)
    return below


def breadth_first(robot: Robot, swap: bool = False) -> tuple[str, ...]:
    """Return the joints level by level from the root, as Isaac Lab has them; with `swap` sides exchanged."""
    below, root = children(robot), 1 if robot.floating else 0
    level, out = [root], list[str]()
    while level:
        level = [child for joint in level for child in below.get(joint, [])]
        out += [str(robot.model.names[joint]) for joint in level]
    return tuple(map(mirror_names(robot).__getitem__, out)) if swap else tuple(out)


def mirror_names(robot: Robot) -> dict[str, str]:
    """Return each joint's partner on the other side by their names, itself where it has none."""
    names = robot.joint_names
    out = {name: name for name in names}
    for name in names:
        for left, right in _SIDES:
            partner = re.sub(left, right, name, count=1)
            if partner != name and partner in out:
                out[name], out[partner] = partner, name
                break
    return out


def limbs(robot: Robot) -> list[tuple[str, ...]]:
    """Return the chains of joints without branches, in the model's order."""
    below, found = children(robot), list[tuple[str, ...]]()
    heads = list(below.get(1 if robot.floating else 0, []))
    while heads:
        joint = heads.pop(0)
        chain = [joint]
        while len(below.get(chain[-1], [])) == 1:
            chain += below[chain[-1]]
        found.append(tuple(str(robot.model.names[one]) for one in chain))
        heads = below.get(chain[-1], []) + heads
    return found


def file_order(robot: Robot) -> tuple[str, ...] | None:
    """Return the joints in the order of the robot's file, None where it does not name all of them."""
    if robot.source is None:
        return None
    text = robot.source.read_text(encoding="utf-8", errors="replace")
    found = re.findall(r"<joint\b[^>]*?\bname\s*=\s*[\"']([^\"']+)[\"']", text)
    names = tuple(dict.fromkeys(name for name in found if name in robot.joint_names))
    return names if len(names) == robot.joints else None


def subsets(robot: Robot, count: int) -> list[tuple[str, ...]]:
    """Return the sets of joints of which a file may have `count`: all, or without those that files leave out.

    Raises
    ------
    ProblemError
        Where no set is so large; the message names the sizes that there are.
    """
    names, sizes = robot.joint_names, {robot.joints: ""}
    found = [names] if count == len(names) else []
    for pattern in LEFT_OUT:
        kept = tuple(name for name in names if not re.search(pattern, name))
        if len(kept) == len(names) or not kept:
            continue
        sizes.setdefault(len(kept), pattern)
        if len(kept) == count and kept not in found:
            found.append(kept)
    if not found:
        valid = ", ".join(map(str, sorted(sizes, reverse=True)))
        raise ProblemError(
            f"it has {count} joint angles a frame, {robot.name} has {robot.joints} joints; without their "
            f"names there may be {valid}"
        )
    return found


def candidate_orders(robot: Robot, kept: Iterable[str], costs: FloatArray, rarer: float) -> list[JointOrder]:
    """Return the orders that columns of some joints may have, usual ones first.

    Parameters
    ----------
    robot, kept
        The robot, and the joints that the file has.
    costs
        (columns, joints) how badly a column's angles fit the range of each joint of the robot; used to choose
        among the orders of limbs.
    rarer
        What the set of joints must win by beside its order, zero for the likeliest set.
    """
    inside, partner = set(kept), mirror_names(robot)
    absent = [name for name in robot.joint_names if name not in inside]
    less = f" without {absent[0]} and {len(absent) - 1} others" if absent else ""
    orders: dict[tuple[str, ...], JointOrder] = {}

    def add(name: str, joints: Iterable[str] | None, surprise: float, by_limbs: bool = False) -> None:
        chosen = tuple(joint for joint in joints or () if joint in inside)
        if len(chosen) == len(inside):
            orders.setdefault(chosen, JointOrder(name + less, chosen, surprise + rarer, by_limbs))

    add("depth first", robot.joint_names, 0.0)
    add("breadth first", breadth_first(robot), 0.05)
    add("that of the robot's file", file_order(robot), 0.05)
    add("depth first, sides exchanged", map(partner.__getitem__, robot.joint_names), 0.1)
    add("breadth first, sides exchanged", breadth_first(robot, swap=True), 0.1)
    for joints in _limb_orders(robot, inside, costs):
        add("limb by limb in another order", joints, 0.15, by_limbs=True)
    return list(orders.values())


def _limb_orders(robot: Robot, inside: set[str], costs: FloatArray) -> list[tuple[str, ...]]:
    """Return the three orders of whole limbs in which the columns fit the ranges best."""
    place = {name: k for k, name in enumerate(robot.joint_names)}
    chains = [tuple(n for n in chain if n in inside) for chain in limbs(robot)]
    chains = [chain for chain in chains if chain]
    if not 1 < len(chains) <= MOST_LIMBS:
        return []
    ranked = list[tuple[float, tuple[str, ...]]]()
    for order in permutations(chains):
        joints = tuple(name for chain in order for name in chain)
        at = np.array([place[name] for name in joints])
        ranked.append((float(costs[np.arange(len(at)), at].sum()), joints))
    return [joints for _, joints in sorted(ranked, key=lambda one: one[0])[:3]]


def order_from_option(robot: Robot, order: object) -> JointOrder | None:
    """Return the order that a user gives: a word, or the joints of the columns; None for none.

    Raises
    ------
    ProblemError
        For what is neither; the message has the valid names.
    """
    if order is None:
        return None
    if isinstance(order, str):
        if order not in USUAL:
            raise ProblemError(f"{unknown_name('order', order, USUAL)}; or the names of the columns' joints")
        name = USUAL[order]
        return JointOrder(name, robot.joint_names if name == "depth first" else breadth_first(robot))
    if not isinstance(order, Sequence | np.ndarray) or not all(isinstance(one, str) for one in order):
        raise ProblemError(f"order must be one of {', '.join(USUAL)} or names of joints, got {shown(order)}")
    found = match_names(robot, [str(one) for one in order])
    if None in found:
        raise ProblemError(
            unknown_name(f"joint of {robot.name} in order", order[found.index(None)], robot.joint_names)
        )
    return JointOrder("as given", tuple(joint for joint in found if joint is not None))
