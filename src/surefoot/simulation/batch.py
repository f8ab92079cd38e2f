"""Many robots of one model at once: state arrays in, state arrays out, each as in a `RigidWorld` of its own.

A step of one robot is a dozen short calls that hold Python's lock, so threads would wait for each other:
`workers` are processes, each with some of the robots. The answers do not depend on their number: robots are
apart, and a step depends on its own state alone.
"""

from __future__ import annotations

import multiprocessing
from dataclasses import dataclass
from itertools import pairwise
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surefoot.arrays import BoolArray, FloatArray, IntArray, finite_array, of_kind, real_array, whole_number
from surefoot.errors import ProblemError, SimulationError
from surefoot.robot import Robot
from surefoot.stepping import State, StepOptions, Stepper
from surefoot.terrain import Terrain


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
        of_kind("robot", robot, Robot)
        self.robot, self.count = robot, whole_number("count", count, low=1)
        self.options = options or StepOptions()
        self.set_friction(mu)
        loads = per_robot("payload", payload, self.count)
        workers = min(whole_number("workers", workers, low=1), self.count)
        self._q, self._v = np.tile(robot.nominal, (self.count, 1)), np.zeros((self.count, robot.model.nv))
        edges = np.linspace(0, self.count, workers + 1).astype(int).tolist()
        self._parts = [slice(*ends) for ends in pairwise(edges)]
        self._own = RobotCrew(robot, terrain, self.options, loads[self._parts[0]])
        self._rest: list[tuple[Connection, Any]] = []
        context = multiprocessing.get_context("spawn")  # forks of processes with threads can hang
        for part in self._parts[1:]:
            here, there = context.Pipe()
            given = there, robot.without_meshes(), terrain, self.options, loads[part]
            process = context.Process(target=_serve, args=given, daemon=True)
            process.start()
            self._rest.append((here, process))

    def reset(self, q: ArrayLike, v: ArrayLike | None = None, which: ArrayLike | None = None) -> None:
        """Put robots at q (count, nq) or (nq,) and v alike (None: at rest), without history.

        `which` (count,) is a mask of the robots that are meant; None for all.
        """
        chosen = chosen_robots(which, self.count)
        new_q = rows_per_robot("q", q, self.count, self._q.shape[1])
        new_v = np.zeros_like(self._v) if v is None else rows_per_robot("v", v, self.count, self._v.shape[1])
        for k in np.flatnonzero(chosen).tolist():
            self._q[k], self._v[k] = self.robot.configuration(new_q[k]), new_v[k]
        self._everywhere("reset", self._q, self._v, chosen)

    def state(self) -> tuple[FloatArray, FloatArray]:
        """Return q (count, nq) [m, -, rad] and v (count, nv) [m/s, rad/s]."""
        return self._q.copy(), self._v.copy()

    def set_friction(self, mu: ArrayLike) -> None:
        """Change the friction of the ground [-], a number or (count,), from the next step on."""
        self._mu = per_robot("mu", mu, self.count)

    def step(self, torques: ArrayLike, push: ArrayLike | None = None, repeat: int = 1) -> BatchStep:
        """Advance all robots by `repeat` steps under (count, joints) torques [N m] and (count, 3) pushes [N].

        Raises
        ------
        ProblemError
            For a wrong shape or an entry that is not finite. Nothing has moved.
        """
        given = finite_array("torques", torques, (self.count, self.robot.joints))
        pushes = None if push is None else finite_array("push", push, (self.count, 3))
        done = self._everywhere("step", given, pushes, self._mu, whole_number("repeat", repeat, low=1))
        out = BatchStep(*map(np.concatenate, zip(*done, strict=True)))
        self._q[:], self._v[:] = out.q, out.v
        return out

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

    def _everywhere(self, order: str, *given: Any) -> list[Any]:
        """Return what all crews, this process's first, answer to an order with their robots' rows."""
        mine, *theirs = ([x[part] if isinstance(x, np.ndarray) else x for x in given] for part in self._parts)
        for (pipe, _), rows in zip(self._rest, theirs, strict=True):
            pipe.send((order, rows))
        answers = [getattr(self._own, order)(*mine), *(pipe.recv() for pipe, _ in self._rest)]
        for answer in answers:
            if isinstance(answer, Exception):
                raise answer
        return answers


class RobotCrew:
    """Takes the steps of (n,) robots, with one stepper for each payload."""

    def __init__(
        self, robot: Robot, terrain: Terrain | None, options: StepOptions, payload: FloatArray
    ) -> None:
        known = {load: Stepper(robot, terrain, options, load) for load in set(payload.tolist())}
        self._steppers = [known[load] for load in payload.tolist()]
        n, p, still = len(payload), len(robot.contact_points), np.zeros(robot.model.nv)
        self._states: list[State] = [State(robot.nominal.copy(), still.copy()) for _ in range(n)]
        self._forces, self._gaps = np.zeros((n, p, 3)), np.zeros((n, p))
        self._lost: BoolArray = np.zeros(n, dtype=np.bool_)

    def reset(self, q: FloatArray, v: FloatArray, chosen: BoolArray) -> None:
        """Put the `chosen` (n,) robots at (n, nq) q, (n, nv) v [m, rad], [m/s, rad/s]."""
        for k in np.flatnonzero(chosen).tolist():
            self._states[k] = self._steppers[k].start(q[k].copy(), v[k].copy())
        self._lost[chosen] = False

    def step(
        self, torques: FloatArray, push: FloatArray | None, mu: FloatArray, repeat: int
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, IntArray, BoolArray]:
        """Return the fields of a `BatchStep` under (n, joints) torques [N m] and (n, 3) pushes [N]."""
        unsolved: IntArray = np.zeros(len(mu), dtype=np.int64)
        for k in np.flatnonzero(~self._lost).tolist():
            pushed, friction = None if push is None else push[k].copy(), float(mu[k])
            for _ in range(repeat):
                try:
                    last = self._steppers[k].step(self._states[k], torques[k].copy(), pushed, friction)
                except SimulationError:
                    self._lost[k] = True
                    break
                self._states[k] = last.state
                unsolved[k] += last.unsolved
                self._forces[k], self._gaps[k] = last.forces, last.gaps
        q, v = (np.array([getattr(state, name) for state in self._states]) for name in ("q", "v"))
        return q, v, self._forces.copy(), self._gaps.copy(), unsolved, self._lost.copy()


def _serve(
    pipe: Connection, robot: Robot, terrain: Terrain | None, options: StepOptions, payload: FloatArray
) -> None:
    """Carry out orders up to None."""
    crew = RobotCrew(robot, terrain, options, payload)
    while (order := pipe.recv()) is not None:
        try:
            pipe.send(getattr(crew, order[0])(*order[1]))
        except Exception as error:  # for the process that asked
            pipe.send(error)


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
