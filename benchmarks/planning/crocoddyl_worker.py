"""Crocoddyl on the jump of `jump_rival`, in an interpreter of its own; it needs nothing of Surefoot.

Arguments: the task as .npz (see `jump_rival.rival_jump`), and the output .npz. Its quadruped gaits are taken
as they come: costs and weights, semi-implicit Euler, torque limits by `SolverBoxFDDP`. Only the landing is
written here, as a knot in which feet lose their whole speed inside the friction cones: its own impulse model
knows no cone (1.0 of friction at touchdown where the ground has 0.6), and the costs of its own
pseudo-impulses are of a time of zero (feet that came at 2 m/s sank by 17 mm).
"""

from __future__ import annotations

import importlib
import sys
import time
from typing import Any

import numpy as np

MOST = 500
"""Iterations."""
BEGIN = 0.1
"""Regularisation that its examples with torque limits begin with."""


def build(crocoddyl: Any, pinocchio: Any, task: Any) -> Any:
    """Return the shooting problem: stand, fly along the height of a throw, land, stand."""
    model = importlib.import_module("example_robot_data").load(str(task["robot"])).model
    model.upperEffortLimit = np.concatenate([model.upperEffortLimit[:6], task["limits"]])
    model.lowerEffortLimit = -model.upperEffortLimit
    model.referenceConfigurations["standing"] = task["q"]
    gaits = importlib.import_module("crocoddyl.utils.quadruped")
    gait = gaits.SimpleQuadrupedalGaitProblem(model, *task["feet"].tolist())
    gait.mu, dt, shift = float(task["mu"]), float(task["dt"]), task["shift"]
    data, ids = model.createData(), [model.getFrameId(name) for name in task["feet"]]
    pinocchio.framesForwardKinematics(model, data, task["q"])
    com = pinocchio.centerOfMass(model, data, task["q"]).copy()
    goals = [[i, pinocchio.SE3(np.eye(3), data.oMf[i].translation + shift)] for i in ids]
    stands = task["stands"].tolist()
    off, on = stands.index(False), len(stands) - stands[::-1].index(False)
    rise, half = np.array([0.0, 0.0, 9.81 * ((on - off) * dt) ** 2 / 8.0]), (on - off) // 2
    models = [gait.createSwingFootModel(dt, ids) for _ in range(off)]
    for k in range(on - off):  # as its jumps: up along a line, down as it may
        up = com + (k + 1) / half * (0.5 * shift + rise) if k < half else None
        models.append(gait.createSwingFootModel(dt, [], up))
    models += [gait.createSwingFootModel(dt, ids, com + shift, None if k else goals)
               for k in range(len(stands) - on + 1)]  # fmt: skip
    for landed in models[on:]:
        contacts = landed.differential.contacts
        for name, i in zip(task["feet"], ids, strict=True):
            axes, still = pinocchio.LOCAL_WORLD_ALIGNED, np.array([0.0, 1.0 / dt])
            contact = crocoddyl.ContactModel3D(gait.state, i, np.zeros(3), axes, gait.actuation.nu, still)
            contacts.removeContact(f"{name}_contact")
            contacts.addContact(f"{name}_contact", contact)
    return crocoddyl.ShootingProblem(np.append(task["q"], np.zeros(model.nv)), models[:-1], models[-1])


def main(source: str, target: str) -> None:
    """Build and solve."""
    crocoddyl, pinocchio = importlib.import_module("crocoddyl"), importlib.import_module("pinocchio")
    with np.load(source) as file:
        task = dict(file)
    begun = time.process_time()
    problem = build(crocoddyl, pinocchio, task)
    problem.nthreads = 1
    solver, states = crocoddyl.SolverBoxFDDP(problem), [problem.x0] * (problem.T + 1)
    converged = solver.solve(states, problem.quasiStatic(states[:-1]), MOST, False, BEGIN)
    seconds = time.process_time() - begun
    q, v = np.split(np.array(solver.xs), [len(task["q"])], axis=1)
    forces, feet = np.zeros((problem.T, len(task["feet"]), 3)), task["feet"].tolist()
    for k, data in enumerate(problem.runningDatas):
        for name, contact in data.differential.multibody.contacts.contacts.todict().items():
            forces[k, feet.index(name.removesuffix("_contact"))] = contact.f.linear
    np.savez(
        target, q=q, v=v, torques=np.array(solver.us), forces=forces, seconds=seconds,
        iterations=solver.iter, converged=converged,
    )  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
