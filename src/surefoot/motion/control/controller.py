"""What a controller is: a robot's state in, one command out, at a fixed rate.

`surefoot.worlds.running.run.run` drives whatever keeps to this protocol; see docs/add-a-controller.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Protocol

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray
from surefoot.base.errors import ProblemError, shown
from surefoot.base.memory import Memory, Remembering
from surefoot.contact import Status
from surefoot.motion.state import HeightScan as HeightScan
from surefoot.motion.state import RobotState as RobotState
from surefoot.records import Channel


class JointTargets(NamedTuple):
    """What the joints' own controllers get; they give τ = τ_ff + kp (q_des - q) + kd (v_des - v).

    Attributes
    ----------
    positions, velocities
        (joints,) q_des [rad] and v_des [rad/s].
    stiffness, damping
        (joints,) kp [N m/rad] and kd [N m s/rad].
    feedforward
        (joints,) τ_ff [N m].
    """

    positions: FloatArray
    velocities: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    feedforward: FloatArray

    def torques(self, positions: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the torques [N m] at (joints,) positions [rad] and velocities [rad/s]."""
        pull = self.stiffness * (self.positions - positions) + self.damping * (self.velocities - velocities)
        return np.asarray(self.feedforward + pull)


@dataclass(frozen=True)
class Command:
    """What a controller asks for at one step; a subclass may tell more, by fields of keywords alone.

    Attributes
    ----------
    torques
        (joints,) within the effort limits [N m].
    forces
        (p, 3) the ground forces that it counts on, contact frames [N]; a single NaN for one that says none.
    active
        (p,) whether each contact point may push; a single flag for all.
    attained
        Whether what it wants is possible within the cones, bounds and limits; not on a robot that has fallen
        over, nor, in a walk, while no foot touches though the gait wants one on the ground.
    status
        How the force distribution ended.
    accelerations
        (nv,) that it aims at [m/s², rad/s²], Pinocchio's order; None if the controller knows of none.
    joint_targets
        What joints' own controllers get in place of the torques; None for the torques themselves.
    """

    torques: FloatArray
    forces: FloatArray = field(default_factory=lambda: np.array(np.nan))
    active: BoolArray = field(default_factory=lambda: np.array(True))
    attained: bool = True
    status: Status = Status.SOLVED
    accelerations: FloatArray | None = None
    joint_targets: JointTargets | None = None

    def rows(self) -> dict[str, Any]:
        """Return the values of the controller's own channels at this step, by name."""
        return {}

    def for_points(self, count: int) -> Command:
        """Return the command with forces and flags for each of `count` contact points."""
        if self.forces.ndim and self.active.ndim:
            return self
        forces, active = np.broadcast_to(self.forces, (count, 3)), np.broadcast_to(self.active, (count,))
        return replace(self, forces=forces, active=active)


class Controller(Protocol):
    """Turns states into commands at a fixed rate; subclass it to take what stands here ready-made.

    Attributes
    ----------
    channels
        What it adds to the log, beside what every command has; `Command.rows` gives the values.
    facts
        What the log should say about it: ``kind``, ``normal_min``, ``normal_max`` [N], ``mu_controller``, ...
    """

    channels: tuple[Channel, ...] = ()
    facts: Mapping[str, Any] = {}

    def reset(self) -> None:
        """Forget the past: the next step is the first of a run."""
        return

    def step(self, state: RobotState) -> Command:
        """Return the command for a state.

        Never raises on a hard instance or a state that is not finite: the command is flagged by its
        `attained` and `status`.
        """
        ...

    def warm_up(self, state: RobotState) -> None:
        """Compile or load all that `step` may call, and forget it again, so that no step of a run waits."""
        self.step(state)
        self.reset()


