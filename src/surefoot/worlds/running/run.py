"""Run a controller in a world: one loop for whatever keeps to the protocols of both, logged step by step."""

from __future__ import annotations

import copy
import gc
import math
import time as clock
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, IntArray
from surefoot.base.errors import ProblemError, SurefootError, WriteError, shown
from surefoot.base.loaded import loaded_feet
from surefoot.base.memory import Remembering
from surefoot.base.spatial import GRAVITY
from surefoot.motion import Command, Controller, RobotState, Standstill, as_controller, state_of
from surefoot.records import CHANNELS, Channel, Ending, Log, Recorder
from surefoot.worlds.interface.world import World
from surefoot.worlds.interface.world_facts import facts_before
from surefoot.worlds.interface.world_state import world_state
from surefoot.worlds.running.faults import Faults
from surefoot.worlds.running.ground_friction import GroundFriction
from surefoot.worlds.running.observers import LinkContactObserver, Moment, Observer
from surefoot.worlds.running.run_state import RunState, StateKeeper, check_resumable, setting_of
from surefoot.worlds.running.scenario import Ice as Ice
from surefoot.worlds.running.scenario import IcePatch as IcePatch
from surefoot.worlds.running.scenario import Push as Push
from surefoot.worlds.running.scenario import Scenario as Scenario
from surefoot.worlds.running.scenario import push_at
from surefoot.worlds.running.sensing import (
    STOP_TIME,
    EstimatedState,
    ExteroceptiveSensing,
    Sensing,
    TrueState,
)

PLAIN = 5.0
"""Length of a run without a scenario [s]."""
LOOK_EVERY = 20
"""Steps between looks at whether the robot has fallen."""
AT_LIMIT = 1.0 - 1e-6
"""A torque is saturated from this share of its limit on."""
NO_PUSH = np.zeros(3)
_SHARED = (
    "time", "q", "v", "torques", "forces", "forces_commanded", "gaps", "contact_velocities",
    "contact_positions", "normals", "active", "attained", "saturated", "push", "mu", "controller_time",
)  # fmt: skip


def run(
    world: World,
    controller: Controller | Callable[[RobotState], Any],
    scenario: Scenario | None = None,
    observers: Sequence[Observer] = (),
    folder: Path | None = None,
    *,
    keep: StateKeeper | None = None,
    resume: RunState | None = None,
) -> Log:
    """Run the controller in the world and return the log, also when interrupted or fallen.

    Parameters
    ----------
    world, controller, scenario
        Where, who decides, and what happens. Any function of the state that returns (joints,) torques [N m],
        `JointTargets` or a `Command` can decide; commands that say nothing of forces leave NaN in the log.
        Without a scenario nothing disturbs the robot for `PLAIN` seconds.
    observers
        Who watches; each is called after every step, and with the log at the end.
    folder
        New folder that the log's rows go to as they come, where `read_log` finds what a killed run leaves;
        None to put only a long log on the disk, in a temporary one.
    keep
        What takes states of the run on the way; None to keep none.
    resume
        A state of a run to go on from, to the last bit: with a world and a controller that were made in the
        same way, and a scenario in which pushes, patches, dropouts and the end alone may be others. The log
        begins there. None for a run from its start.

    Returns
    -------
    Log
        Its facts ``outcome`` (see `log.Ending`), ``wall_time`` and ``error`` say how it ended.
        Whatever ends a run before its first row is complete is raised: there is nothing to keep.

    Raises
    ------
    ProblemError
        For what is no world, controller or scenario, naming what it lacks; faults that do not fit the robot,
        or channels of the controller that are no channels. For states to be kept of, or resumed in, a world
        or a controller that does not tell its own, and for one of another run.
    SimulationError, WriteError
        If not even the first step could be made and logged.
    """
    lacks = [name for name in ("robot", "terrain", "step", "contacts", "q_v") if not hasattr(world, name)]
    if lacks:
        kind = type(world).__name__
        raise ProblemError(f"world must be one as sf.MujocoWorld(robot) is, {kind} lacks {', '.join(lacks)}")
    controller = as_controller(controller, world.robot.joints)
    scenario = Scenario(PLAIN) if scenario is None else scenario
    if not isinstance(scenario, Scenario):
        raise ProblemError(f"scenario must be a Scenario, as sf.Scenario(5.0) is one, got {shown(scenario)}")
    q, v = scenario.begin(world)
    world.reset(q)
    check_resumable(world, controller, keep is not None or resume is not None)
    if keep is not None:
        keep.steps(world.dt)
    if resume is not None:
        resume.check(setting_of(world, controller, scenario), scenario.steps(world.dt))
    controller.warm_up(RobotState(*world.q_v(), 0.0, np.ones(len(world.robot.feet), dtype=bool)))
    world.step(np.zeros(world.robot.joints))  # so that no step of the run waits for a compiler
    world.reset(q, v)
    height = float(q[2] - world.terrain.height(q[:2]))
    out = _Run(world, controller, scenario, folder, height)
    if keep is not None:
        out.keep(keep)
    if resume is not None:
        out.resume(resume)
    gc.freeze()  # so that no step waits while the collector looks at what was there before
    try:
        log = out.carry_out(observers)
    finally:
        gc.unfreeze()
    declare = getattr(world, "softness", None)
    log.facts.update({} if declare is None else declare(log))
    log.facts.update({} if resume is None else {"resumed_at": resume.time})
    for observer in observers:
        observer.end(log)
    return log


