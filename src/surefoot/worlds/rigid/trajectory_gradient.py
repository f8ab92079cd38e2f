"""What a whole rollout leads to as a function of its parameters, with its gradient: `rollout_backward`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from inspect import Parameter, signature
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.mechanics import State
from surefoot.worlds.rigid.rollout_backward import WIDTH, Backward
from surefoot.worlds.rigid.rollout_record import RECORDER, RolloutRecorder

Rollout = Callable[..., Any]
Loss = Callable[[FloatArray, FloatArray], float]


class LossGradient(NamedTuple):
    """A loss and its gradient: by name of the parameter, a number or an array of its shape."""

    loss: float
    gradient: dict[str, Any]


class TrajectoryGradient:
    """A loss of a rollout as a function of its parameters, with its gradient; see `trajectory_gradient`."""

    def __init__(self, rollout: Rollout, loss: Loss, wrt: Sequence[str]) -> None:
        of_kind("rollout", rollout, Callable)  # type: ignore[arg-type]
        of_kind("wrt", wrt, Sequence)
        if not wrt or isinstance(wrt, str):
            raise ProblemError(f"wrt must be a list of names of the rollout's parameters, got {wrt!r}")
        taken = signature(rollout).parameters.values()
        if not any(p.kind is Parameter.VAR_KEYWORD for p in taken):
            for name in wrt:
                check_name("parameter of the rollout", name, [p.name for p in taken])
        self.rollout, self.loss, self.wrt = rollout, loss, tuple(wrt)

    def __call__(self, **parameters: Any) -> LossGradient:
        """Return loss and gradient at parameters of the rollout, those of `wrt` and others."""
        values, taken = self._values(parameters), self._run(parameters)
        assert taken.world is not None
        way = Backward(self._run, parameters, values, taken)
        found = way.slopes(partial(self._loss_rates, taken), partial(self._loss_along, taken))
        return LossGradient(self._loss(*_arrays(taken.states)), found)

    def value(self, **parameters: Any) -> float:
        """Return the loss alone."""
        return self._loss(*_arrays(self._run(parameters).states))

    @property
    def jax(self) -> Any:
        """The loss as a function in JAX of the parameters of `wrt` in their order; jit and grad see one."""
        import jax
        import jax.numpy as jnp

        kind = jnp.zeros(0).dtype  # double where JAX has it switched on

        def both(*values: Any) -> tuple[Any, ...]:
            found = self(
                **dict(zip(self.wrt, (np.asarray(v, dtype=np.float64) for v in values), strict=True))
            )
            parts = [np.asarray(found.loss), *(np.asarray(found.gradient[n]) for n in self.wrt)]
            return tuple(p.astype(kind) for p in parts)

        def called(*values: Any) -> Any:
            shapes = [jax.ShapeDtypeStruct(np.shape(v), kind) for v in (0.0, *values)]
            return jax.pure_callback(both, tuple(shapes), *values)

        loss: Any = jax.custom_vjp(lambda *values: called(*values)[0])

        def forward(*values: Any) -> Any:
            first, *rest = called(*values)
            return first, tuple(rest)

        loss.defvjp(forward, lambda kept, weight: tuple(weight * part for part in kept))
        return loss

    @property
    def torch(self) -> Any:
        """The same in PyTorch: tensors in, a tensor with its gradient out."""
        import torch

        outer = self

        class RolloutLoss(torch.autograd.Function):  # type: ignore[misc]
            @staticmethod
            def forward(context: Any, *values: Any) -> Any:
                arrays = (v.detach().cpu().double().numpy() for v in values)
                found = outer(**dict(zip(outer.wrt, arrays, strict=True)))
                parts = (found.gradient[n] for n in outer.wrt)
                context.save_for_backward(
                    *(torch.as_tensor(p).to(v) for p, v in zip(parts, values, strict=True))
                )
                return torch.as_tensor(found.loss).to(values[0])

            @staticmethod
            def backward(context: Any, weight: Any) -> Any:
                return tuple(weight * part for part in context.saved_tensors)

        return RolloutLoss.apply

    def _loss(self, q: FloatArray, v: FloatArray) -> float:
        """Return the loss of states, (n + 1, nq) and (n + 1, nv)."""
        return real_number("the loss", self.loss(q, v))

    def _values(self, parameters: dict[str, Any]) -> dict[str, FloatArray]:
        """Return what the gradient is by, as arrays."""
        missing = [name for name in self.wrt if name not in parameters]
        if missing:
            raise ProblemError(
                f"give the rollout's {', '.join(missing)}: the gradient is by {', '.join(self.wrt)}"
            )
        return {name: finite_array(name, parameters[name]) for name in self.wrt}

    def _run(
        self, parameters: dict[str, Any], states: list[State] | None = None, *before: Any
    ) -> RolloutRecorder:
        """Return what a run of the rollout does: on its own, or in given states, see `RolloutRecorder`."""
        recorder = RolloutRecorder(states, *before)
        token = RECORDER.set(recorder)
        try:
            self.rollout(**parameters)
        finally:
            RECORDER.reset(token)
        if recorder.world is None:
            raise ProblemError("a rollout makes a RigidWorld and calls its step: this one took none")
        if states is not None and recorder.count != len(states) - 1:
            raise ProblemError("a rollout takes as many steps whatever its parameters are, this one does not")
        return recorder

    def _loss_along(self, taken: RolloutRecorder, motions: FloatArray) -> FloatArray:
        """Return the rates (c,) of the loss along motions of all states (n + 1, 2nv, c), by differences."""
        assert taken.world is not None
        integrate, nv = taken.world.stepper.bodies.moved, motions.shape[1] // 2
        q, v = _arrays(taken.states)

        def at(way: FloatArray) -> float:
            moved = [integrate(here, step) for here, step in zip(q, way[:, :nv], strict=True)]
            return self._loss(np.array(moved), v + way[:, nv:])

        out = np.zeros(motions.shape[2])
        for j, motion in enumerate(np.moveaxis(motions, 2, 0)):
            size = float(np.abs(motion).max()) or 1.0
            way = np.ascontiguousarray(motion) * (WIDTH / size)
            out[j] = (at(way) - at(-way)) * (size / (2.0 * WIDTH))
        return out

    def _loss_rates(self, taken: RolloutRecorder) -> FloatArray:
        """Return the gradient (n + 1, 2nv) of the loss by every state, by differences of the loss.

        States and components that it does not look at are found first, all together.
        """
        assert taken.world is not None
        states, integrate = taken.states, taken.world.stepper.bodies.moved
        (q, v), nv = _arrays(states), states[0].v.size
        way, here = np.random.default_rng(0).normal(size=2 * nv), self._loss(q, v)

        def moved(rows: Any, step: FloatArray) -> float:
            kept = q[rows], v[rows]
            q[rows], v[rows] = [integrate(at, step[:nv]) for at in kept[0]], kept[1] + step[nv:]
            found = self._loss(q, v)
            q[rows], v[rows] = kept
            return found

        # By halving: a part of the states that can be moved at random without moving the loss is left out
        # whole. A loss of the last state costs the logarithm of the steps in looks, not the steps.
        everywhere = np.arange(len(states))
        seen = [i for i in range(2 * nv) if moved(everywhere, 1e-3 * way[i] * np.eye(2 * nv)[i]) != here]
        pending, rows = [everywhere], list[int]()
        while pending:
            part = pending.pop()
            if moved(part, 1e-3 * way) == here:
                continue
            rows += part.tolist() if part.size == 1 else []
            pending += [p for p in np.array_split(part, 2) if part.size > 1]
        out = np.zeros((len(states), 2 * nv))
        for k in rows:
            for i in seen:
                step = WIDTH * np.eye(2 * nv)[i]
                out[k, i] = (moved([k], step) - moved([k], -step)) / (2.0 * WIDTH)
        return out


def trajectory_gradient(rollout: Rollout, loss: Loss, wrt: Sequence[str]) -> TrajectoryGradient:
    """Return a loss of a rollout as a function of the rollout's parameters, with its gradient.

    Parameters
    ----------
    rollout
        A function of named parameters that makes a `RigidWorld`, puts it in its place and steps it; what it
        returns is not looked at. It is called several times. Controllers may look at `world.q_v()` and at
        the time, not remember, nor read contacts.
    loss
        A function of all states, q (n + 1, nq) [m, -, rad] and v (n + 1, nv) [m/s, rad/s] in Pinocchio's
        order, that returns a number.
    wrt
        Names of the parameters, numbers or arrays, that the gradient is by: whatever they change of masses,
        friction, restitution, a soft law, the start, torques, pushes. One with a row for each step moves
        that step alone, such as torques.

    Returns
    -------
    A function of the parameters that returns `LossGradient`; `.value` of them is the loss alone, `.jax` and
    `.torch` are functions of those of `wrt` in their order.

    Raises
    ------
    ProblemError
        When it is called: for parameters that change shapes, ground or dt, controllers that remember, random
        numbers, motors other than ideal, and explicit soft laws.
    NoSolution
        If a contact problem is not SOLVED.

    Examples
    --------
    The speed of a block that slides, v₀ - mu g t, whatever its mass:

    >>> from surefoot.worlds.rigid.bodies import box
    >>> from surefoot.worlds.rigid.rigid_world import RigidWorld
    >>> def slide(speed, mu, mass):
    ...     world = RigidWorld(box(mass), mu=mu, dt=5e-3)
    ...     world.reset(world.robot.nominal, np.array([speed, 0, 0, 0, 0, 0]))
    ...     for _ in range(20):
    ...         world.step(np.zeros(0))
    >>> reached = trajectory_gradient(slide, lambda q, v: v[-1, 0], wrt=["speed", "mu", "mass"])
    >>> found = reached(speed=1.0, mu=0.5, mass=2.0)
    >>> {name: round(slope, 3) + 0.0 for name, slope in found.gradient.items()}  # 1, -g t, 0
    {'speed': 1.0, 'mu': -0.981, 'mass': 0.0}
    """
    return TrajectoryGradient(rollout, loss, wrt)


def _arrays(states: list[State]) -> tuple[FloatArray, FloatArray]:
    """Return q (n + 1, nq) and v (n + 1, nv)."""
    return np.array([s.q for s in states]), np.array([s.v for s in states])