class FunctionController(Controller):
    """A function of the state that gives torques, as a controller.

    Parameters
    ----------
    function
        From a `RobotState` to (joints,) torques [N m], to `JointTargets`, or to a `Command`.
    joints
        How many the robot has.
    """

    def __init__(self, function: Callable[[RobotState], Any], joints: int) -> None:
        self._function, self._joints = function, joints
        self.facts = {"kind": getattr(function, "__name__", type(function).__name__)}

    def warm_up(self, state: RobotState) -> None:
        """Do nothing: a function that keeps something would keep what never was."""

    def step(self, state: RobotState) -> Command:
        """Return the function's command; torques that are not finite are none, and flagged.

        Raises
        ------
        ProblemError
            For what are not torques of the joints.
        """
        given = self._function(state)
        if isinstance(given, Command):
            return given
        joints = self._joints
        if isinstance(given, JointTargets):
            torques = given.torques(state.q[len(state.q) - joints :], state.v[len(state.v) - joints :])
            return Command(torques, joint_targets=given)
        torques = np.asarray(given)
        if torques.shape != (joints,) or torques.dtype.kind not in "fiu":
            raise ProblemError(
                f"a controller's function returns (joints,) = ({joints},) torques, JointTargets or a "
                f"Command, got {shown(given)}"
            )
        if not np.isfinite(torques).all():
            return Command(np.zeros(joints), attained=False, status=Status.INVALID)
        return Command(torques.astype(np.float64, copy=False))


CONTROLS = ("step", "reset", "warm_up", "channels", "facts")
"""What a controller has."""


def as_controller(controller: Controller | Callable[[RobotState], Any] | None, joints: int) -> Controller:
    """Return a controller, made of a function of the state where that is given.

    Raises
    ------
    ProblemError
        For what is neither, naming what it lacks.
    """
    lacks = [name for name in CONTROLS if not hasattr(controller, name)]
    if not lacks and not isinstance(controller, type):
        return controller  # type: ignore[return-value]  # what it has was just looked at
    if callable(controller) and not isinstance(controller, type) and "step" in lacks:
        return FunctionController(controller, joints)
    kind = controller.__name__ if isinstance(controller, type) else type(controller).__name__
    why = "is a class, not an object of it" if isinstance(controller, type) else f"lacks {', '.join(lacks)}"
    raise ProblemError(
        "controller must be an sf.Controller (a subclass has all but step) or a function of the state that "
        f"returns torques, got {'None' if controller is None else f'{kind}, which {why}'}"
    )


def state_of(controller: Any) -> Any:
    """Return the state of a controller: a copy of all that lasts from one step to the next.

    Raises
    ------
    ProblemError
        For a controller that cannot tell all of it, or cannot go on from it.
    """
    kind = type(controller)
    if not (hasattr(kind, "state") and hasattr(kind, "resume")):
        raise ProblemError(f"a {kind.__name__} does not tell its state, so that a run cannot go on from one")
    return controller.state


class Wrapper(Controller, Remembering):
    """A controller around another: it has the other's channels and facts, and `step` makes what it adds.

    A subclass names in `MEMORY` what lasts in it from one step to the next, `()` for nothing; without that
    its state is not known.

    Parameters
    ----------
    controller
        Who commands.
    """

    def __init__(self, controller: Controller) -> None:
        if not callable(getattr(controller, "step", None)):
            raise ProblemError(f"controller must be a Controller, got {shown(controller)}")
        self.controller = controller
        self.channels, self.facts = controller.channels, controller.facts

    @property
    def state(self) -> Memory:
        """A copy of all that lasts from one step to the next, here and inside.

        Raises
        ------
        ProblemError
            For a wrapper that does not name its `MEMORY`, or a controller inside that has no state.
        """
        kind = type(self)
        if "MEMORY" not in vars(kind):
            raise ProblemError(f"a {kind.__name__} does not name what lasts in it: give the class a MEMORY")
        return {"own": self.remembered(), "controller": state_of(self.controller)}

    def resume(self, memory: Memory) -> None:
        """Go on from a `state` of wrappers around a controller that were made in the same way."""
        if not isinstance(memory, dict) or memory.keys() != {"own", "controller"}:
            raise ProblemError(f"the state is not that of a {type(self).__name__} around a controller")
        self.controller.resume(memory["controller"])  # type: ignore[attr-defined]  # it has a state
        super().resume(memory["own"])

    def reset(self) -> None:
        """Forget the past: the next step is the first of a run, here and inside."""
        self.controller.reset()
        self._forget()

    def _forget(self) -> None:
        """Forget its own past."""

    def warm_up(self, state: RobotState) -> None:
        """Compile or load all that the controller's step may call."""
        self.controller.warm_up(state)