def _recorder(
    world: World, controller: Controller, more: tuple[Channel, ...], scenario: Scenario, folder: Path | None
) -> Recorder:
    """Return a recorder for what every run has, what its controller adds, and `more`."""
    robot = world.robot
    taken = (*_SHARED, "other_forces", "torques_commanded", *(c.name for c in more))
    clash = [c.name for c in controller.channels if c.name in taken]
    if clash:
        raise ProblemError(
            f"the controller's channel {clash[0]!r} is one that every log has; take another name"
        )
    facts = {
        "mass_controller": robot.mass,
        **controller.facts,
        "effort_limits": robot.effort_limits,
        **facts_before(world),
        "duration": scenario.duration,
        "outcome": str(Ending.INTERRUPTED),  # until the run has ended in another way
        "wall_time": float("nan"),
    }
    if robot.notes:
        facts["notes"] = [*robot.notes, *facts.get("notes", ())]
    shared = _SHARED if world.contacts().others is None else (*_SHARED, "other_forces")
    if getattr(world, "actuators", None) is not None:
        shared = (*shared, "torques_commanded")
    channels = (*(CHANNELS[name] for name in shared), *controller.channels, *more)
    return Recorder(
        scenario.steps(world.dt), channels, folder, facts,
        nq=int(robot.model.nq), nv=int(robot.model.nv), joints=robot.joints, p=len(world.contact_foot),
        n=len(robot.feet),
    )  # fmt: skip


