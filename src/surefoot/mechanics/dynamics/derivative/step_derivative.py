"""The derivative of a step: the state behind it and its contact forces, by everything that goes into it.

The step is taken stage by stage (`stepper`): free motion, what moves the robot out of the ground, the
exchange of impulses, free motion. Each stage multiplies the columns so far (`derivative_flow`,
`derivative_impact`).
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray, IntArray, finite_array, real_number
from surefoot.base.errors import ProblemError
from surefoot.contact import KINK, Kink
from surefoot.mechanics.dynamics.derivative.first_order import FirstOrderStages
from surefoot.mechanics.dynamics.derivative.impact import TOUCHING, InputRates
from surefoot.mechanics.dynamics.derivative.saltation import LocatedStages
from surefoot.mechanics.dynamics.derivative.stages import Stages, StepArguments
from surefoot.mechanics.dynamics.state import State, Step
from surefoot.mechanics.dynamics.stepper import Stepper


class StepTangents(NamedTuple):
    """Rates of what a step returns: q and v (nv,), the mean forces (p, 3), and what is left to the next step.

    `leaving` (p, 3) are the rates of the contact velocities in its memory, see `StepDerivative.jvp`; for
    pairs without a contact in the contact problem they are not complete.
    """

    q: FloatArray
    v: FloatArray
    forces: FloatArray
    leaving: FloatArray


class StepCotangents(NamedTuple):
    """Gradients of one number: q, v (nv,), torques (joints,), mu, push (3,), inertia, leaving (p, 3).

    `inertia` is (bodies, 10), see `StepDerivative.inertia`.
    """

    q: FloatArray
    v: FloatArray
    torques: FloatArray
    mu: float
    push: FloatArray
    inertia: FloatArray
    leaving: FloatArray


class StepDerivative:
    """The derivative of one step; use `step_derivative` or `RigidWorld.derivative`.

    Positions move in the tangent space: δq (nv,) with q ⊕ δq, Pinocchio's `integrate` and `difference`, base
    velocities in its own axes. A step remembers contact velocities for the next (`StepRemainder.leaving`):
    `A` holds them still, and derivatives of several steps in a row need their `leaving` passed on as well.

    Contacts and their modes are those of the step: who may touch, which of two guesses of the swerve is
    taken, whether a gap is open. Where a mode is about to change `kinks` says so; `jvp` is one-sided there,
    and the rest belongs to the modes named. Redundant contacts: see `ContactDerivative`.

    Attributes
    ----------
    smoothing
        As given, see `ContactDerivative` [W]; every contact point of the robot takes part then.
    """

    def __init__(self, stepper: Stepper, request: StepArguments) -> None:
        soft = stepper.options.soft
        if soft is not None and request.smoothing > 0.0:
            raise ProblemError(f"a step with a {type(soft).__name__} is differentiated without smoothing")
        if stepper.geometry is not None and request.smoothing > 0.0:
            raise ProblemError("a step with a geometry is differentiated without smoothing")
        self._stepper, self._dt, self.smoothing = stepper, stepper.options.dt, request.smoothing
        self._stages = stages_of(stepper, request)
        self._by_mu = stepper.friction_rates(request.mu)

    @property
    def step(self) -> Step:
        """The step itself."""
        return self._stages.step

    @property
    def _sizes(self) -> dict[str, int]:
        stepper = self._stepper
        nv, points = stepper.bodies.model.nv, len(self._by_mu)
        return {"q": nv, "v": nv, "torques": stepper.robot.joints, "mu": 1, "push": 3, "leaving": 3 * points}

    @cached_property
    def _blocks(self) -> dict[str, FloatArray]:
        """Derivatives (2nv + 6p, size) of q, v, impulses and leaving, by name of the input."""
        sizes = self._sizes
        columns = self._stages.through(self._inputs(np.eye(sum(sizes.values()))))
        edges = np.cumsum(list(sizes.values()))[:-1]
        return dict(zip(sizes, np.split(columns, edges, axis=1), strict=True))

    def _inputs(self, columns: FloatArray) -> InputRates:
        """Return rows of columns by input."""
        rows: Any = np.split(columns, np.cumsum(list(self._sizes.values()))[:-1])
        rates = InputRates(*rows)
        return rates._replace(mu=self._by_mu[:, None] * rates.mu)

    def _part(self, name: str) -> FloatArray:
        return self._blocks[name][: 2 * self._sizes["v"]]

    @property
    def A(self) -> FloatArray:
        """(2nv, 2nv) of (q, v) after the step by (q, v) before it, in the units of both."""
        return np.hstack([self._part("q"), self._part("v")])

    @property
    def B(self) -> FloatArray:
        """(2nv, joints) of (q, v) by the torques, in the units of v and q per N m."""
        return self._part("torques")

    @property
    def mu(self) -> FloatArray:
        """(2nv,) of (q, v) by the friction of the ground, in the units of (q, v)."""
        return self._part("mu")[:, 0]

    @property
    def push(self) -> FloatArray:
        """(2nv, 3) of (q, v) by the push on the base [per N], world axes."""
        return self._part("push")

    @property
    def leaving(self) -> FloatArray:
        """(2nv, 3p) of (q, v) by the contact velocities [m/s] in the state's memory; zero where none."""
        return self._part("leaving")

    @cached_property
    def _inertia(self) -> FloatArray:
        """(2nv + 6p, 10 bodies), like `_blocks`."""
        count = 10 * (self._stepper.bodies.model.njoints - 1)
        nothing = self._inputs(np.zeros((sum(self._sizes.values()), count)))
        return self._stages.through(nothing._replace(inertia=np.eye(count)))

    @property
    def inertia(self) -> FloatArray:
        """(2nv, bodies, 10) of (q, v) by every body's inertial parameters, in Pinocchio's order.

        Mass, mass times centre of mass, and the inertia about the joint's origin xx, xy, yy, xz, yz, zz
        (`Inertia.toDynamicParameters`); body k moves with joint k + 1.
        """
        part = self._inertia[: 2 * self._sizes["v"]]
        return part.reshape(len(part), -1, 10)

    @property
    def forces(self) -> dict[str, FloatArray]:
        """(3p, size) derivatives of the mean contact forces, contact axes, by name of the input."""
        start = 2 * self._sizes["v"]
        rows = slice(start, start + self._sizes["leaving"])
        return {name: block[rows] / self._dt for name, block in self._blocks.items()}

    @property
    def kinks(self) -> tuple[Kink, ...]:
        """Contacts that are about to change their mode, numbered as the robot's contact points."""
        found: list[Kink] = []
        for response, near in self._stages.responses:
            if response.distance <= 10.0 * KINK:
                found += [kink.__class__(int(near[kink.contact]), kink.distance, kink.modes)
                          for kink in response.derivative.kinks]  # fmt: skip
        return tuple(found)

    @property
    def touching(self) -> IntArray:
        """Contact points (k,) whose gap is zero to 1e-9 m: motions off and into the ground differ there.

        One that opens is put back on the ground by the step, one that is pressed in is not (up to the
        stabilisation): dense blocks belong to the gap's sign as it came out.
        """
        none = self.step.impact is None or bool(self.step.pieces) or self.smoothing > 0.0
        if self.step.impact is None or none or self._stepper.options.pull == 1.0:
            return np.zeros(0, dtype=np.int64)
        near = self.step.impact.near
        return near[np.abs(self.step.gaps[near]) <= TOUCHING]

    @property
    def modes(self) -> tuple[str, ...]:
        """What every contact point does: "open", "stick", "slide" and so on; "smooth" with smoothing."""
        out = ["open"] * len(self._by_mu)
        for response, near in self._stages.responses[-1:]:
            for k, mode in zip(near.tolist(), response.derivative.modes, strict=True):
                out[k] = mode
        return tuple(out)

    def jvp(
        self,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        torques: ArrayLike | None = None,
        mu: float = 0.0,
        push: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        leaving: ArrayLike | None = None,
    ) -> StepTangents:
        """Return how the step moves if q (nv,), v (nv,) and the rest do; one-sided at kinks.

        Parameters
        ----------
        q, v, torques, mu, push, inertia
            Rates of the arguments; inertia (bodies, 10), see `inertia`.
        leaving
            (p, 3) rates of what the step before left in its memory: `StepTangents.leaving` of its own jvp.

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        given = {"q": q, "v": v, "torques": torques, "mu": mu, "push": push, "leaving": leaving}
        parts = []
        for name, size in self._sizes.items():
            value = given[name]
            shape = (size // 3, 3) if name == "leaving" else (() if name == "mu" else (size,))
            parts.append(np.zeros(size) if value is None else finite_array(name, value, shape).reshape(-1))
        flat = np.concatenate(parts)
        own = None if inertia is None else finite_array("inertia", inertia, self.inertia.shape[1:]).ravel()
        kinked = any(response.distance <= 10.0 * KINK for response, _ in self._stages.responses)
        if kinked or self.touching.size:
            inputs = self._inputs(flat[:, None])._replace(one_sided=True)
            out = self._stages.through(inputs._replace(inertia=None if own is None else own[:, None]))[:, 0]
        else:
            out = np.hstack(list(self._blocks.values())) @ flat
            if own is not None:
                out = out + self._inertia @ own
        dq, dv, impulses, left = self._split(out)
        return StepTangents(dq, dv, impulses.reshape(-1, 3) / self._dt, left.reshape(-1, 3))

    def vjp(
        self,
        q: ArrayLike | None = None,
        v: ArrayLike | None = None,
        forces: ArrayLike | None = None,
        leaving: ArrayLike | None = None,
        inertia: bool = True,
    ) -> StepCotangents:
        """Return the gradient of q·δq + v·δv + forces·f + leaving·u, for weights of what the step returns.

        The weights q and v are (nv,), forces and leaving (p, 3), in any unit. `inertia` may be switched off:
        it takes longest.

        Raises
        ------
        ProblemError
            If a shape is wrong or an entry is not finite.
        """
        nv, points = self._sizes["v"], self._sizes["leaving"] // 3
        weights = np.zeros(2 * nv + 6 * points)
        for part, name, value, shape in zip(
            self._split(weights), ("q", "v", "forces", "leaving"), (q, v, forces, leaving),
            ((nv,), (nv,), (points, 3), (points, 3)), strict=True,
        ):  # fmt: skip
            if value is not None:
                part[:] = finite_array(name, value, shape).ravel() / (self._dt if name == "forces" else 1.0)
        back = {name: weights @ block for name, block in self._blocks.items()}
        bodies = self._stepper.bodies.model.njoints - 1
        own = (weights @ self._inertia) if inertia else np.zeros(10 * bodies)
        return StepCotangents(
            back["q"], back["v"], back["torques"], float(back["mu"][0]), back["push"],
            own.reshape(bodies, 10), back["leaving"].reshape(-1, 3),
        )  # fmt: skip

    def _split(self, rows: FloatArray) -> list[Any]:
        """Return the parts of (2nv + 6p,) as views."""
        nv, rest = self._sizes["v"], self._sizes["leaving"]
        return np.split(rows, np.cumsum([nv, nv, rest]))


def stages_of(stepper: Stepper, request: StepArguments) -> Stages:
    """Return the stages of a step, of the kind that it was taken in; its outcome may be known."""
    step = request.step
    if step is not None and step.pieces and request.smoothing == 0.0:
        return LocatedStages(stepper, request)
    first = stepper.options.order == 1 and (step is None or step.impact is not None)
    return (FirstOrderStages if first else Stages)(stepper, request)


def step_derivative(
    stepper: Stepper,
    state: State,
    torques: FloatArray,
    push: FloatArray | None = None,
    mu: float = 0.6,
    smoothing: float = 0.0,
    step: Step | None = None,
) -> StepDerivative:
    """Take a step and return its derivative; the arguments are those of `Stepper.step`.

    Parameters
    ----------
    smoothing
        0 for the laws themselves; else normal force times normal velocity on the central path [W], in
        impulses per step: N s · m/s. See `ContactDerivative`.
    step
        Its outcome where that is known, so that it need not be taken once more.

    Raises
    ------
    NoSolution
        If the step's contact problem is not SOLVED.
    ProblemError
        For arguments out of range, laws other than the rigid ones, or joints without derivative.
    SimulationError
        Where the motion cannot be resolved or stops being finite.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> stepper = Stepper(load_robot("go2"))
    >>> d = step_derivative(stepper, stepper.start(), np.zeros(12))
    >>> d.A.shape, d.B.shape, len(d.modes)
    ((36, 36), (36, 12), 4)
    """
    smoothing = real_number("smoothing", smoothing, low=0.0, high=1e300)
    mu = real_number("mu", mu, low=0.0)
    if smoothing > 0.0:
        step = None
    elif step is None:
        step = stepper.step(state, torques, push, mu)
    return StepDerivative(stepper, StepArguments(state, torques, push, mu, smoothing, step))
