"""What the controllers of a walking robot cost per call, on the inputs of a real walk.

The robot walks in MuJoCo under its own controller; every input of the whole-body controller and of the MPC is
kept and then given to them again, so that nothing but the call is timed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.timing import Timing, best_of, one_core
from surefoot.control.controller import RobotState
from surefoot.control.walking import WalkingController
from surefoot.control.walking_body import VelocityCommand
from surefoot.control.whole_body import Tasks
from surefoot.robot import load_robot
from surefoot.simulation.mujoco import MujocoWorld
from surefoot.simulation.run import Scenario, run

PASSES = 3


@dataclass(frozen=True)
class StepRow:
    """Wall time per call of one controller on one robot [s]."""

    robot: str
    call: str
    timing: Timing


@dataclass
class _Tape:
    """Inputs of a walk: states; (q, v, tasks) of whole-body control; time since and arguments of plans."""

    states: list[RobotState]
    whole_body: list[tuple[Any, ...]]
    plans: list[tuple[float, tuple[Any, ...], dict[str, Any]]]


def measure_steps(robot: str = "go2", seconds: float = 2.0, gait: str = "trot") -> list[StepRow]:
    """Return the times of a controller's whole step and of its parts, walking at 0.5 m/s.

    The parts are the whole-body step (with Pinocchio's terms) and a plan, which is made about every twentieth
    step; the whole step is all that the controller does between a state and its torques.

    Raises
    ------
    MissingExtra
        Without Pinocchio or MuJoCo.
    ModelError
        For an unknown robot, or one that cannot walk.
    """
    model = load_robot(robot)
    controller = WalkingController(model, VelocityCommand.constant(0.5), gait)
    tape = _Tape([], [], [])
    _record_calls(controller, tape)
    controller.warm_up = lambda _: None  # type: ignore[method-assign, assignment]  # imagined steps are no walk
    run(MujocoWorld(model, mu=0.6), controller, Scenario(seconds, 0.6, start=model.nominal))
    fresh = WalkingController(model, VelocityCommand.constant(0.5), gait)

    def plan(item: tuple[float, tuple[Any, ...], dict[str, Any]]) -> None:
        fresh.mpc.shift(item[0])
        fresh.mpc.solve(*item[1], **item[2])

    with one_core():
        whole = []
        for _ in range(PASSES):  # in order, since a step goes on from the one before
            fresh.reset()
            whole.append(best_of(fresh.step, tape.states, warm_up=0)[0])
        steps, _ = best_of(lambda item: fresh.whole_body.step(*item), tape.whole_body, PASSES)
        plans, _ = best_of(plan, tape.plans, PASSES)
    return [
        StepRow(robot, "whole step", Timing.of(np.min(whole, axis=0))),
        StepRow(robot, "whole-body step", Timing.of(steps)),
        StepRow(robot, f"MPC, {fresh.mpc.horizon} steps", Timing.of(plans)),
    ]


def _kept(value: Any) -> Any:
    """Return a copy of an array, anything else as it is."""
    return np.array(value) if isinstance(value, np.ndarray) else value


def _record_calls(controller: WalkingController, tape: _Tape) -> None:
    """Let a controller's own parts write what they are given onto the tape."""
    body, mpc = controller.whole_body, controller.mpc
    state: list[Any] = [None, None, 0.0]

    def keep_step(told: RobotState) -> None:
        contact = None if told.contact is None else told.contact.copy()
        tape.states.append(told._replace(q=told.q.copy(), v=told.v.copy(), contact=contact))

    def keep_state(q: Any, v: Any) -> None:
        state[:2] = q.copy(), v.copy()

    def keep_tasks(tasks: Tasks) -> None:
        copies: Any = (np.array(value) for value in tasks)
        tape.whole_body.append((state[0], state[1], Tasks(*copies)))

    def keep_shift(elapsed: float) -> None:
        state[2] = elapsed

    def keep_plan(*arguments: Any, **named: Any) -> None:
        copies = tuple(_kept(a) for a in arguments)
        tape.plans.append((state[2], copies, {name: _kept(a) for name, a in named.items()}))

    _tap(controller, "step", keep_step)
    _tap(body, "update", keep_state)
    _tap(body, "solve", keep_tasks)
    _tap(mpc, "shift", keep_shift)
    _tap(mpc, "solve", keep_plan)


def _tap(owner: Any, name: str, keep: Callable[..., None]) -> None:
    """Let a method tell `keep` what it is given."""
    method = getattr(owner, name)

    def tapped(*arguments: Any, **named: Any) -> Any:
        keep(*arguments, **named)
        return method(*arguments, **named)

    setattr(owner, name, tapped)
