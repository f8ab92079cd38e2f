"""Many robots of one model at once: state arrays in, state arrays out, each as in a `RigidWorld` of its own.

A step of one robot is a dozen short calls that hold Python's lock, so threads would wait for each other:
`workers` are processes, which share the arrays and are told only to go on. The answers do not depend on their
number: robots are apart, and a step depends on its own state alone.
"""

from __future__ import annotations

import multiprocessing
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, IntArray, finite_array, real_array, whole_number
from surefoot.errors import ProblemError, SimulationError
from surefoot.robot import Robot
from surefoot.stepping import State, StepOptions, Stepper
from surefoot.terrain import Terrain

FIELDS = ("q", "v", "torques", "push", "mu", "forces", "gaps", "counts")
"""The arrays that workers share; counts are steps taken, problems unsolved, and whether the robot is lost."""


@dataclass(frozen=True)
class BatchStep:
    """What a step of a `RigidBatch` returns.

    Attributes
    ----------
    q, v
        (count, nq) and (count, nv).
    forces
        (count, p, 3) mean forces of the ground over the last step, in contact axes [N].
    gaps
        (count, p) of the contact points at the impulses [m].
    unsolved
        (count,) contact problems left above the tolerance, of all steps of the call.
    lost
        (count,) whose motion could not be resolved: they stay where they were until they are reset.
    """

    q: FloatArray
    v: FloatArray
    forces: FloatArray
    gaps: FloatArray
    unsolved: IntArray
    lost: BoolArray


