"""A learned policy as a controller: what it is fed with, and its actions as targets of the joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, real_number
from surefoot.base.discrete_damping import BORNE, largest_damping
from surefoot.base.errors import ProblemError
from surefoot.base.text_files import path_of
from surefoot.contact import Status
from surefoot.mechanics import FlatTerrain, Robot, Terrain, load_robot
from surefoot.motion.control.controller import Command, Controller, JointTargets, RobotState
from surefoot.motion.control.damping import computable, damping_torques
from surefoot.motion.policy.network import open_network
from surefoot.motion.policy.observation_terms import KINDS, Senses
from surefoot.motion.policy.publishers import beside, describe, robot_of
from surefoot.motion.policy.spec import PolicySpec, missing
from surefoot.motion.walking.walking_body import VelocityCommand
from surefoot.records import CHANNELS

TermFunction = Callable[[RobotState], FloatArray]


@dataclass(frozen=True, kw_only=True)
class PolicyCommand(Command):
    """A policy's command.

    Attributes
    ----------
    wanted
        (3,) what the policy was asked for: forward, left [m/s], yaw rate [rad/s].
    """

    wanted: FloatArray

    def rows(self) -> dict[str, Any]:
        """Return the row of the channel `command`."""
        return {"command": self.wanted}


class Policy(Controller):
    """A network that turns observations into joint targets, as its description says.

    Parameters
    ----------
    file
        Network: .onnx, or TorchScript (.pt, .jit), which is code.
    spec
        Its description: a YAML file, ours or its publisher's, or a table with our keys (docs/policies.md);
        None for a YAML of the same stem beside it. ONNX metadata says what the description does not.
    robot
        A robot or its name; None for the one that the file's name says, or go2.
    command
        Forward, left [m/s], yaw rate [rad/s], or a `VelocityCommand`; held within the policy's own range.
    terrain
        The ground that its height scan sees; None for flat.
    terms
        Functions of a `RobotState` for observations of other names than ours.
    trust
        Whether code of a TorchScript file may run.
    dt
        Time between calls of `step` [s]: drives are as fast as that, and damp light joints no more than it
        bears.

    Attributes
    ----------
    spec, robot, sources
        What was understood, for which robot; and where each key was read.
    sizes
        Names of the observation's terms, and how many numbers each has with its history.
    posture
        (nq,) robot's nominal pose with the policy's default joints: where a run should start.

    Raises
    ------
    ProblemError
        For a network or description that cannot be used, naming what is missing, or the joint, term or size
        at fault.
    MissingExtra
        Without onnxruntime (extra `policy`) or torch (extra `torch`).
    """

    channels = (CHANNELS["command"],)

    def __init__(
        self,
        file: str | Path,
        spec: str | Path | Mapping[str, Any] | None = None,
        robot: Robot | str | None = None,
        command: VelocityCommand | Sequence[float] = (0.5, 0.0, 0.0),
        *,
        terrain: Terrain | None = None,
        terms: Mapping[str, TermFunction] | None = None,
        trust: bool = False,
        dt: float = 1e-3,
    ) -> None:
        path = path_of(file)
        chosen = robot_of(path) or "go2" if robot is None else robot
        self.robot = load_robot(chosen) if isinstance(chosen, str) else chosen
        self.network = open_network(path, trust)
        said = spec if isinstance(spec, Mapping) else Path(spec) if spec is not None else beside(path)
        described = describe(self.network, said, self.robot)
        if missing(described.table):
            raise ProblemError(
                f"{path.name}: nothing says its {', '.join(missing(described.table))}: write them into "
                f"{path.stem}.yaml beside it, or --policy-spec FILE; see docs/policies.md"
            )
        functions = dict(terms or {})
        self.sources, self.spec = described.sources, PolicySpec.of(described.table, self.robot, [*functions])
        self.wanted = (
            command if isinstance(command, VelocityCommand)
            else VelocityCommand.constant(*finite_array("command", command, (3,)))
        )  # fmt: skip
        self._terrain = FlatTerrain() if terrain is None else terrain
        notes = self._prepare(real_number("dt", dt, low=1e-6))
        self._feed = _Feed(self.spec, functions, self._senses(self.still))
        self._check_sizes(path)
        low, high = self.spec.command_range
        changed = bool((np.clip(self.wanted.values, low, high) != self.wanted.values).any())
        note = f"command held within the policy's range: {low.tolist()} to {high.tolist()}"
        self.facts = {
            "kind": "walk", "gait": "policy", "normal_min": 0.0, "normal_max": math.inf,
            "mu_controller": math.inf, "notes": [*notes, note] if changed else notes,
        }  # fmt: skip
        self.reset()

    def _prepare(self, dt: float) -> list[str]:
        """Find the policy's joints among the robot's, and the gains of all; return what was changed."""
        import pinocchio

        robot, spec = self.robot, self.spec
        self._at = np.array([robot.joint_names.index(name) for name in spec.joints])
        self._first = (robot.model.nq - robot.joints, robot.base_dof)
        self._goal = robot.nominal[self._first[0] :].copy()
        self._goal[self._at] = spec.default
        gains = (np.full(robot.joints, spec.others[key]) for key in ("stiffness", "damping"))
        self._stiffness, self._damping = gains
        self._stiffness[self._at], self._damping[self._at] = spec.stiffness, spec.damping
        self.posture = robot.nominal.copy()
        self.posture[self._first[0] :] = self._goal
        inertia = np.diag(pinocchio.crba(robot.model, robot.model.createData(), self.posture))
        most = largest_damping(inertia[self._first[1] :], dt, BORNE)
        over = np.flatnonzero(self._damping > most)
        lowered = [f"{robot.joint_names[k]} {self._damping[k]:g} to {most[k]:.2g}" for k in over]
        self._damping = np.minimum(self._damping, most)
        self._limits = robot.effort_limits
        self._action, self._asked = np.zeros(len(spec.joints)), np.zeros(3)
        return [f"damping lowered to what a step bears: {', '.join(lowered)}"] if lowered else []

    @property
    def still(self) -> RobotState:
        """The pose that it starts from, at rest."""
        return RobotState(self.posture, np.zeros(self.robot.model.nv))

    def _check_sizes(self, path: Path) -> None:
        """Refuse a description whose sizes are not the network's."""
        self.sizes = self._feed.sizes
        terms = ", ".join(f"{name} {size}" for name, size in self.sizes)
        takes, gives, joints = self.network.inputs, self.network.outputs, self.spec.joints
        if takes and takes != self._feed.size:
            raise ProblemError(
                f"the observation has {self._feed.size} numbers ({terms}), {path.name} takes {takes}"
            )
        try:
            gives = gives or len(self.network(np.zeros(self._feed.size)))
        except RuntimeError as error:  # torch tells sizes only so
            raise ProblemError(
                f"{path.name} does not take {self._feed.size} numbers ({terms}): {str(error)[-120:]}"
            ) from error
        if gives != len(joints):
            raise ProblemError(
                f"{path.name} gives {gives} actions, its description names {len(joints)} joints: "
                f"{', '.join(joints)}"
            )

    def reset(self) -> None:
        """Forget the past: actions, histories, the network's memory."""
        self.network.reset()
        self._feed.reset()
        self._action = np.zeros(len(self.spec.joints))
        self._asked = np.clip(self.wanted.at(0.0), *self.spec.command_range)
        self._next, self._healthy = 0.0, True
        self._targets: JointTargets | None = None

    def step(self, state: RobotState) -> PolicyCommand:
        """Return joint targets, new ones at the policy's rate; see `Controller.step`."""
        if not computable(state.q, state.v):
            torques = damping_torques(self.robot, state.v, self._limits)
            return PolicyCommand(torques, attained=False, status=Status.INVALID, wanted=self._asked)
        if self._targets is None or state.time >= self._next - 1e-9:
            start = state.time if self._targets is None else self._next
            self._next = max(start + 1.0 / self.spec.rate, state.time)
            self._targets = self._answer(state)
        q, v = state.q[self._first[0] :], state.v[self._first[1] :]
        torques = np.clip(self._targets.torques(q, v), -self._limits, self._limits)
        status = Status.SOLVED if self._healthy else Status.INVALID
        return PolicyCommand(
            torques, attained=self._healthy, status=status, wanted=self._asked, joint_targets=self._targets
        )

    def _answer(self, state: RobotState) -> JointTargets:
        """Return the targets that the network wants at a state; the last ones where it gives no numbers."""
        spec = self.spec
        self._asked = np.clip(self.wanted.at(state.time), *spec.command_range)
        action = self.network(self._feed(self._senses(state)))
        self._healthy = bool(np.isfinite(action).all())
        if self._healthy:
            self._action = np.clip(action, *spec.action_clip)
            self._goal = self._goal.copy()
            target = spec.action_offset + spec.action_scale * self._action
            self._goal[self._at] = np.clip(target, *spec.target_clip)
        none = np.zeros(self.robot.joints)
        return JointTargets(self._goal, none, self._stiffness, self._damping, none)

    def _senses(self, state: RobotState) -> Senses:
        """Return what the terms are made of, joints in the policy's order."""
        q, v = state.q[self._first[0] :][self._at], state.v[self._first[1] :][self._at]
        return Senses(state, q - self.spec.default, v, self._asked, self._action, self._terrain)


