"""The state that a controller is given: taken as it is where it fits, read or refused where it does not."""

from typing import Any

import numpy as np
import pytest

from surefoot import ProblemError, Robot, load_robot
from surefoot.motion.state import RobotState


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("go2")


def state_of(robot: Robot, **changed: Any) -> RobotState:
    """Return a state of a robot that stands, all of whose fields but the scan are given."""
    joints, feet = robot.joints, len(robot.feet)
    state = RobotState(
        robot.nominal.copy(), np.zeros(robot.model.nv), 0.5, np.ones(feet, dtype=bool), np.zeros(joints),
        np.zeros((feet, 3)),
    )  # fmt: skip
    return state._replace(**changed)


@pytest.mark.parametrize(
    "changed", [{}, {"contact": None}, {"contact": None, "torques": None, "forces": None}]
)
def test_a_state_that_fits_is_taken_as_it_is(robot: Robot, changed: dict[str, Any]) -> None:
    state = state_of(robot, **changed)
    assert state.fitting(robot) is state


def test_arrays_whose_type_is_another_object_are_taken_too(robot: Robot) -> None:
    # what worlds hand out: equal to NumPy's own type of floats, and not the same object
    own = np.dtype({"names": ["torque"], "formats": [np.dtype("=f8", copy=True)]})["torque"]
    torques = np.zeros(robot.joints, dtype=own)
    assert torques.dtype is not np.dtype(np.float64)
    state = state_of(robot, torques=torques)
    assert state.fitting(robot) is state


def test_lists_and_whole_numbers_are_read(robot: Robot) -> None:
    state = state_of(robot, q=robot.nominal.tolist(), torques=np.ones(12, dtype=int)).fitting(robot)
    assert np.array_equal(state.q, robot.nominal)
    assert state.torques is not None
    assert state.torques.dtype == np.float64
    assert state.time == 0.5


def test_nan_is_let_through(robot: Robot) -> None:
    assert np.isnan(state_of(robot, v=np.full(18, np.nan)).fitting(robot).v).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"q": np.zeros(18)}, r"q must have shape \(19,\), got \(18,\)"),
        ({"v": np.zeros((18, 1))}, r"v must have shape \(18,\), got \(18, 1\)"),
        ({"v": "fast"}, "v must be numeric"),
        ({"contact": np.ones(4)}, "contact must be True and False"),
        ({"contact": np.ones(3, dtype=bool)}, r"contact must have shape \(4,\), got \(3,\)"),
        ({"torques": np.zeros(11)}, r"torques must have shape \(12,\), got \(11,\)"),
        ({"torques": np.zeros(12, dtype=complex)}, "torques must be numeric"),
        ({"forces": np.zeros(12)}, r"forces must have shape \(4, 3\), got \(12,\)"),
        ({"forces": "none"}, "forces must be numeric"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(robot: Robot, changed: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        state_of(robot, **changed).fitting(robot)
