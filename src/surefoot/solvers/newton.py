"""Semismooth Newton on the Alart-Curnier equations, as a solver of its own: see `newton_step` for the method.

Up to 45 contacts it is the compiled call of `auto`, with one sweep before the first step and twice as many
before each further attempt; above, steps by sparse factorisation with one sweep before each attempt.

Source and limits: see `newton_step` and `newton_sparse`.
"""

from __future__ import annotations

from surefoot.arrays import FloatArray
from surefoot.contact.problem import ContactProblem
from surefoot.contact.solution import Status
from surefoot.kernels import working_time
from surefoot.solvers.compiled import SOON, UNBOUNDED, attempt
from surefoot.solvers.newton_sparse import BlockNewton
from surefoot.solvers.newton_step import SHARES_MANY
from surefoot.solvers.solver import Answer, SolverSettings, register, start_forces

ROUNDS = 40
"""Attempts on many contacts, a sweep before each."""


@register("newton", bilateral=True)
def solve_newton(problem: ContactProblem, settings: SolverSettings, warm_start: FloatArray | None) -> Answer:
    """Solve either law by semismooth Newton as far as it gets from a (n, 3) warm start.

    An iteration is a Newton step or a sweep.
    """
    limit = settings.max_iterations
    found = attempt(problem, settings.tol, limit, settings.max_time, warm_start, SOON)
    if found is not None:
        record, used, _, fits = found
        stop = Status.STALLED
        if used >= fits:
            stop = Status.MAX_ITERATIONS if fits == limit else Status.MAX_TIME
        return Answer(record[: problem.contacts], used, stop)
    forces = start_forces(problem, warm_start)
    end = working_time() + settings.max_time
    most = UNBOUNDED if limit is None else limit
    newton, done = BlockNewton(problem, settings.tol, end), 0
    for turn in range(ROUNDS):
        if done >= most or working_time() > end:
            break
        done += newton.sweep(forces, 1)
        steps, relative = newton.run(forces, min(30, most - done), SHARES_MANY[turn % 3])
        done += steps
        if relative <= settings.tol:
            break
    stop = Status.MAX_ITERATIONS if done >= most else Status.STALLED
    return Answer(forces.reshape(-1, 3), done, Status.MAX_TIME if working_time() > end else stop)