class _Feed:
    """Turns senses into the network's input, histories and all.

    Parameters
    ----------
    spec
        Which terms, how scaled and stacked.
    functions
        Terms of the user's.
    senses
        Any: to find the sizes.
    """

    def __init__(self, spec: PolicySpec, functions: Mapping[str, TermFunction], senses: Senses) -> None:
        self._spec, self._terms = spec, spec.observations
        self._functions = dict(functions)
        self._sensed = self._find_sensed()
        sizes = []
        for term, sensed in zip(self._terms, self._sensed, strict=True):
            size = len(np.atleast_1d(sensed(senses, term.settings)))
            if term.scale.ndim and term.scale.shape != (size,):
                raise ProblemError(f"scale of {term.name} has {term.scale.size} values for {size} numbers")
            sizes.append(size)
        self.sizes = [(t.name, n * t.history) for t, n in zip(self._terms, sizes, strict=True)]
        self.size = sum(n for _, n in self.sizes)
        longest = max((term.history for term in self._terms), default=1)
        starts = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        self._slices = [slice(a, b) for a, b in pairwise(starts)]
        self._past = np.zeros((longest, starts[-1]))  # the newest first
        self._index = self._order(starts)
        self._empty = True

    def _find_sensed(self) -> list[Callable[[Senses, Mapping[str, Any]], FloatArray]]:
        """Return what senses each term."""
        known = [term.name in KINDS for term in self._terms]
        return [
            KINDS[term.name].sensed if own else _by_user(self._functions[term.name])
            for term, own in zip(self._terms, known, strict=True)
        ]

    def __getstate__(self) -> dict[str, Any]:
        """Return all but what the terms' names say."""
        return {name: value for name, value in vars(self).items() if name != "_sensed"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._sensed = self._find_sensed()

    def _order(self, starts: Any) -> Any:
        """Return where in the past each number of the input stands."""
        width, newest = starts[-1], self._spec.order == "newest"
        blocks = []
        for k, term in enumerate(self._terms):
            ages = np.arange(term.history) if newest else np.arange(term.history)[::-1]
            blocks.append(ages[:, None] * width + np.arange(starts[k], starts[k + 1]))
        if self._spec.by == "time":
            return np.hstack(blocks).ravel()
        return np.concatenate([block.ravel() for block in blocks])

    def reset(self) -> None:
        """Forget the past."""
        self._past[:] = 0.0
        self._empty = True

    def __call__(self, senses: Senses) -> FloatArray:
        """Return the (size,) input."""
        past, limit = self._past, self._spec.observation_clip
        past[1:] = past[:-1]
        now = past[0]
        for term, sensed, part in zip(self._terms, self._sensed, self._slices, strict=True):
            value = sensed(senses, term.settings)
            if term.clip is not None:
                value = np.clip(value, *term.clip)
            now[part] = term.scale * value
        if limit < np.inf:
            np.clip(now, -limit, limit, out=now)
        if self._empty and self._spec.start == "repeat":
            past[1:] = now
        self._empty = False
        return np.asarray(past.ravel()[self._index])


def _by_user(function: TermFunction) -> Callable[[Senses, Mapping[str, Any]], FloatArray]:
    """Return a user's function of a state as one of senses."""
    return lambda senses, settings: np.asarray(function(senses.state), dtype=np.float64)
