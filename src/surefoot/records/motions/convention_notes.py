"""Notes of the conventions of a motion: what was guessed, and which other reading speaks against it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from surefoot.records.motions.field_names import QUATERNIONS
from surefoot.records.motions.joint_orders import JointOrder
from surefoot.records.motions.readings import CLOSE, EXCESS, Reading, Readings


def quaternion_notes(readings: Readings, best: Reading, given: str | None) -> list[str]:
    """Return how the quaternion was read, and whether another way is as plausible or more.

    Parameters
    ----------
    readings, best
        Readings of the motion, and the one that was chosen.
    given
        What a user gave, None for nothing.
    """
    if not readings.robot.floating:
        return []
    usual = readings.fields.turn
    fixed = given is not None or readings.fields.certain
    rival = readings.read(QUATERNIONS[1 - QUATERNIONS.index(best.quaternion)], best.order)
    turned = [readings.read(f"{turn} inverse", best.order) for turn in QUATERNIONS]
    inverse = min(turned, key=lambda one: one.cost)
    if inverse.cost < min(rival.cost, best.cost) - CLOSE:
        rival = inverse
    compared = f"as {best.quaternion}, {best.plausibility}; as {rival.quaternion}, {rival.plausibility}"
    named = f"{best.quaternion}; {rival.quaternion}"
    if rival.cost < best.cost - CLOSE:
        who = "given as" if given else "named as" if fixed else "read as"
        return [f"doubt: quaternion: {who} {named} is more plausible: {compared}"]
    if fixed:
        return []
    if rival.cost < best.cost + CLOSE:
        return [f"doubt: quaternion: taken as {named} is as plausible: {compared}"]
    if usual and best.quaternion != usual:
        return [
            f"doubt: quaternion: such files have {usual}, this one is read as {best.quaternion}: {compared}"
        ]
    return [f"quaternion: {'read' if usual else 'guessed'} as {best.quaternion}: {compared}"]


def order_notes(
    readings: Readings, best: Reading, tried: Sequence[Reading], given: Sequence[JointOrder] | None
) -> list[str]:
    """Return in which order the joints were read, and whether another one is as plausible or more.

    Parameters
    ----------
    readings, best, tried
        Readings of the motion, the one that was chosen, and all that it was chosen from.
    given
        Other orders than that of `best`, where a file or a user gave that; else None.
    """
    name = best.order.name
    rivals = [one for one in tried if one.quaternion == best.quaternion and one.order is not best.order]
    if given is not None:
        rivals = [readings.read(best.quaternion, one) for one in given]
    rival = min(rivals, key=lambda one: one.cost, default=None)
    compared = str(best.plausibility)
    if rival is not None:
        compared += f"; {rival.order.name}: {rival.plausibility}"
        handicap = 0.0 if given is None else 0.5 * CLOSE - rival.order.surprise
        if rival.cost < best.cost - handicap:
            return [f"doubt: joint order: {name}, but another one is more plausible: {compared}"]
    if best.plausibility.excess > EXCESS:
        return [_excess_doubt(readings, best)]
    if given is not None:
        return []
    if best.order.surprise > 0.0:
        return [f"doubt: joint order: read as {name}: {compared}"]
    if rival is not None and rival.cost < best.cost + 0.5 * CLOSE:
        return [f"doubt: joint order: taken as {name}, another one is as plausible: {compared}"]
    return [f"joint order: guessed as {name} by ranges and feet: {compared}"]


def _excess_doubt(readings: Readings, best: Reading) -> str:
    """Return the doubt of an order in which angles leave the joints' ranges."""
    beyond = readings.ranges.excess(best.q[:, -readings.robot.joints :]).mean(axis=0)
    joint = readings.robot.joint_names[int(np.argmax(beyond))]
    return (
        f"doubt: joint order: {best.order.name}, in which angles leave the ranges by "
        f"{best.plausibility.excess:.2f} rad in all, most at {joint}"
    )