class RigidBatch:
    """Robots of one model on one terrain, each with its own state, friction and payload.

    Parameters
    ----------
    robot, terrain
        As for `RigidWorld`.
    count
        Number of robots.
    mu
        Friction of the ground [-], a number or (count,).
    payload
        Point mass fixed to the base's origin [kg], a number or (count,).
    options
        None for the defaults of `StepOptions`.
    workers
        Processes that share the work; 1 for none but this one. They take a second or two to start, and a
        script that asks for them needs its ``if __name__ == "__main__"``. `close`, or a with statement, ends
        them.

    Raises
    ------
    ProblemError
        For a value out of range.

    Examples
    --------
    >>> from surefoot.robot import load_robot
    >>> batch = RigidBatch(load_robot("go2"), count=3, mu=[0.2, 0.6, 1.0])
    >>> batch.step(np.zeros((3, 12))).forces.shape
    (3, 4, 3)
    """

    def __init__(
        self,
        robot: Robot,
        terrain: Terrain | None = None,
        count: int = 1,
        mu: ArrayLike = 0.6,
        payload: ArrayLike = 0.0,
        options: StepOptions | None = None,
        workers: int = 1,
    ) -> None:
        self.robot, self.count = robot, whole_number("count", count, low=1)
        self.options = options or StepOptions()
        loads = per_robot("payload", payload, self.count)
        workers = min(whole_number("workers", workers, low=1), self.count)
        model, points = robot.model, len(robot.contact_points)
        shapes = {"q": (model.nq,), "v": (model.nv,), "torques": (robot.joints,), "push": (3,), "mu": (),
                  "forces": (points, 3), "gaps": (points,), "counts": (3,)}  # fmt: skip
        context = multiprocessing.get_context("spawn")  # forks of processes with threads can hang
        raw = {
            name: context.RawArray("d", self.count * int(np.prod(shape))) for name, shape in shapes.items()
        }
        self._arrays = {name: _view(raw[name], (self.count, *shapes[name])) for name in FIELDS}
        self._arrays["mu"][:] = per_robot("mu", mu, self.count)
        self._arrays["q"][:] = robot.nominal
        edges = np.linspace(0, self.count, workers + 1).astype(int).tolist()
        self._own = RobotCrew(robot, terrain, self.options, loads, self._arrays, 0, edges[1])
        self._rest: list[tuple[Connection, Any]] = []
        for start, stop in pairwise(edges[1:]):
            here, there = context.Pipe()
            arguments = (
                there,
                robot.without_meshes(),
                terrain,
                self.options,
                loads,
                raw,
                shapes,
                start,
                stop,
            )
            process = context.Process(target=_serve, args=arguments, daemon=True)
            process.start()
            self._rest.append((here, process))

    def reset(self, q: ArrayLike, v: ArrayLike | None = None, which: ArrayLike | None = None) -> None:
        """Put robots at q (count, nq) or (nq,) and v alike (None: at rest), without history.

        `which` (count,) is a mask of the robots that are meant; None for all.
        """
        a = self._arrays
        chosen = chosen_robots(which, self.count)
        new_q = rows_per_robot("q", q, self.count, a["q"].shape[1])
        new_v = np.zeros_like(a["v"]) if v is None else rows_per_robot("v", v, self.count, a["v"].shape[1])
        for k in np.flatnonzero(chosen).tolist():
            a["q"][k], a["v"][k] = self.robot.configuration(new_q[k]), new_v[k]
        a["counts"][chosen] = 0.0
        self._everywhere(("reset", chosen))

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (count, nq) [m, -, rad] and v (count, nv) [m/s, rad/s]."""
        return self._arrays["q"].copy(), self._arrays["v"].copy()

    def set_friction(self, mu: ArrayLike) -> None:
        """Change the friction of the ground [-], a number or (count,), from the next step on."""
        self._arrays["mu"][:] = per_robot("mu", mu, self.count)

    def step(self, torques: ArrayLike, push: ArrayLike | None = None, repeat: int = 1) -> BatchStep:
        """Advance all robots by `repeat` steps under (count, joints) torques [N m] and (count, 3) pushes [N].

        Raises
        ------
        ProblemError
            For a wrong shape or an entry that is not finite. Nothing has moved.
        """
        a, repeat = self._arrays, whole_number("repeat", repeat, low=1)
        given = finite_array("torques", torques, a["torques"].shape)
        pushes = None if push is None else finite_array("push", push, (self.count, 3))
        a["torques"][:], a["push"][:] = given, 0.0 if pushes is None else pushes
        a["counts"][:, 1] = 0.0
        self._everywhere(("step", (repeat, pushes is not None)))
        return BatchStep(
            a["q"].copy(), a["v"].copy(), a["forces"].copy(), a["gaps"].copy(),
            a["counts"][:, 1].astype(np.int64), a["counts"][:, 2] > 0.0,
        )  # fmt: skip

    def close(self) -> None:
        """End the worker processes."""
        for pipe, process in self._rest:
            pipe.send(None)  # closing the pipe is not enough: forked workers hold both of its ends
            process.join()
            pipe.close()
        self._rest = []

    def __enter__(self) -> RigidBatch:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _everywhere(self, order: tuple[str, Any]) -> None:
        """Have an order carried out by all, this process included."""
        for pipe, _ in self._rest:
            pipe.send(order)
        self._own.obey(order)
        failed = [found for pipe, _ in self._rest if (found := pipe.recv()) is not None]
        if failed:
            raise failed[0]


class RobotCrew:
    """Takes the steps of robots `start` to `stop` - 1, with one stepper for each payload."""

    def __init__(
        self, robot: Robot, terrain: Terrain | None, options: StepOptions, payload: FloatArray,
        arrays: dict[str, FloatArray], start: int, stop: int,
    ) -> None:  # fmt: skip
        self._arrays, self._first = arrays, start
        loads = payload[start:stop].tolist()
        known = {load: Stepper(robot, terrain, options, load) for load in set(loads)}
        self._steppers = [known[load] for load in loads]
        self._states: list[State] = [State(robot.nominal.copy(), np.zeros(robot.model.nv)) for _ in loads]

    def obey(self, order: tuple[str, Any]) -> None:
        """Carry out an order."""
        what, given = order
        if what == "reset":
            self._reset(given)
        else:
            for k in range(len(self._states)):
                self._step(k, *given)

    def _reset(self, chosen: BoolArray) -> None:
        a = self._arrays
        for k in range(len(self._states)):
            row = self._first + k
            if chosen[row]:
                self._states[k] = self._steppers[k].start(a["q"][row].copy(), a["v"][row].copy())

    def _step(self, k: int, repeat: int, pushed: bool) -> None:
        """Take the steps of one robot."""
        a, row = self._arrays, self._first + k
        counts = a["counts"][row]
        if counts[2] > 0.0:
            return
        torques, push = a["torques"][row].copy(), a["push"][row].copy() if pushed else None
        state, last = self._states[k], None
        for _ in range(repeat):
            try:
                last = self._steppers[k].step(state, torques, push, float(a["mu"][row]))
            except SimulationError:
                counts[2] = 1.0
                break
            state = last.state
            counts[0] += 1.0
            counts[1] += last.unsolved
        self._states[k] = state
        a["q"][row], a["v"][row] = state.q, state.v
        if last is not None:
            a["forces"][row], a["gaps"][row] = last.forces, last.gaps


def _serve(
    pipe: Connection, robot: Robot, terrain: Terrain | None, options: StepOptions, payload: FloatArray,
    raw: dict[str, Any], shapes: dict[str, tuple[int, ...]], start: int, stop: int,
) -> None:  # fmt: skip
    """Carry out orders up to None."""
    arrays = {name: _view(raw[name], (len(payload), *shapes[name])) for name in FIELDS}
    crew = RobotCrew(robot, terrain, options, payload, arrays, start, stop)
    while (order := pipe.recv()) is not None:
        try:
            crew.obey(order)
        except Exception as error:  # told to the process that asked
            pipe.send(error)
        else:
            pipe.send(None)


def _view(raw: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return shared memory as an array."""
    return np.frombuffer(raw, dtype=np.float64).reshape(shape)


def per_robot(name: str, value: ArrayLike, count: int) -> FloatArray:
    """Return a number or (count,), in any unit, as (count,), finite and not negative."""
    array = real_array(name, value)
    if array.shape not in ((), (count,)) or not np.isfinite(array).all() or (array < 0.0).any():
        raise ProblemError(f"{name} must be a number >= 0 or have shape ({count},), got {value!r}")
    return np.broadcast_to(array, (count,)).copy()


def chosen_robots(which: ArrayLike | None, count: int) -> BoolArray:
    """Return a mask of robots (count,); None for all."""
    chosen = np.ones(count, dtype=np.bool_) if which is None else np.asarray(which)
    if chosen.shape != (count,) or chosen.dtype != np.bool_:
        raise ProblemError(f"which must be a mask of shape ({count},), got {chosen.dtype} {chosen.shape}")
    return chosen


def rows_per_robot(name: str, value: ArrayLike, count: int, width: int) -> FloatArray:
    """Return (width,) or (count, width), in any unit, as the latter."""
    array = finite_array(name, value)
    if array.shape not in ((width,), (count, width)):
        raise ProblemError(f"{name} must have shape ({width},) or ({count}, {width}), got {array.shape}")
    return np.broadcast_to(array, (count, width))
