"""Shooting by Gauss-Newton DDP with bounded torques: hard contact forward, smoothed backward.

Every iteration differentiates the knots' steps where contacts lie on the central path with parameter κ
(`Knot.derivative`), runs a Riccati recursion over the linearised motion (`riccati`) and searches along its
step on the exact cost: the motion tried is always one of exact steps, with rigid contact and exact Coulomb
friction. κ goes down by stages. After [1]_ (hard contact forward, relaxed gradients backward) and [2]_
(bounds).

Where the smoothed slope does not lead downhill on the exact cost the damping is raised; a stage ends when no
step helps, or when the cost stands still.

References
----------
.. [1] G. Kim, D. Kang, J.-H. Kim, S. Hong, H.-W. Park, "Contact-implicit model predictive control:
   controlling diverse quadruped motions without pre-planned contact modes or trajectories", IJRR 2024, arXiv
   2312.08961.
.. [2] Y. Tassa, N. Mansard, E. Todorov, "Control-limited differential dynamic programming", ICRA 2014.
"""

from __future__ import annotations

import numpy as np

from surefoot.base.arrays import FloatArray, finite_array
from surefoot.base.errors import ProblemError
from surefoot.contact import Status
from surefoot.mechanics import velocity_of_way
from surefoot.motion.planning.shooting.iteration import ShootingIteration
from surefoot.motion.planning.shooting.shooting_problem import (
    ShootingProblem,
    ShootingResult,
    ShootingSettings,
)
from surefoot.motion.planning.trajectory import TOLERANCE, rollout

STANDING_STILL = 3
"""Iterations without progress after which a stage ends."""


class Shooting:
    """Finds motions of a problem; keeps its arrays from one solve to the next.

    Parameters
    ----------
    problem
        See `ShootingProblem`.

    Examples
    --------
    >>> from surefoot.motion.planning.shooting.costs import Costs, StateCost
    >>> from surefoot.mechanics.robot import load_robot, place
    >>> robot = load_robot("go2")
    >>> costs = Costs(StateCost(np.r_[np.full(18, 10.0), np.full(18, 0.1)], q=place(robot)))
    >>> found = Shooting(ShootingProblem(robot, costs, knots=10)).solve(place(robot), np.zeros(18))
    >>> found.status.value, found.law_residual < 1e-8
    ('solved', True)
    """

    def __init__(self, problem: ShootingProblem) -> None:
        self.problem = problem
        self.iteration = ShootingIteration(problem)

    def solve(
        self,
        q: FloatArray,
        v: FloatArray,
        torques: FloatArray | None = None,
        settings: ShootingSettings | None = None,
    ) -> ShootingResult:
        """Return the motion found from a state.

        Parameters
        ----------
        q, v
            (nq,), (nv,) the first state.
        torques
            (N, m) to start from [N m]; None for none.
        settings
            See `ShootingSettings`.

        Raises
        ------
        ProblemError
            For arrays of the wrong shape, or not finite, and a guess whose steps cannot be solved.
        """
        settings, iteration = settings or ShootingSettings(), self.iteration
        iteration.damping = settings.damping
        self._start(q, v, torques)
        costs: list[float] = [iteration.now.cost]
        ended = Status.STALLED
        for stage, smoothing in enumerate(settings.smoothings):
            ended = self._descend(smoothing, settings, costs, stage == len(settings.smoothings) - 1)
            if ended is Status.MAX_ITERATIONS:
                break
        iteration.damping = settings.damping
        if iteration.differentiate(smoothing):  # gains of what was found, not of the last step tried
            iteration.backward()
        return self._result(costs, ended)

    def _start(self, q: FloatArray, v: FloatArray, torques: FloatArray | None) -> None:
        """Put the guess into the iteration."""
        p, model = self.problem, self.problem.robot.model
        N, nv, m = p.knots, int(model.nv), p.robot.joints
        q, v = p.robot.configuration(q), finite_array("v", v, (nv,))
        self._first = v
        if p.momentum:
            v = velocity_of_way(model, q, v, p.dt)
        u = np.zeros((N, m)) if torques is None else finite_array("torques", torques, (N, m))
        iteration = self.iteration
        iteration.gains[:] = iteration.steps[:] = 0.0
        iteration.now.torques[:] = u
        iteration.now.q[:], iteration.now.v[:] = q, v
        if iteration.choose([(iteration.policy, 0.0)], np.inf) < 0:
            raise ProblemError("the guess cannot be stepped: a contact problem of it has no solution found")

    def _descend(
        self, smoothing: float, settings: ShootingSettings, costs: list[float], last: bool
    ) -> Status:
        """Iterate at one smoothing until the cost stands still."""
        iteration, still = self.iteration, 0
        while len(costs) <= settings.max_iterations:
            before = iteration.now.cost
            taken = iteration.differentiate(smoothing) and self._step(settings)
            now = iteration.now
            costs.append(now.cost)
            if not taken:
                return Status.STALLED
            change = before - now.cost
            still = still + 1 if change <= settings.tol * abs(before) else 0
            if still >= (STANDING_STILL if last else 1):
                return Status.SOLVED
        return Status.MAX_ITERATIONS

    def _step(self, settings: ShootingSettings) -> bool:
        """Take one step, with as much damping as it needs; return whether one was found."""
        iteration = self.iteration
        while iteration.damping <= settings.most:
            if iteration.backward():
                share = iteration.search(settings.shares)
                if share > 0.0:
                    # As with a trust region: less damping where the full step held what the model promised,
                    # more where only a small part of it did.
                    factor = 0.2 if share == 1.0 else (1.0 if share >= 0.25 else 4.0)
                    iteration.damping = max(factor * iteration.damping, settings.least)
                    return True
            iteration.damping = max(10.0 * iteration.damping, settings.least)
        iteration.damping = settings.damping
        return False

    def _result(self, costs: list[float], ended: Status) -> ShootingResult:
        """Return what was found: the rollout of the torques, judged."""
        iteration, p = self.iteration, self.problem
        now = iteration.now
        trajectory = rollout(p.robot, now.q[0], self._first, now.torques, dt=p.dt, mu=p.mu, terrain=p.terrain)
        distance = 0.0 if p.goal is None else float(p.goal.distance(trajectory))
        status: Status = Status.STALLED if ended is Status.SOLVED else ended
        lawful = trajectory.lawful and trajectory.law_residual <= TOLERANCE
        if lawful and distance <= (0.0 if p.goal is None else p.goal.tolerance):
            status = Status.SOLVED
        return ShootingResult(
            trajectory, iteration.gains.copy(), status, now.cost, tuple(costs), len(costs) - 1, distance,
        )  # fmt: skip