class _Run:
    """A world that has been reset, and all that takes part."""

    def __init__(
        self, world: World, controller: Controller, scenario: Scenario, folder: Path | None, height: float
    ) -> None:
        """Take what takes part; `height` is that of the base over the ground at the start [m]."""
        self.world, self.controller, self.scenario, self.height = world, controller, scenario, height
        self.faults = (scenario.faults or Faults()).start(world, scenario.seed)
        self.sensing: Sensing = TrueState(self.faults)
        if scenario.sensors is not None:
            self.sensing = EstimatedState(scenario.sensors, world, scenario.seed)
        self.ground = GroundFriction(world, scenario)
        more = (*self.sensing.channels, *self.ground.channels)
        self.recorder = _recorder(world, controller, more, scenario, folder)
        self.limits = AT_LIMIT * world.robot.effort_limits
        self.stop = Standstill(world.robot, world.dt)
        self.touches = LinkContactObserver(world)
        self.exteroception = ExteroceptiveSensing(world, scenario.scanner, scenario.seed)
        rows = self.recorder.arrays
        self._others = np.zeros(rows["other_forces"].shape[1:]) if "other_forces" in rows else None
        self._motors = "torques_commanded" in rows
        parts = ((None, controller), (self.sensing, self.sensing), (self.ground, self.ground))
        self._sources = [
            (part, [c.name for c in by.channels]) for part, by in parts if by.channels or not part
        ]

        self._first, self._stopped = 0, math.inf
        self._command: Command | None = None
        self._keeper: StateKeeper | None = None
        self._every = scenario.steps(world.dt) + 1  # steps between kept states: none

    @property
    def _parts(self) -> dict[str, Remembering]:
        """What remembers something between world and controller, by name."""
        sensing: Any = self.sensing
        return {
            "sensing": sensing, "exteroception": self.exteroception, "faults": self.faults,
            "friction": self.ground, "touches": self.touches, "standstill": self.stop,
        }  # fmt: skip

    def keep(self, keeper: StateKeeper) -> None:
        """Keep states from now on."""
        self._keeper, self._every = keeper, keeper.steps(self.world.dt)

    def resume(self, state: RunState) -> None:
        """Go on from a state, or leave nothing behind and raise for one that does not fit."""
        world, controller = cast(Any, self.world), cast(Any, self.controller)
        try:
            world.resume(state.world)
            controller.resume(state.controller)
            for name, part in self._parts.items():
                part.resume(state.parts[name])
        except SurefootError:
            self.recorder.abandon()
            raise
        except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
            self.recorder.abandon()
            raise ProblemError(f"the state does not fit this run: {type(error).__name__} {error}") from error
        self.height, self._first, self._stopped = state.height, state.step, state.stopped
        self._command = copy.deepcopy(state.command)

    def _state(self, step: int, command: Command | None, stopped: float) -> RunState:
        """Return the state before a step."""
        parts = {name: part.remembered() for name, part in self._parts.items()}
        return RunState(
            step, step * self.world.dt, self.height, stopped,
            setting_of(self.world, self.controller, self.scenario), world_state(self.world),
            state_of(self.controller), parts, copy.deepcopy(command),
        )  # fmt: skip

    def carry_out(self, observers: Sequence[Observer]) -> Log:
        """Step to the end, a fall, Ctrl-C or a loss and return the log."""
        begin, worked, recorder = clock.perf_counter(), clock.thread_time(), self.recorder
        more: dict[str, Any] = {}
        try:
            ending = self._loop(observers)
        except (KeyboardInterrupt, SurefootError) as stop:
            if recorder.count == 0:
                recorder.abandon()
                raise
            if isinstance(stop, KeyboardInterrupt):
                ending = Ending.INTERRUPTED
            else:
                ending = Ending.STOPPED if isinstance(stop, WriteError) else Ending.INVALID
                more = {"error": str(stop)}
        except BaseException:
            recorder.abandon()
            raise
        if self.sensing.failure:
            more = {"error": self.sensing.failure, **more}
        touched = self.touches.lines(self.world.dt)
        more |= {"link_touches": touched} if touched else {}
        times = {"wall_time": clock.perf_counter() - begin, "cpu_time": clock.thread_time() - worked}
        return recorder.finish({"outcome": str(ending), **times, **more})

    def _loop(self, observers: Sequence[Observer]) -> Ending:
        """Step the world to the end, a fall, or a stop because the state is not known."""
        world, scenario, faults, sensing = self.world, self.scenario, self.faults, self.sensing
        foot, feet = world.contact_foot, len(world.robot.feet)
        weight = world.robot.mass * GRAVITY
        reading, command, stopped = world.contacts(), self._command, self._stopped
        for k in range(self._first, scenario.steps(world.dt)):
            if self._keeper is not None and k % self._every == 0:
                self._keeper.take(self._state(k, command, stopped))
            # what the world is like, and what the controller makes of it
            now = k * world.dt
            self.ground.advance(now, reading)
            push = push_at(scenario.pushes, now) if scenario.pushes else None
            q, v = world.q_v()
            state = sensing.state(q, v, now, touching_feet(foot, reading.forces, feet, weight))
            state = self.exteroception.add(state, q, reading)
            start = clock.perf_counter()
            state = RobotState(*state[:4], sensing.heard, *state[5:])
            command = self._decide(faults.heard(state), command)
            spent = clock.perf_counter() - start
            # the step
            self._asked = faults.act(command, q, v)
            world.step(self._asked, push)
            torques = np.asarray(getattr(world, "applied", self._asked))  # what motors gave
            sensing.note_step(command, torques)
            reading = world.contacts()
            # its row
            moment = Moment(now, q, v, torques, push, self.ground.mu, spent, command, reading)
            self._record(moment)
            for observer in (self.touches, *observers):
                observer.step(moment)
            # whether it goes on
            if sensing.failure:
                stopped = min(stopped, now)
                if now - stopped >= STOP_TIME:
                    return Ending.LOST
            if k % LOOK_EVERY == 0:
                fallen = scenario.fall.happened(q, self.height, world.terrain)
                if fallen is not None:
                    return fallen
        return Ending.LOST if sensing.failure else Ending.DONE

    def _decide(self, state: RobotState, last: Command | None) -> Command:
        """Return the controller's command, or that of a robot which has lost its state."""
        if self.sensing.failure and last is not None:
            return self.stop.command(state, last)
        return self.controller.step(state).for_points(len(self.world.contact_foot))

    def _record(self, moment: Moment) -> None:
        """Write the row of a step."""
        command, reading = moment.command, moment.reading
        row = [
            moment.time, moment.q, moment.v, moment.torques, reading.forces, command.forces, reading.gaps,
            reading.velocities, reading.positions, reading.normals_on(self.world.terrain), command.active,
            command.attained, (np.abs(command.torques) >= self.limits).any(),
            NO_PUSH if moment.push is None else moment.push, moment.mu, moment.controller_time,
        ]  # fmt: skip
        if self._others is not None:
            row.append(self._others if reading.others is None else reading.others)
        if self._motors:
            row.append(self._asked)
        for part, names in self._sources:
            given = command.rows() if part is None else part.rows()
            if [*given] == names:
                row += given.values()
            elif part is None and self.recorder.count == 0 and given.keys() != set(names):
                own, said = (", ".join(sorted(some)) or "none" for some in (given, names))
                raise ProblemError(f"a command has rows for {own}, its controller has the channels {said}")
            else:
                row += [given.get(name, 0.0) for name in names]
        self.recorder.write(row)


def touching_feet(contact_foot: IntArray, forces: FloatArray, feet: int, weight: float) -> BoolArray:
    """Return which feet (feet,) have a contact point that bears weight.

    Parameters
    ----------
    contact_foot, forces
        (p,) foot of each contact point, and (p, 3) forces in contact frames [N].
    feet, weight
        Number of feet, and m g [N].
    """
    out = np.zeros(feet, dtype=np.bool_)
    out[contact_foot[loaded_feet(forces[:, 2], weight)]] = True
    return out
