"""The gradient of a loss of a rollout's states by what goes into its steps: in reverse, or by few, forwards.

With x the state (q, v, and what a step leaves to the next), p the parameters and w the gradient by x_k::

    w_N = ∂L/∂x_N,    w_k = ∂L/∂x_k + w_k+1 (∂f/∂x + ∂f/∂τ ∂τ/∂x)
    ∂L/∂p = w_0 ∂x_0/∂p + Σ w_k+1 (∂f/∂p + ∂f/∂τ ∂τ/∂p)

By no more numbers than the state has, it is cheaper to go forwards: how all states move with each parameter,
T_k+1 = ∂f/∂x T_k + ∂f/∂τ (∂τ/∂x T_k + ∂τ/∂p) + ∂f/∂p, and the loss along these motions, two looks each. On
the way back a loss of all states is looked at twice for every component of each of them.

∂f are a step's own derivative (`mechanics.dynamics.derivative.stages`), taken on the way; what the user's
functions do, ∂τ/∂x, ∂x₀/∂p, masses by p and so on, are differences of those functions alone, at the recorded
states (`recorder`): no step is taken for them. So a gradient costs a few rollouts, however many parameters
there are.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.mechanics import InputRates, PairDetection, State, StepArguments, Stepper, law_fields, stages_of
from surefoot.worlds.rigid.rollout_record import RecordedWorld, RolloutRecorder

WIDTH = 1e-6
"""Half of a difference, in units of what is moved where that is above one."""
SAME = 1e-12
"""How far apart two numbers may be that are the same [m, N m]."""

Run = Callable[..., RolloutRecorder]
"""Runs the rollout at parameters, in given states, as `RolloutRecorder` takes them."""


class Inputs(NamedTuple):
    """What a rollout put into its world: what it starts from, is made of, and the n steps' own.

    Attributes
    ----------
    start
        (2nv,) against the recorded start, in its tangent space.
    inertia, restitution, law
        (10 bodies,), (groups,) and (fields,); a group are contacts of the same two surfaces.
    each
        (n, joints + 3 + groups) torques, push and friction of every step.
    """

    start: FloatArray
    inertia: FloatArray
    restitution: FloatArray
    law: FloatArray
    each: FloatArray


class Backward:
    """The way back through a rollout: how what goes into the steps depends on parameters and states."""

    def __init__(
        self, run: Run, parameters: dict[str, Any], values: dict[str, FloatArray], taken: RolloutRecorder,
    ) -> None:  # fmt: skip
        assert taken.world is not None
        self.run, self.parameters, self.values, self.taken = run, parameters, values, taken
        self.world: RecordedWorld = taken.world
        self.model = self.world.model
        self.world.check_differentiable()
        self.foot = self.world.stepper.bodies.contacts.group
        self.group = self.foot if self.world.stepper.geometry is not None else 0 * self.foot
        self.here = self._inputs(taken)
        self.feedback = self._feedback()

    def _inputs(self, run: RolloutRecorder) -> Inputs:
        """Return what a run put into its world."""
        import pinocchio

        world, first = run.world, self.taken.states[0]
        assert world is not None
        law = world.stepper.options.soft
        inertia = [np.array(i.toDynamicParameters()) for i in list(world.model.inertias)[1:]]
        q = pinocchio.difference(self.model, first.q, run.start.q)
        mu, which = np.unique(run.mu, return_inverse=True)
        friction, restitution = np.stack([self._surfaces(world, m) for m in mu], axis=1)
        each = np.column_stack([np.array(run.torques).reshape(run.count, -1), run.pushes, friction[which]])
        return Inputs(
            np.concatenate([q, run.start.v - first.v]), np.concatenate(inertia), restitution[0],
            np.array([getattr(law, n) for n in law_fields(law)] if law is not None else []), each,
        )  # fmt: skip

    def _surfaces(self, world: RecordedWorld, mu: float) -> FloatArray:
        """Return friction and restitution (2, groups) of a world's contacts, on ground of friction `mu`."""
        found, stepper = self.world.stepper.bodies.contacts, world.stepper
        if stepper.geometry is None or not isinstance(found, PairDetection):
            return np.array([[mu], [stepper.options.restitution]])
        return found.mixed(stepper.geometry, mu, stepper.options.restitution)

    def _replay(self, states: list[State] | None = None, **changed: Any) -> Inputs:
        """Return what the rollout puts in when it is in given states, with some parameters changed."""
        run = self.run({**self.parameters, **changed}, states or self.taken.states, self.taken, not changed)
        assert run.world is not None
        if run.world.stepper is self.world.stepper:
            return self._inputs(run)
        first, options = self.taken.states[0], run.world.stepper.options
        a, b = (_shape(w.stepper, first) for w in (run.world, self.world))
        if a.shape != b.shape or np.abs(a - b).max(initial=0.0) > SAME or options.dt != self.world.dt:
            raise ProblemError(
                f"no gradient by {', '.join(changed)}: it changes shapes, ground or the step's length"
            )
        return self._inputs(run)

    def _shift_states(self, way: FloatArray, which: slice = slice(None)) -> list[State]:
        """Return the recorded states, those chosen moved along (2nv,)."""
        out, nv, moved = list(self.taken.states), self.model.nv, self.world.stepper.bodies.moved
        out[which] = [s._replace(q=moved(s.q, way[:nv]), v=s.v + way[nv:]) for s in out[which]]
        return out

    def _feedback(self) -> FloatArray | None:
        """Return how each step's torques, push and friction move with its state (n, joints + 4, 2nv)."""
        size = 2 * self.model.nv
        # Every other state is moved: what goes into the other steps must then stay as it is, or a controller
        # remembers.
        way = WIDTH * np.random.default_rng(0).normal(size=size)
        again = self._replay(self._shift_states(way, slice(0, None, 2)))
        change = np.abs(again.each - self.here.each).max(axis=1)
        others = max(np.abs(a - b).max(initial=0.0) for a, b in zip(again[:4], self.here[:4], strict=True))
        if max(change[1::2].max(initial=0.0), others) > SAME:
            raise ProblemError(
                "this rollout does something else in the same states: it may look at its parameters, the "
                "time and the state, not at random numbers, contact forces, or what a controller remembers"
            )
        if not change.any():
            return None
        seen = (again.each - self.here.each)[::2] / WIDTH, way / WIDTH
        return self._by_joints(size, *seen) if self.world.robot.joints else self._by_states(np.eye(size))

    def _by_states(self, ways: FloatArray) -> FloatArray:
        """Return how what goes into the steps moves with each of (c, 2nv) motions of the states."""
        ends = [self._replay(self._shift_states(WIDTH * way)).each for way in ways]
        return np.stack([(end - self.here.each) / WIDTH for end in ends], axis=2)

    def _by_joints(self, size: int, seen: FloatArray, way: FloatArray) -> FloatArray:
        """Return the same for every component; at once, where a joint's torque looks at that joint alone.

        Every other step's (., joints + 4) is `seen` to move so along the motion `way` (2nv,).
        """
        joints, nv, base = self.world.robot.joints, self.model.nv, self.world.robot.base_dof
        # All joints at once, then all speeds: two replays instead of 2 nv. Whether the assumption holds is
        # judged by the random motion.
        own = np.eye(size)[base : base + joints], np.eye(size)[nv + base : nv + base + joints]
        both = self._by_states(np.array([e.sum(axis=0) for e in own]))
        out = np.zeros((len(both), both.shape[1], size))
        for k, at in enumerate((base, nv + base)):
            out[:, np.arange(joints), at + np.arange(joints)] = both[:, :joints, k]
        off = np.abs(seen - out[::2] @ way).max()
        return out if off <= 1e-5 * np.abs(out).max() else self._by_states(np.eye(size))

    def _rates(self) -> tuple[list[tuple[str, Any]], list[Inputs]]:
        """Return for each direction which entries of which parameter it is, and the rates of what goes in.

        A parameter with a row for every step that moves that step alone moves all its rows at once.
        """
        where, rates, n = list[tuple[str, Any]](), list[Inputs](), self.taken.count
        for name, value in self.values.items():
            flat = value.reshape(n, -1) if value.ndim and len(value) == n > 1 else None
            if flat is not None and not self._stepwise(name, value):
                flat = None
            count = value.size if flat is None else flat.shape[1]
            for j in range(count):
                entry = np.unravel_index(j, value.shape) if flat is None else j
                e = np.zeros(value.shape)
                (e if flat is None else e.reshape(n, -1))[entry if flat is None else (slice(None), j)] = 1.0
                width = WIDTH * max(1.0, float(np.abs(value * e).max()))
                try:
                    moved = self._replay(None, **{name: value + width * e})
                except ProblemError:  # at the end of its range, as a restitution of one
                    width = -width
                    moved = self._replay(None, **{name: value + width * e})
                where.append((name, entry))
                rates.append(Inputs(*((b - a) / width for a, b in zip(self.here, moved, strict=True))))
        return where, rates

    def _stepwise(self, name: str, value: FloatArray) -> bool:
        """Return whether every row of a parameter moves its own step alone."""
        other = value.copy()
        other[::2] += WIDTH
        moved = self._replay(None, **{name: other})
        apart = [a - b for a, b in zip(moved, self.here, strict=True)]
        return not any(a.any() for a in apart[:4]) and not apart[4][1::2].any()

    def slopes(
        self, by_states: Callable[[], FloatArray], along: Callable[[FloatArray], FloatArray]
    ) -> dict[str, Any]:
        """Return the gradient by every parameter.

        Parameters
        ----------
        by_states
            Returns the gradient of the loss by the states (n + 1, 2nv).
        along
            Returns the rates (c,) of the loss along c motions of them (n + 1, 2nv, c).
        """
        where, rates = self._rates()
        fixed = [np.array([getattr(r, name) for r in rates]).T for name in ("inertia", "restitution", "law")]
        each = np.array([r.each for r in rates]).transpose(1, 2, 0)
        start = np.array([r.start for r in rates]).T
        out = {n: np.zeros(v.shape) for n, v in self.values.items()}
        if len(where) > 2 * self.model.nv or any(isinstance(entry, int) for _, entry in where):
            whole = self._back_through(by_states(), where, (start, each, fixed), out)
        else:
            whole = along(self._motions(start, each, fixed))
        for (name, entry), slope in zip(where, whole, strict=True):
            if not isinstance(entry, int):
                out[name][entry] += slope
        return {name: float(v) if v.ndim == 0 else v for name, v in out.items()}

    def _motions(self, start: FloatArray, each: FloatArray, fixed: list[FloatArray]) -> FloatArray:
        """Return how all states move with each of c parameters (n + 1, 2nv, c)."""
        left, out = np.zeros((3 * len(self.foot), start.shape[1])), [start]
        for k, own in enumerate(each):
            into = own if self.feedback is None else own + self.feedback[k] @ out[-1]
            state, _, left = np.split(
                self._ahead(k, out[-1], left, into, fixed), [len(start), len(start) + len(left)]
            )
            out.append(state)
        return np.array(out)

    def _back_through(
        self, loss_rates: FloatArray, where: list[tuple[str, Any]],
        rates: tuple[FloatArray, FloatArray, list[FloatArray]], out: dict[str, FloatArray],
    ) -> FloatArray:  # fmt: skip
        """Return the gradient by the parameters (c,) of the whole rollout; write that by those of steps."""
        start, each, fixed = rates
        weight, left = loss_rates[-1], np.zeros(3 * len(self.foot))
        whole, n, size, before = np.zeros(len(where)), len(each), weight.size, weight.size + left.size
        eye = np.eye(before, before + len(where))
        fixed = [np.hstack([np.zeros((len(f), before)), f]) for f in fixed]
        for k in reversed(range(n)):
            into = np.hstack([np.zeros((len(each[k]), before)), each[k]])
            if self.feedback is not None:
                into[:, :size] = self.feedback[k]
            behind = self._ahead(k, eye[:size], eye[size:], into, fixed)
            # Rows are state, impulses and leaving: the loss looks at no impulses, the next step at what this
            # one leaves.
            back = np.concatenate([weight, 0.0 * left, left]) @ behind
            state, left, own = np.split(back, [size, before])
            whole += own
            for g, (name, entry) in zip(own, where, strict=True):
                if isinstance(entry, int):
                    out[name].reshape(n, -1)[k, entry] += g
            weight = state + loss_rates[k]
        return np.asarray(whole + weight @ start)

    def _ahead(
        self, k: int, state: FloatArray, left: FloatArray, into: FloatArray, fixed: list[FloatArray]
    ) -> FloatArray:
        """Return the rates (2nv + 6p, c) behind a step for c of its state, of what was left, and put in."""
        taken, stepper, joints, nv = self.taken, self.world.stepper, self.world.robot.joints, len(state) // 2
        push = taken.pushes[k] if taken.pushes[k].any() else None
        here, behind = taken.states[k], taken.count - k
        kept, given = behind <= len(taken.steps), (here, taken.torques[k], push, taken.mu[k])
        step = taken.steps[-behind] if kept else stepper.step(*given)
        stages = stages_of(stepper, StepArguments(*given, 0.0, step))
        both: bool | None = False
        for response, near in stages.responses:
            response.regular, foot = True, self.foot[near]
            if foot.size > np.unique(foot).size:  # redundant: signs of their gaps would pull them apart
                both = None
        heard = step.impact is not None and step.impact.velocities is not step.impact.leaving
        inertia, restitution, law = (f if f.any() else None for f in fixed)
        bounce = None if restitution is None else restitution[self.group]
        return stages.through(InputRates(
            state[:nv], state[nv:], into[:joints], into[joints + 3 :][self.group], into[joints : joints + 3],
            left if heard else 0.0 * left, inertia, both, restitution=bounce, law=law,
        ))  # fmt: skip


def _shape(stepper: Stepper, state: State) -> FloatArray:
    """Return all numbers of what touches: spheres on the ground at a state, and solids."""
    contacts, geometry = stepper.contacts(state), stepper.geometry
    spheres = len(stepper.bodies.contacts.points)
    parts = [contacts.gaps[:spheres], contacts.positions[:spheres].ravel()]
    for s in () if geometry is None else geometry.solids:
        parts += [np.array([s.joint, s.shape.radius]), s.shape.core, s.rotation.ravel(), s.position]
    return np.concatenate(parts)
