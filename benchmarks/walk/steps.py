"""What the controllers of a walking robot cost per call, on the states of a real walk.

The robot walks in MuJoCo under its own controller; the states are kept and then given to it again. Its
parts are timed where it calls them: with what they remember, and with caches as the other parts leave them.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.timing import Timing, best_of, one_core
from surefoot.mechanics.robot import load_robot
from surefoot.motion.control.controller import RobotState
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.motion.walking.walking_controller import WalkingController
from surefoot.worlds.mujoco.mujoco_world import MujocoWorld
from surefoot.worlds.running.run import Scenario, run

PASSES = 3


@dataclass(frozen=True)
class StepRow:
    """Wall time per call of one controller on one robot [s]."""

    robot: str
    call: str
    timing: Timing


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
    states = _states_of_a_walk(controller, seconds)
    whole, body, plans = [], [], []
    with one_core():
        for timed in (False, True) * PASSES:  # the timers are no part of a whole step
            fresh = WalkingController(model, VelocityCommand.constant(0.5), gait)
            if timed:
                update, solve = _timed(fresh.whole_body, "update"), _timed(fresh.whole_body, "solve")
                plan = _timed(fresh.mpc, "solve")
            taken = best_of(fresh.step, states, warm_up=0)[0]  # in order: each goes on from the one before
            if timed:
                body.append(np.add(update, solve))
                plans.append(plan)
            else:
                whole.append(taken)
    return [
        StepRow(robot, "whole step", Timing.of(np.min(whole, axis=0))),
        StepRow(robot, "whole-body step", Timing.of(np.min(body, axis=0))),
        StepRow(robot, f"MPC, {fresh.mpc.horizon} steps", Timing.of(np.min(plans, axis=0))),
    ]


def _states_of_a_walk(controller: WalkingController, seconds: float) -> list[RobotState]:
    """Return what a controller senses in a walk of so many seconds."""
    states: list[RobotState] = []
    step = controller.step

    def keep(state: RobotState) -> Any:
        contact = None if state.contact is None else state.contact.copy()
        states.append(state._replace(q=state.q.copy(), v=state.v.copy(), contact=contact))
        return step(state)

    controller.step = keep  # type: ignore[method-assign]
    controller.warm_up = lambda _: None  # type: ignore[method-assign, assignment]  # imagined steps are no walk
    robot = controller.robot
    run(MujocoWorld(robot, mu=0.6), controller, Scenario(seconds, 0.6, start=robot.nominal))
    return states


def _timed(owner: Any, name: str) -> list[float]:
    """Let a method's calls be timed; return where their times [s] go."""
    method, spent = getattr(owner, name), list[float]()

    def timed(*arguments: Any, **named: Any) -> Any:
        start = time.perf_counter()
        answer = method(*arguments, **named)
        spent.append(time.perf_counter() - start)
        return answer

    setattr(owner, name, timed)
    return spent
