"""Numbers, arrays, texts and lists where something else is expected: taken, or one clear error."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import surefoot as sf
from surefoot.base.errors import SurefootError
from tests.robots import robot_of

FORCES = np.tile([0.0, 0.0, 40.0], (100, 4, 1))
FEET = ("FL", "FR", "RL", "RR")
COMPLEX, RAGGED = np.array(1j), [[True], [True, False]]
WRONG: dict[str, Any] = {
    "complex": COMPLEX, "ragged": RAGGED, "text": "some", "list": [1.0, 2.0, 3.0, 4.0, 5.0], "None": None,
    "dict": {"a": 1}, "class": int, "objects": np.array([None, 1], dtype=object), "bytes": b"x",
}  # fmt: skip


def log_with(**given: Any) -> sf.Log:
    """Return a log of four feet that push."""
    return sf.log_from_arrays({"forces": FORCES}, **{"dt": 0.01, "feet": FEET, **given})


@pytest.mark.parametrize(
    "mass", [np.float64(16.0), np.float32(16.0), np.int64(16), np.array(16.0), 16], ids=lambda m: str(type(m))
)
def test_facts_may_be_numpy_s_numbers_and_arrays(mass: Any) -> None:
    facts = {"mass": mass, "gravity": np.array([0.0, 0.0, -9.81]), "robot": np.str_("go2")}
    log = log_with(facts=facts)
    assert log.fact("mass") == 16.0
    assert log.fact("gravity").tolist() == [0.0, 0.0, -9.81]
    assert log.fact("robot") == "go2"
    assert sf.audit_log(log).verdict == "cannot tell"


def test_facts_that_no_file_can_hold_are_named() -> None:
    for bad in (COMPLEX, object(), 1j, {1.0: object()}):
        with pytest.raises(SurefootError, match="the fact mass"):
            log_with(facts={"mass": bad})


def test_feet_may_be_an_array_of_names() -> None:
    assert log_with(feet=np.array(FEET)).fact("feet") == list(FEET)
    with pytest.raises(SurefootError, match="feet"):
        log_with(feet=np.arange(4))


def test_facts_of_changes_that_do_not_belong_together_are_refused() -> None:
    for facts in ({"change_kind": ["mass"]}, {"change_kind": "mass"}, {"change_kind": 3.0}):
        with pytest.raises(SurefootError, match="change"):
            sf.audit_log(log_with(facts={"mass": 16.0, **facts}))


def test_the_mode_of_a_log_s_rows_is_checked() -> None:
    for bad in ("some", 1.5, [[1], [1, 2]], {"a": 1}):
        with pytest.raises(SurefootError, match="rows"):
            log_with().rows(bad)


def constant(value: Any) -> Any:
    return sf.VelocityCommand.constant(value)


def controller(**given: Any) -> Callable[[Any], Any]:
    """Return what makes a whole-body controller of a value of one parameter."""
    (name,) = given
    return lambda value: sf.WholeBodyController(robot_of("go2"), **{name: value})


def walk(name: str) -> Callable[[Any], Any]:
    """Return what makes a walking controller of a value of one parameter."""

    def make(value: Any) -> Any:
        given: dict[str, Any] = {"command": sf.VelocityCommand.constant(0.0), name: value}
        return sf.WalkingController(robot_of("go2"), **given)

    return make


MAKERS: dict[str, tuple[Callable[[Any], Any], bool]] = {
    "VelocityCommand.constant": (constant, False),
    "WholeBodyController.mu": (controller(mu=None), False),
    "WholeBodyController.normal_max": (controller(normal_max=None), False),
    "WholeBodyController.baumgarte": (controller(baumgarte=None), False),
    "WholeBodyController.sole_damping": (controller(sole_damping=None), True),
    "WholeBodyController.effort_limits": (controller(effort_limits=None), True),
    "WholeBodyController.actuators": (controller(actuators=None), True),
    "WholeBodyController.weights": (controller(weights=None), True),
    "WalkingController.command": (walk("command"), False),
    "WalkingController.gait": (walk("gait"), False),
    "WalkingController.terrain": (walk("terrain"), True),
    "WalkingController.settings": (walk("settings"), True),
    "Stance": (sf.Stance, False),
    "ContactSet": (sf.contact_sets.ContactSet, False),
    "Bilateral": (sf.contact_sets.Bilateral, False),
}
"""What makes something of one value, and whether it takes None."""


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.parametrize("kind", WRONG)
def test_a_wrong_value_is_one_clear_error(name: str, kind: str) -> None:
    make, takes_none = MAKERS[name]
    if kind == "None" and takes_none:
        make(None)
        return
    with pytest.raises(SurefootError):
        make(WRONG[kind])


def test_a_velocity_of_lists_is_as_good_as_one_of_arrays() -> None:
    listed = sf.VelocityCommand([0.0, 1.0], [[0.1, 0.0, 0.0], [0.2, 0.0, 0.0]])
    assert listed.at(2.0).tolist() == [0.2, 0.0, 0.0]
    assert sf.WalkingController(robot_of("go2"), listed).command.values.shape == (2, 3)


def test_a_problem_and_a_solver_refuse_what_is_no_array_of_their_shape() -> None:
    G, g, mu = np.eye(6), np.array([0.0, 0.0, -1.0] * 2), [0.5, 0.5]
    for bad in WRONG.values():
        for name in ("bilateral", "compliance", "normal_max"):
            if bad is not None:
                with pytest.raises(SurefootError):
                    sf.ContactProblem(G, g, mu, **{name: bad})
        if bad is not None:
            with pytest.raises(SurefootError):
                sf.ContactSolver(2, mu).solve(G, g, out=bad)
