"""The stages of a step, taken once more with their derivatives; see `derivative`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.numerics.vectors import finite_vector
from surefoot.base.spatial import skew
from surefoot.mechanics.dynamics import arithmetic
from surefoot.mechanics.dynamics.derivative.contact_problem import Response
from surefoot.mechanics.dynamics.derivative.flow import Dynamics, FlowDerivative
from surefoot.mechanics.dynamics.derivative.free_body_rates import FreeDynamics, FreeFlowDerivative
from surefoot.mechanics.dynamics.derivative.impact import Exchange, InputRates
from surefoot.mechanics.dynamics.derivative.points import GroundRates, PairRates
from surefoot.mechanics.dynamics.detection import Contacts
from surefoot.mechanics.dynamics.free_bodies import FreeFlight
from surefoot.mechanics.dynamics.free_motion import FreeMotion, moved
from surefoot.mechanics.dynamics.impacts import Tally, finite_problem
from surefoot.mechanics.dynamics.state import Impact, State, Step, grown
from surefoot.mechanics.dynamics.stepper import PROJECTIONS, Stepper


class StepArguments(NamedTuple):
    """A step to be differentiated: the arguments of `Stepper.step`, and the smoothing.

    `step` is its outcome, None where it is to be taken; it may be shorter than the others.
    """

    state: State
    torques: FloatArray
    push: FloatArray | None
    mu: float
    smoothing: float
    step: Step | None = None


DERIVATIVES: dict[type, tuple[Any, Any]] = {
    FreeMotion: (FlowDerivative, Dynamics), FreeFlight: (FreeFlowDerivative, FreeDynamics)
}  # fmt: skip
"""The derivatives of motion and of inverse dynamics, by kind of the motion."""


class Work:
    """What derivatives of one stepper share: those of its motions, and how columns belong to joints."""

    def __init__(self, stepper: Stepper) -> None:
        bodies = stepper.bodies
        flow, dynamics = DERIVATIVES[type(bodies.flight)]
        self.flight, self.coasting = flow(bodies.flight), flow(bodies.coasting)
        self.heavy, self.weightless = dynamics(bodies.flight), dynamics(bodies.coasting)
        joints = list(bodies.model.joints)[1:]
        self.first: IntArray = np.concatenate([np.full(j.nv, j.idx_v, dtype=np.int64) for j in joints])


class Coast(NamedTuple):
    """A piece of free motion."""

    flow: FlowDerivative
    q: FloatArray
    v: FloatArray
    seconds: float
    effort: FloatArray | None

    @property
    def pace(self) -> FloatArray:
        """How fast (q, v) goes on at the end of it: (2nv,) per second."""
        end = moved(self.flow.motion, self.q, self.v, self.seconds, self.effort)
        return np.concatenate([end.v, self.flow.motion.acceleration(end.q, end.v, self.effort)])


class Stages:
    """Takes a step and keeps where each of its stages began.

    Raises
    ------
    NoSolution
        If a contact problem of the step is not SOLVED.
    ProblemError, SimulationError
        As `Stepper.step`.
    """

    def __init__(self, stepper: Stepper, request: StepArguments) -> None:
        self.stepper, self.request = stepper, request
        self._work: Work = stepper.kept.get(Work) or stepper.kept.setdefault(Work, Work(stepper))
        self.arrival: Exchange | None = None
        self.projections: list[Exchange] = []
        self.effort = np.zeros(stepper.bodies.model.nv)
        self.effort[stepper.motors] = finite_vector("torques", request.torques, stepper.robot.joints)
        state, push, mu = request.state, request.push, request.mu
        self.step: Step = request.step or stepper.step(state, request.torques, push, mu)
        if request.smoothing > 0.0 and (self.step.pieces or self.step.impact is None):  # all take part
            retake = stepper.take_first_order if stepper.options.order == 1 else stepper.meet_ground
            self.step = retake(state, self.effort, push, mu)
        self.dt = self.step.dt
        self._retrace(self.step.impact)

    speed: FloatArray | None = None
    """Velocity (nv,) at which the bodies' own motion makes forces in its exchanges; None where none does."""

    def _retrace(self, impact: Impact | None) -> None:
        """Find where each stage of the step began."""
        stepper, request, work = self.stepper, self.request, self._work
        state, mu, dt = request.state, request.mu, self.dt
        if impact is None:
            self.coasts = [Coast(work.flight, state.q, state.v, dt, self.effort)]
            return
        v = state.v
        if (stopped := stepper.stopped(state, mu, Tally())) is not None:
            seen = self._seen(state.q)
            self.arrival = self._exchange(work.weightless, 1.0, stopped, seen, 0.5 * dt, stepper.options.pull)
            v = stopped.after
        self.coasts = [Coast(work.coasting, state.q, v, 0.5 * dt, None)]
        self._push_out(impact)
        seen = self._seen(impact.q)
        if request.smoothing > 0.0:
            impact = self._exchange_on_path(impact, seen)
        pull = stepper.options.pull
        self.main = self._exchange(work.heavy, dt, impact, seen, dt, pull, request.smoothing)
        if (memory := state.memory) is not None:
            points, surfaces = len(self.main.foot), stepper.surfaces(mu)
            last, leaving = (grown(a, points) for a in (memory.impulses, memory.leaving))
            if surfaces is not None:  # see `PairMeeting.collide`
                last = np.where(surfaces.on[:, None], last, 0.0)
            self.main = replace(self.main, last=last, leaving=leaving)
        self.coasts.append(Coast(work.coasting, impact.q, impact.after, 0.5 * dt, None))

    def _push_out(self, impact: Impact) -> None:
        """Find the motions out of the ground that the step took."""
        stepper, first = self.stepper, self.coasts[0]
        if stepper.options.stabilisation != "projection":
            return
        rate = self.request.state.rate if first.v is self.request.state.v else None
        ahead = stepper.bodies.coasting.advance(first.q, first.v, first.seconds, None, rate)
        assert ahead is not None  # the step went through here
        q = ahead.q
        for _ in range(PROJECTIONS):
            if np.array_equal(q, impact.q):
                return
            seen = self._seen(q)
            stepper.bodies.weigh(q)
            pushed = stepper.pushed_out(q, seen)
            if pushed is None:
                return
            self.projections.append(self._exchange(self._work.weightless, 1.0, pushed, seen, 1.0, 1.0))
            q = stepper.bodies.moved(q, pushed.after)

    def _seen(self, q: FloatArray) -> Contacts:
        """Return the contacts at q, as arrays of their own."""
        return self.stepper.contacts(State(q, self.request.state.v))

    def _exchange(
        self, dynamics: Dynamics, span: float, impact: Impact, seen: Contacts, horizon: float,
        pull: float, smoothing: float = 0.0,
    ) -> Exchange:  # fmt: skip
        """Return an exchange of impulses with what its derivative needs."""
        stepper, bodies, first = self.stepper, self.stepper.bodies, self._work.first
        bodies.weigh(impact.q)
        twists = np.ascontiguousarray(bodies.contacts.twists(impact.q).T)
        seen, count = Contacts(seen.gaps, seen.positions, seen.frames, seen.J), len(seen.gaps)
        surfaces = stepper.surfaces(self.request.mu)
        shape = stepper, bodies.contacts.points, first, twists, seen
        ground = GroundRates(*shape) if surfaces is None else PairRates(*shape, impact.near)
        bounce = np.full(count, stepper.options.restitution) if surfaces is None else surfaces.restitution
        impulses, leaving = (grown(a, count) for a in (impact.impulses, impact.leaving))
        means = leaving if impact.velocities is impact.leaving else grown(impact.velocities, count)
        impact = impact._replace(impulses=impulses, leaving=leaving, velocities=means)
        nothing = np.zeros(impulses.shape)
        response = None if impact.solution is None else Response(impact.solution, smoothing)
        return Exchange(
            dynamics, impact, seen, ground, bodies.contacts.group, bounce, bodies.light, span,
            bodies.base_rotation.copy(), np.zeros_like(impact.before) if self.speed is None else self.speed,
            nothing, nothing, horizon, stepper.options, pull, response,
        )  # fmt: skip

    def _exchange_on_path(self, impact: Impact, seen: Contacts) -> Impact:
        """Return the exchange on the central path, with all contact points."""
        stepper, every = self.stepper, np.arange(len(seen.gaps))
        if not every.size:
            return impact
        stepper.bodies.weigh(impact.q)
        arriving, mu = impact[:3], self.request.mu
        rows, G, g = stepper.meeting(*arriving, seen, self.dt, mu, Tally()).matrices(every)
        swerve = impact.velocities - impact.leaving
        problem = finite_problem(G, g + swerve.ravel(), mu, stepper.options.problem_law)
        solution = stepper.solve(problem, impact.impulses)
        forces = Response(solution, self.request.smoothing).forces
        after = arithmetic.apply_impulses(stepper.bodies.L, rows, forces.ravel(), impact.free)
        leaving = seen.velocities(after)
        means = leaving if impact.velocities is impact.leaving else leaving + swerve
        return impact._replace(
            after=after, near=every, rows=rows, impulses=forces, leaving=leaving, velocities=means,
            solution=solution,
        )  # fmt: skip

    @property
    def responses(self) -> list[tuple[Response, IntArray]]:
        """The contact problems of impulses, in order, and which contact points (k,) are in them."""
        found = [] if self.step.impact is None else [self.arrival, self.main]
        return [(e.response, e.impact.near) for e in found if e is not None and e.response is not None]

    def _free_motion_rates(
        self, k: int, T: FloatArray, more: FloatArray | None, inertia: FloatArray | None
    ) -> FloatArray:
        """Return the rates of (q, v) (2nv, c) after a piece of free motion."""
        c = self.coasts[k]
        return c.flow.of(T, c.q, c.v, c.seconds, c.effort, more, inertia)

    def through(self, given: InputRates) -> FloatArray:
        """Return the rates (2nv + 6p, c) of q, v, impulses and leaving for those of what goes in."""
        n, seconds, inertia = len(given.v), given.seconds, given.inertia
        T, impulses = np.vstack([given.q, given.v]), np.zeros_like(given.leaving)
        effort = np.zeros_like(given.v)
        effort[self.stepper.motors] = given.torques
        if self.step.impact is None:
            return np.vstack([self._free_motion_rates(0, T, effort, inertia), impulses, impulses])
        if self.arrival is not None:
            after, _, got = self.arrival.through(given._replace(leaving=impulses, seconds=None))
            T, impulses = np.vstack([T[:n], after]), impulses + got
        T = self._free_motion_rates(0, T, None, inertia)
        if seconds is not None:
            T += np.outer(self.coasts[0].pace, 0.5 * seconds)
        for out in self.projections:
            T = self._push_out_rates(out, T, given)
        effort = self.dt * (effort + self._pushing(T[:n], given.push))
        if seconds is not None:
            effort += np.outer(self.main.force, seconds)
        after, left, got = self.main.through(given._replace(q=T[:n], v=T[n:]), effort)
        T = self._free_motion_rates(1, np.vstack([T[:n], after]), None, inertia)
        if seconds is not None:
            T += np.outer(self.coasts[1].pace, 0.5 * seconds)
        return np.vstack([T, impulses + got, left])

    def _push_out_rates(self, out: Exchange, T: FloatArray, given: InputRates) -> FloatArray:
        """Return the rates of (q, v) after a motion out of the ground."""
        import pinocchio

        n = len(T) // 2
        rates = given._replace(q=T[:n], v=0.0 * T[n:], mu=0.0 * given.mu, leaving=0.0 * given.leaving)
        moved = out.through(rates._replace(seconds=None, restitution=None, law=None))[0]
        model, q, way = self.stepper.bodies.model, out.impact.q, out.impact.after
        by_q, by_way = pinocchio.dIntegrate(model, q, way)
        return np.vstack([by_q @ T[:n] + by_way @ moved, T[n:]])

    def _pushing(self, q: FloatArray, push: FloatArray) -> FloatArray:
        """Return the rates (nv, c) of the generalised force of the push, of q (nv, c) and push (3, c)."""
        out = np.zeros_like(q)
        bodies = self.stepper.bodies
        if not self.stepper.robot.floating:
            return out
        turn = self.main.base_rotation
        local = turn.T @ push
        if self.request.push is not None:
            local = local + skew(turn.T @ self.request.push) @ q[3:6]
        out[:3], out[3:6] = local, skew(bodies.lever) @ local
        return out
