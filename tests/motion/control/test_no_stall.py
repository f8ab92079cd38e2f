"""After `warm_up` no step of a controller compiles a kernel or loads one, whatever happens to the robot."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from surefoot.motion.control.controller import RobotState
from surefoot.motion.control.mpc import ConvexMpc
from surefoot.motion.walking.walkers import walking_controller
from surefoot.motion.walking.walking_body import VelocityCommand
from tests.robots import robot_of

PROGRAM = """
import sys, time
import numpy as np
import surefoot as sf
from surefoot.base.compilation.numba_internals import Kernel
from surefoot.motion.control.controller import Wrapper
from surefoot.motion.walking.leg_demand import table_of
from surefoot.motion.walking.walkers import walking_controller
from surefoot.worlds.running.motor_robot import MotorRobot

new, spent, watched = [], [], False
original = Kernel.compile

def compile(kernel, types):
    before = len(kernel.overloads)
    made = original(kernel, types)
    if watched and len(kernel.overloads) > before:
        new.append(kernel.py_func.__name__)
    return made

Kernel.compile = compile

class Watched(Wrapper):
    def step(self, state):
        global watched
        watched, begin = True, time.thread_time()
        try:
            return self.controller.step(state)
        finally:
            watched = False
            spent.append(1e3 * (time.thread_time() - begin))

robot = sf.load_robot(sys.argv[1])
command = sf.VelocityCommand.constant(0.4, 0.0, 0.2)
walker = walking_controller(robot, command, watch_friction=len(robot.feet) == 4)
pushes = [sf.Push(0.5, (0, 300, 0), 0.1), sf.Push(0.8, (0, 0, -700), 0.1), sf.Push(1.1, (-300, 200, 0), 0.2)]
log = sf.run(sf.MujocoWorld(robot), Watched(walker), sf.Scenario(1.8, 0.6, pushes))
assert log["saturated"].any(), "no torque met its limit"
print("step [ms of CPU]: median %.2f, 99 %% %.2f, 99.9 %% %.2f, most %.2f"
      % tuple(np.percentile(spent, [50, 99, 99.9, 100])))
assert not new, new
if sys.argv[1] == "go2":  # and of the loop of a real robot
    loop, body = sf.RobotLoop(robot), MotorRobot(robot)
    body.lie_down()
    for k in range(2400):
        if k in (5, 1900):
            loop.go("stand" if k == 5 else "walk")
        if k % 60 == 0:  # to where it never went
            loop.steer((0.4, 0.1 * np.sin(k), 0.2 * np.cos(k)))
        readings, watched = body.read(), True
        targets, watched = loop.step(readings), False
        body.take(targets)
        body.step()
    assert loop.mode == "walk" and not new and table_of.cache_info().misses == 1, new
"""


@pytest.mark.parametrize("robot", ["go2", "g1"])
@pytest.mark.long
def test_no_step_compiles(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    """In a new process; `pytest -s` prints what the steps took."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, robot], capture_output=True, text=True, check=False)
    with capsys.disabled():
        print(f"\n{robot}: {done.stdout.strip()}")
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.parametrize("robot", ["go2", "g1"])
@pytest.mark.long
def test_plans_can_wait_until_a_command_is_sent(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The MPC runs between steps then; whoever does not call for it has the same torques later."""
    planned, solve = [], ConvexMpc.solve
    monkeypatch.setattr(ConvexMpc, "solve", lambda *a, **k: planned.append(0) or solve(*a, **k))
    model = robot_of(robot)
    first, twin = (walking_controller(model, VelocityCommand.constant(0.2)) for _ in "ab")
    first.answers_first = twin.answers_first = True
    for k in range(1200):
        state = RobotState(model.nominal, np.zeros(model.model.nv), 1e-3 * k)
        before = len(planned)
        torques = first.step(state).torques
        assert len(planned) == before or k == 0
        first.plan_ahead()
        assert np.array_equal(twin.step(state).torques, torques)
    assert not first.feet.stance.all()
    assert len(planned) > 60
