"""Conventions that a file leaves open, by plausibility: orders of quaternion and joints, and units."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from surefoot.base.errors import ProblemError, check_name
from surefoot.records.motions.convention_notes import order_notes, quaternion_notes
from surefoot.records.motions.field_names import QUATERNIONS
from surefoot.records.motions.fields import MotionFields
from surefoot.records.motions.joint_orders import (
    JointOrder,
    candidate_orders,
    order_from_option,
    order_of_names,
    subsets,
)
from surefoot.records.motions.motion_units import put_units_right
from surefoot.records.motions.readings import CLOSE, EXCESS, RARER, Reading, Readings

if TYPE_CHECKING:
    from surefoot.mechanics import Robot


@dataclass
class Conventions:
    """The conventions that were found, and what is told of them.

    Attributes
    ----------
    reading
        The motion under them.
    columns
        Columns of the file's joints that are the robot's.
    notes
        What was guessed and what is doubtful, a line each; doubts begin with ``doubt:``.
    """

    reading: Reading
    columns: tuple[int, ...]
    notes: list[str] = field(default_factory=list)


class ConventionSearch:
    """A search for the conventions of one motion, by which of them is most plausible for the robot.

    Parameters
    ----------
    robot, fields
        The robot, and what the file says; units are put right in it, and told.
    order, quaternion
        What a user gives, None for nothing.
    """

    def __init__(self, robot: Robot, fields: MotionFields, order: object, quaternion: str | None) -> None:
        if quaternion is not None:
            check_name("quaternion order", quaternion, QUATERNIONS)
        self.robot, self.fields = robot, fields
        self.notes: list[str] = []
        self.given_quaternion = quaternion
        self.columns: tuple[int, ...] = tuple(range(fields.joints.shape[1]))
        self.fixed_order = self._fixed_order(order)
        self.notes += put_units_right(robot, fields)
        self.readings = Readings(robot, fields, self.columns)
        self.orders = self._orders()

    def _fixed_order(self, order: object) -> JointOrder | None:
        """Return the order that the user or the file gives, None where neither does."""
        given = order_from_option(self.robot, order)
        named = None
        if self.fields.names:
            named, self.columns = order_of_names(self.robot, self.fields.names)
            dropped = len(self.fields.names) - len(self.columns)
            if dropped:
                self.notes.append(
                    f"{dropped} joints of the file are none of {self.robot.name}'s and were left out"
                )
        if given is None or named is None:
            return given if named is None else named
        if given.name != "as given":
            given = JointOrder(given.name, tuple(name for name in given.joints if name in named.joints))
        if given.joints != named.joints:
            self.notes.append(
                "doubt: joint order: the option `order` is not what the file's names say; the option is used"
            )
        return given

    def _orders(self) -> list[JointOrder]:
        """Return the orders to try: all that are known for the number of columns, what is given first."""
        count, robot = len(self.columns), self.robot
        fixed = self.fixed_order
        if fixed is not None and len(fixed.joints) != count and fixed.name != "as given":
            sets = subsets(robot, count)
            fixed = self.fixed_order = JointOrder(fixed.name, tuple(n for n in fixed.joints if n in sets[0]))
        if fixed is not None and len(fixed.joints) != count:
            raise ProblemError(
                f"order names {len(fixed.joints)} joints, the file has {count} columns of them"
            )
        costs = self.readings.ranges.column_costs(self.fields.joints[:, list(self.columns)])
        sets = [fixed.joints] if fixed is not None else subsets(robot, count)
        found = [] if fixed is None else [fixed]
        for rank, kept in enumerate(sets):
            tried = candidate_orders(robot, kept, costs, RARER * rank)
            found += [one for one in tried if one.joints not in [other.joints for other in found]]
        return found

    def find(self) -> Conventions:
        """Return the most plausible conventions, with what was guessed and what is doubtful."""
        turns = self._allowed_turns()
        orders = self.orders if self.fixed_order is None else [self.fixed_order]
        tried = [self.readings.read(turn, order) for turn in turns for order in orders if not order.by_limbs]
        if min(one.plausibility.excess for one in tried) > EXCESS:
            tried += [self.readings.read(turn, order) for turn in turns for order in orders if order.by_limbs]
        usual = self.given_quaternion or self.fields.turn
        best = min(tried, key=lambda one: one.cost + (CLOSE if usual and one.quaternion != usual else 0.0))
        others = None
        if self.fixed_order is not None:
            others = [one for one in self.orders if one is not best.order and not one.by_limbs]
        notes = quaternion_notes(self.readings, best, self.given_quaternion)
        notes += order_notes(self.readings, best, tried, others)
        return Conventions(best, self.columns, [*self.notes, *notes])

    def _allowed_turns(self) -> list[str]:
        """Return the orders of quaternions that may be used."""
        if not self.robot.floating:
            return ["xyzw"]
        if self.given_quaternion is not None:
            return [self.given_quaternion]
        return [self.fields.turn] if self.fields.certain else list(QUATERNIONS)
