"""`surefoot bench walk`: the MPC step against other solvers, in the same run and at the same accuracy.

Every method is given the same recorded inputs (`mpc_scenes`). Our time is the whole call from Python,
building the model included; a rival's time is its own update and solve, its matrices being ready. Each rival
first runs a stretch of the inputs in all its forms (condensed and sparse, warm and cold) from loose to tight
tolerances, by eighths of a decade; the fastest form whose forces come within `ACCURACY` of its own exact
optimum is then measured on all inputs, at a tighter tolerance if it needs one there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from benchmarks.problems.judge import STEPS_PER_DECADE, coarsest
from benchmarks.problems.walking import TICK, MpcInput, MpcScene, choose_scenes, controller, record
from benchmarks.timing import Timing, best_of, one_core
from benchmarks.walk import rivals as mpc_rivals
from benchmarks.walk.horizon import HorizonProgram, horizon_program
from benchmarks.walk.rivals import Rival, Variant
from benchmarks.walk.steps import StepRow, measure_steps
from surefoot.base.arrays import FloatArray
from surefoot.motion.control import mpc_model
from surefoot.motion.control.mpc import ConvexMpc

ACCURACY = 0.1
"""Distance of all forces of the horizon together to the method's own optimum [N], in 95 of 100 inputs."""
REFERENCE_TOLERANCE = 1e-11
TUNING_INPUTS = 25
LONG = 20
"""Steps of a horizon above which references come from sparse matrices, and tuning sees fewer inputs."""
PASSES = 3
"""Each input is timed this often, and the best time counts: the rest is other work on the machine."""


@dataclass(frozen=True)
class MpcRow:
    """One method on one scene.

    Attributes
    ----------
    scene, method, variant
        Who and how.
    timing
        Wall time per call [s].
    ratio
        Median time over ours.
    error
        95th percentile of the distance to the method's own optimum, all forces together [N].
    first_error
        95th percentile of the distance of the first step's forces to the optimum on exact cones [N].
    violation
        Largest force outside an exact cone or a normal bound [N].
    lost
        Mean share of the friction left unused by contacts that use all of it at the exact optimum; NaN if
        none does.
    cost
        Cost above that of the exact optimum, summed over all calls, as a share of it.
    accurate
        Whether `error` is within `ACCURACY`.
    """

    scene: str
    method: str
    variant: str
    timing: Timing
    ratio: float
    error: float
    first_error: float
    violation: float
    lost: float
    cost: float
    accurate: bool


@dataclass(frozen=True)
class WalkBench:
    """All rows, the calls of a real walk, and the settings they were measured with."""

    rows: list[MpcRow]
    steps: list[StepRow]
    horizon: int
    calls: int


def measure(
    names: Sequence[str] | None = None,
    calls: int = 150,
    horizon: int = 10,
    robots: Sequence[str] = ("go2",),
    on_progress: Callable[[float], None] | None = None,
) -> WalkBench:
    """Measure all methods on the named scenes (all for None), and walking robots' own calls.

    Raises
    ------
    ProblemError
        For an unknown scene.
    ModelError
        For an unknown robot.
    MissingExtra
        If a rival, or what the robots need, is not installed.
    """
    scenes = choose_scenes(names)
    mpc_rivals.rivals()
    rows: list[MpcRow] = []
    for k, scene in enumerate(scenes):

        def show(part: float, before: int = k) -> None:
            if on_progress is not None:
                on_progress((before + part) / len(scenes))

        rows += measure_scene(scene, calls, horizon, show)
    steps = [row for robot in robots for row in measure_steps(robot)]
    return WalkBench(rows, steps, horizon, calls)


def measure_scene(
    scene: MpcScene, calls: int, horizon: int = 10, on_progress: Callable[[float], Any] | None = None
) -> list[MpcRow]:
    """Return our row and all rivals' rows for one scene."""
    inputs = record(scene, calls, horizon)
    mpc = controller(scene, horizon, tol=ACCURACY)
    programs = [horizon_program(mpc, *given) for given in inputs]
    exact = _references(mpc, programs, None)
    timing, forces = _time(_ours(mpc), list(zip(inputs, programs, strict=True)))
    rows = [
        _row(
            scene, "surefoot, exact cones", "whole call", timing, timing, forces, exact, mpc, programs, exact
        )
    ]
    optima: dict[int | None, list[FloatArray]] = {None: exact}
    rivals = mpc_rivals.rivals()
    for k, rival in enumerate(rivals):
        if rival.facets not in optima:
            optima[rival.facets] = _references(mpc, programs, rival.facets)
        own = optima[rival.facets]
        variant, other, forces = _best(rival, mpc, programs, own)
        rows.append(_row(scene, rival.name, str(variant), other, timing, forces, own, mpc, programs, exact))
        if on_progress is not None:
            on_progress((k + 1) / len(rivals))
    return rows


def _ours(mpc: ConvexMpc) -> Callable[[tuple[MpcInput, HorizonProgram]], FloatArray]:
    """Return our call; the forces are picked in the program's order (a microsecond of ours too)."""

    def call(item: tuple[MpcInput, HorizonProgram]) -> FloatArray:
        given, program = item
        mpc.shift(TICK)
        return np.asarray(mpc.solve(*given).forces[program.step, program.foot])

    return call


def _references(mpc: ConvexMpc, programs: list[HorizonProgram], facets: int | None) -> list[FloatArray]:
    """Return the optimal forces for a kind of cone, by Clarabel at its tightest."""
    out = []
    for program in programs:
        packed = mpc_rivals.matrices(mpc, program, facets, sparse=mpc.horizon > LONG, dense=False)
        out.append(mpc_rivals.solve_exact(packed, REFERENCE_TOLERANCE))
    return out


