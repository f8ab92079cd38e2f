"""How much hangs on a walking controller: Surefoot's objects that can be reached from one after a step.

Values are not counted: what lasts of a walk is one of them, `WalkState`; test_walk_state.py says that this is
all that lasts.
"""

from __future__ import annotations

import types
from typing import Any

import numpy as np
import pytest

from surefoot.base.settings import Settings
from surefoot.mechanics.robot import load_robot
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import RobotState
from surefoot.motion.ground.terrain_knowledge import controller_ground
from surefoot.motion.walking.walk_state import KINDS
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController

VALUES = {*KINDS, "Request", "WalkView"}
"""Names of classes of what a step makes anew and no other object writes to; settings are such values, too."""
LEAVES = (
    str, bytes, int, float, np.ndarray, type, types.ModuleType, types.FunctionType, types.BuiltinFunctionType,
)  # fmt: skip


def own(one: Any) -> dict[str, Any]:
    """Return the attributes of an object, those in slots and fields of named tuples too."""
    out = dict(getattr(one, "__dict__", {}))
    for base in type(one).__mro__:
        for slot in getattr(base, "__slots__", ()) or ():
            if hasattr(one, slot):
                out[slot] = getattr(one, slot)
    return out | (one._asdict() if hasattr(one, "_asdict") else {})


def reached(root: Any) -> dict[str, set[str]]:
    """Return the attributes' names of every class of Surefoot's that an object leads to."""
    seen, found, stack = set[int](), dict[str, set[str]](), [root]
    while stack:
        one = stack.pop()
        if id(one) in seen or isinstance(one, LEAVES):
            continue
        seen.add(id(one))
        surefoots = (type(one).__module__ or "").startswith("surefoot")
        if isinstance(one, types.MethodType):
            stack.append(one.__self__)
        elif isinstance(one, dict):
            stack.extend(one.values())
        elif isinstance(one, (list, tuple, set, frozenset)) and not surefoots:
            stack.extend(one)
        elif surefoots:
            if type(one).__qualname__ not in VALUES and not isinstance(one, Settings):
                found.setdefault(type(one).__qualname__, set()).update(own(one))
            stack.extend(own(one).values())
    return found


def test_how_much_is_reached_from_a_walking_controller(capsys: pytest.CaptureFixture[str]) -> None:
    robot = load_robot("go2")
    for knowledge, classes, attributes in (("exact", 18, 151), ("blind", 25, 189), ("map", 27, 209)):
        terrain = controller_ground(knowledge, FlatTerrain())
        walker = WalkingController(robot, VelocityCommand.constant(0.5), terrain=terrain)
        walker.step(RobotState(robot.nominal, np.zeros(robot.model.nv)))
        found = reached(walker)
        names = set().union(*found.values())
        with capsys.disabled():
            print(f"\nreached from a walk, {knowledge} ground: {len(found)} classes, {len(names)} names")
        assert len(found) <= classes
        assert len(names) <= attributes
