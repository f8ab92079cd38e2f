"""Rivals of the contact solvers on the same matrices: Pinocchio's ADMM and PGS, and Siconos.

Each rival stops by a test of its own, so each is tried with tightening tolerances until our residual is
reached, and timed with the loosest one that does.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.arrays import FloatArray
from surefoot.contact import ContactProblem
from surefoot.errors import MissingExtra

SYSTEM_PYTHON = "/usr/bin/python3"
STEPS = tuple(10.0 ** -np.arange(-2, 5))
"""Tolerances that a rival is tried with, times the wanted residual; loosest first."""


class PinocchioCall:
    """One problem set up for one of Pinocchio's solvers; a call solves it from a cold start.

    The Delassus operator, the constraint models (which carry only the friction coefficient) and the solver
    are made beforehand, as a simulator would; only a new result object and the solve are timed.
    """

    def __init__(self, problem: ContactProblem, method: str, tol: float, iterations: int, rule: str) -> None:
        try:
            import pinocchio
        except ImportError as error:
            raise MissingExtra("pin", "robot") from error
        model, place = pinocchio.Model(), pinocchio.SE3.Identity()
        model.addJoint(0, pinocchio.JointModelFreeFlyer(), place, "body")
        self.models, self.datas = pinocchio.StdVec_ConstraintModel(), pinocchio.StdVec_ConstraintData()
        for mu in problem.mu:
            contact = pinocchio.PointContactConstraintModel(model, 0, place, 1, place)
            contact.setFriction(float(mu))
            self.models.append(pinocchio.ConstraintModel(contact))
        for item in self.models:
            self.datas.append(item.createData())
        self.delassus, self.g = pinocchio.DelassusOperatorDense(problem.G), problem.g
        size = self.g.size
        if method == "admm":
            self.solver, self.settings = pinocchio.ADMMConstraintSolver(size), pinocchio.ADMMSolverSettings()
            self.settings.admm_update_rule = getattr(pinocchio.ADMMUpdateRule, rule)
            self.make = pinocchio.ADMMSolverResult
        else:
            self.solver, self.settings = pinocchio.PGSConstraintSolver(size), pinocchio.PGSSolverSettings()
            self.make = pinocchio.PGSSolverResult
        self.settings.max_iterations = iterations
        self.settings.absolute_feasibility_tol = self.settings.absolute_complementarity_tol = tol
        self.settings.relative_feasibility_tol = self.settings.relative_complementarity_tol = 0.0
        self.iterations = 0

    def __call__(self) -> FloatArray:
        """Solve and return the (n, 3) impulses."""
        result = self.make()
        self.solver.reset()
        self.solver.solve(self.delassus, self.g, self.models, self.datas, self.settings, result)
        self.iterations = result.iterations
        return np.asarray(result.retrieveConstraintImpulses()).reshape(-1, 3)


def pinocchio_calls(
    problem: ContactProblem, tol: float, method: str, rule: str = "OSQP"
) -> Iterable[PinocchioCall]:
    """Return calls of Pinocchio's "admm" (rule "OSQP" or "SPECTRAL") or "pgs", loosest first."""
    scale = float(np.abs(problem.g).max(initial=0.0)) or 1.0  # its tolerances are absolute velocities
    most = 20_000 if problem.contacts <= 40 else 3000
    return (PinocchioCall(problem, method, tol * step * scale, most, rule) for step in STEPS)


def siconos_installed() -> bool:
    """Tell whether the system's Python has Siconos."""
    if not Path(SYSTEM_PYTHON).exists():
        return False
    command = [SYSTEM_PYTHON, "-c", "import siconos.numerics"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


Measured = tuple[float, FloatArray]


def siconos_runs(
    problems: Sequence[ContactProblem], tol: float, timeout: float = 900.0
) -> dict[str, list[list[Measured]]]:
    """Return, by method ("siconos nsgs", ...) and problem, wall times and forces, loosest tolerance first.

    Runs in the system's Python, in a process of its own on one core.
    """
    arrays: dict[str, Any] = {"count": np.array(len(problems))}
    for k, p in enumerate(problems):
        arrays |= {f"G_{k}": p.G, f"g_{k}": p.g, f"mu_{k}": p.mu}
    worker = Path(__file__).with_name("siconos_worker.py")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "problems.npz", Path(folder) / "found.npz"
        np.savez(source, **arrays)
        command = [SYSTEM_PYTHON, str(worker), str(source), str(target), *(str(tol * s) for s in STEPS)]
        quiet = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        subprocess.run(command, check=True, capture_output=True, timeout=timeout, env=quiet)
        with np.load(target) as data:
            found = {name: data[name] for name in data.files}
    names = sorted({name.split("_")[0] for name in found})
    runs: dict[str, list[list[Measured]]] = {}
    for name in names:
        runs[f"siconos {name}"] = [
            [
                (float(found[key][-1]), found[key][:-1].reshape(-1, 3))
                for j in range(len(STEPS))
                if (key := f"{name}_{k}_{j}") in found
            ]
            for k in range(len(problems))
        ]
    return runs