def _best(
    rival: Rival, mpc: ConvexMpc, programs: list[HorizonProgram], optima: list[FloatArray]
) -> tuple[Variant, Timing, list[FloatArray]]:
    """Return the fastest accurate way to run a rival, its time and its forces."""
    count = TUNING_INPUTS if mpc.horizon <= LONG else TUNING_INPUTS * LONG // (5 * mpc.horizon)
    first = max(len(programs) // 2 - count // 2, 0)
    some = slice(first, first + count)
    trials: list[Trial] = []
    for form in rival.forms:
        packed = [rival.pack(mpc, program, form) for program in programs[some]]
        for warm in rival.warm:
            tried = partial(_try, rival, form, warm, packed, optima[some], 1)
            trials.append(_loosest(tried))
    finals: list[Trial] = []
    for trial in sorted(trials, key=lambda t: (t.error > ACCURACY, t.timing.median)):
        form, warm, tol = trial.variant.form, trial.variant.warm, trial.variant.tol
        packed = [rival.pack(mpc, program, form) for program in programs]
        while tol >= 0.99 * 10.0 ** mpc_rivals.DECADES[-1]:
            finals.append(_try(rival, form, warm, packed, optima, PASSES, tol))
            if finals[-1].error <= ACCURACY:
                return finals[-1].variant, finals[-1].timing, finals[-1].forces
            tol *= 10.0 ** (-1.0 / STEPS_PER_DECADE)
    best = min(finals, key=lambda t: t.error)
    return best.variant, best.timing, best.forces


class Trial(NamedTuple):
    """One way to run a rival, and what came of it."""

    error: float
    variant: Variant
    timing: Timing
    forces: list[FloatArray]


def _try(
    rival: Rival, form: str, warm: bool, packed: list[Any], optima: list[FloatArray], passes: int, tol: float
) -> Trial:
    """Run a rival on packed programs."""
    variant = Variant(form, warm, tol)
    timing, forces = _time(rival.make(variant), packed, passes)
    return Trial(_error(forces, optima), variant, timing, forces)


def _loosest(tried: Callable[[float], Trial]) -> Trial:
    """Return the trial of the loosest tolerance that is accurate, or the most accurate one."""
    seen: list[Trial] = []

    def attempt(tol: float) -> Trial | None:
        seen.append(tried(tol))
        return seen[-1] if seen[-1].error <= ACCURACY else None

    return coarsest(attempt, decades=mpc_rivals.DECADES) or min(seen, key=lambda t: t.error)


def _error(forces: list[FloatArray], optima: list[FloatArray]) -> float:
    """Return the 95th percentile of the distance to the optima [N]."""
    return _quantile([_distance(f, o) for f, o in zip(forces, optima, strict=True)])


def _time(
    call: Callable[[Any], FloatArray], items: Sequence[Any], passes: int = PASSES
) -> tuple[Timing, list[FloatArray]]:
    """Return the time per call (best of some passes) and the forces of the last pass."""
    with one_core():
        seconds, forces = best_of(call, items, passes, warm_up=10)
    return Timing.of(seconds), forces


def _distance(a: FloatArray, b: FloatArray) -> float:
    """Return the distance of two sets of forces [N]; infinite for anything that is not finite."""
    gap = float(np.linalg.norm(a - b))
    return gap if np.isfinite(gap) else np.inf


def _quantile(values: list[float]) -> float:
    """Return the 95th percentile, by an actual value."""
    return float(np.quantile(values, 0.95, method="lower")) if values else 0.0


def _row(
    scene: MpcScene, method: str, variant: str, timing: Timing, ours: Timing, forces: list[FloatArray],
    own: list[FloatArray], mpc: ConvexMpc, programs: list[HorizonProgram], exact: list[FloatArray],
) -> MpcRow:  # fmt: skip
    """Return the figures of one method on one scene."""
    error = _error(forces, own)
    first, outside, unused = [], [0.0], []
    least = total = 0.0
    for f, best, program in zip(forces, exact, programs, strict=True):
        now = program.step == 0
        first.append(_distance(f[now], best[now]))
        mu, low, high = program.bounds.T
        sideways, normal = np.linalg.norm(f[:, :2], axis=1), f[:, 2]
        outside.append(float(np.max([sideways - mu * normal, low - normal, normal - high], initial=0.0)))
        full = np.linalg.norm(best[:, :2], axis=1) >= 0.999 * mu * best[:, 2]
        full &= (best[:, 2] > 5.0) & (normal > 1.0)
        unused.append(1.0 - sideways[full] / (mu * normal)[full])
        least += tracking_cost(mpc, program, best)
        total += tracking_cost(mpc, program, f)
    lost = np.concatenate(unused)
    return MpcRow(
        scene.name, method, variant, timing, timing.median / ours.median, error, _quantile(first),
        max(outside), float(lost.mean()) if lost.size else float("nan"), (total - least) / least,
        error <= ACCURACY,
    )  # fmt: skip


def tracking_cost(mpc: ConvexMpc, program: HorizonProgram, forces: FloatArray) -> float:
    """Return the whole cost of (c, 3) forces, summed over predicted errors and forces."""
    accelerations = np.zeros((mpc.horizon, 6))
    np.add.at(accelerations, program.step, np.einsum("cxa,cx->ca", program.M, forces))
    errors = mpc_model.predict(program.drift, accelerations, mpc.dt)[1:]
    share = np.ones(mpc.horizon)
    share[-1] = mpc.weights.terminal
    tracking = float(np.einsum("k,sa,ksa->", share, mpc.weights.matrix(), errors**2))
    return 0.5 * tracking + 0.5 * program.rho * float(np.sum((forces - program.centre) ** 2))
