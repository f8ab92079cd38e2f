"""Object arrays, texts, complex numbers, ragged lists in each argument: taken, or one error of ours.

The calls are in `odd_arguments`; every public function and class has one, or a line here that says why not.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import surefoot as sf
from tests.odd_arguments import CALLS

ELSEWHERE = {
    **dict.fromkeys(
        ("read_log", "read_problem", "read_stance", "read_sequence", "read_sweep", "read_tosses",
         "load_robot", "write_problem", "write_sequence", "export_sequence", "sequence_from_log", "run_sweep",
         "read_motions", "named_gait", "robot_names", "solver_names", "register"),
        "takes names, files and folders, no arrays",
    ),
    **dict.fromkeys(
        ("audit_log", "assert_lawful", "summarise_walk", "seeded_faults", "identify", "replay_log", "picture",
         "plan", "trajectory_gradient", "run", "record", "contacts_from_mujoco", "MujocoStepper",
         "exact_contact", "Motion", "repair_motion", "transfer"),
        "takes logs, robots, worlds and models: see test_wrong_api",
    ),
    **dict.fromkeys(
        ("Answer", "Command", "Controller", "Status", "Robot", "Plan", "Log", "ForceModel", "StanceCone",
         "Tasks", "RobotReadings", "RobotState", "ProblemError", "SurefootError", "StandingPlan"),
        "made by us, or plain values that are looked at where they are used",
    ),
    **dict.fromkeys(
        ("Body", "Scene", "SceneWorld", "SensorModel", "SolverSettings", "WalkSettings", "Ice", "Policy",
         "Guard", "FlatTerrain", "StandingController", "WalkingController"),
        "takes numbers, names and values of ours: see test_wrong_api and test_raw_errors",
    ),
}  # fmt: skip


class Unreadable:
    """What raises when it is made an array."""

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise RuntimeError("no array")


def odd_values(usual: Any) -> dict[str, Any]:
    """Return what may be given for a value that works, of its shape where it is an array."""
    array = np.asarray(usual) if isinstance(usual, list | tuple | float | int | np.ndarray) else np.zeros(3)
    array = array if array.dtype != object else np.zeros(3)
    mixed = array.astype(object)
    mixed.flat[:1] = "x"
    return {
        "objects": np.full(array.shape, None, dtype=object), "mixed": mixed, "numbers": array.astype(object),
        "texts": np.full(array.shape, "x"), "complex": np.full(array.shape, 1j), "None": None,
        "ragged": [[1.0], [1.0, 2.0]], "0-d": np.array(1.0), "0-d object": np.array(None, dtype=object),
        "bool": True, "bools": np.ones(array.shape, dtype=bool), "text": "x", "bytes": b"x",
        "dates": np.full(array.shape, np.datetime64("2020-01-01")), "set": {1, 2}, "dict": {"a": 1},
        "generator": (x for x in (1, 2)), "huge": 10**400, "class": int, "sparse": sp.eye(2), "empty": [],
        "masked": np.ma.array(np.ones(array.shape), mask=np.ones(array.shape, dtype=bool)),
        "records": np.zeros(2, dtype=[("a", float)]), "unreadable": Unreadable(),
        "NaN": np.full(array.shape, np.nan), "one more axis": np.zeros((2, *array.shape)),
    }  # fmt: skip


DEAR = {"RobotLoop", "RobotLoop.step", "InvariantEkf", "rollout", "MujocoWorld", "RigidWorld"}
NAMES = [pytest.param(name, marks=pytest.mark.long) if name in DEAR else name for name in CALLS]


def refusal(name: str, /, **odd: Any) -> str:
    """Return what a call is refused with, empty where it is taken."""
    call, usual = CALLS[name]
    try:
        call(**{**usual, **odd})
    except sf.SurefootError as error:
        return str(error)
    except Exception as error:
        raise AssertionError(f"{odd} ends in {type(error).__name__}") from error
    return ""


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.filterwarnings("ignore")
def test_an_odd_value_is_taken_or_refused_in_a_line(name: str) -> None:
    assert refusal(name) == ""
    for argument, value in CALLS[name][1].items():
        for kind, odd in odd_values(value).items():
            if kind == "class" and (name, argument) == ("rollout", "torques"):
                continue  # anything callable is a policy, whose errors are its own
            said = refusal(name, **{argument: odd})
            assert "\n" not in said, (argument, kind)
            assert len(said) < 500, (argument, kind)


def test_every_public_name_has_a_call_or_a_reason() -> None:
    called = {name.partition(".")[0] for name in CALLS}
    public = {name for name in sf.__all__ if callable(getattr(sf, name))}
    assert public - called - set(ELSEWHERE) == set()
