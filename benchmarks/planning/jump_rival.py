"""A jump of Go2 planned here and by Crocoddyl, both judged by the certificate's replay."""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from surefoot.mechanics.robot import Robot
from surefoot.motion.planning.certificate import link_hits, replay_plan
from surefoot.motion.planning.schedule import ScheduleProblem, optimise
from surefoot.motion.planning.schedule.motions import jump
from surefoot.motion.planning.tasks.scheduled import FEEDBACK
from surefoot.motion.planning.trajectory import Trajectory
from surefoot.motion.planning.transcription.exact_rollout import follow

VARIABLE = "SUREFOOT_CROCODDYL_PYTHON"
"""Names an interpreter that has the package crocoddyl."""
DISTANCE, MU, TIMEOUT = 0.4, 0.6, 600.0
"""Of the jump [m], of the ground, and of Crocoddyl's process [s]."""


def measure(robot: Robot) -> dict[str, Any]:
    """Return what both made of the jump, by name; in place of Crocoddyl's why it did not run."""
    problem = jump(robot, DISTANCE, 0.0, MU)
    begun = time.process_time()
    found = optimise(problem)
    motion = follow(replace(problem, mu=MU, torque_share=FEEDBACK), found)
    spent = time.process_time() - begun
    ours = judged(problem, motion, spent, found.iterate.iterations, found.found)
    return {"ours": ours, "crocoddyl": rival_jump(problem)}


def judged(
    problem: ScheduleProblem, motion: Trajectory, seconds: float, iterations: int, converged: bool
) -> dict[str, Any]:
    """Return what a motion's search took, and what counts of it.

    Largest torque over its limit, force beyond the cone [N], how far the feet end from the goal [m], in the
    motion and in the certificate's replay of its torques, how far `apart` these two end, and how many links
    hit something.
    """
    robot = problem.robot
    forces = motion.impulses / problem.dt
    beyond = np.linalg.norm(forces[..., :2], axis=2) - MU * forces[..., 2]
    apart, _, went = replay_plan(motion, robot, problem.terrain)
    goal = robot.foot_positions(problem.q)[:, :2] + np.array([DISTANCE, 0.0])
    ends = motion.q[-1], went[-1] if np.isfinite(apart) else np.full_like(problem.q, np.nan)
    planned, ended = (np.linalg.norm((robot.foot_positions(q)[:, :2] - goal).mean(axis=0)) for q in ends)
    return {
        "seconds": seconds, "iterations": iterations, "converged": converged,
        "torque": float((np.abs(motion.torques) / robot.effort_limits).max()),
        "beyond_cone": float(max(beyond.max(), 0.0)),
        "off": float(planned), "replay_off": float(ended), "apart": apart,
        "hits": len(link_hits(motion, robot, problem.terrain)),
    }  # fmt: skip


def rival_jump(problem: ScheduleProblem) -> dict[str, Any] | str:
    """Return Crocoddyl's jump, judged, or why there is none."""
    python = os.environ.get(VARIABLE, "")
    if not python:
        return f"not run: {VARIABLE} names no interpreter that has crocoddyl"
    robot = problem.robot
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "task.npz", Path(folder) / "found.npz"
        np.savez(
            source, robot=robot.name, feet=np.array(robot.foot_names), q=problem.q, dt=problem.dt,
            mu=problem.mu, limits=problem.torque_limits, stands=problem.stance.all(axis=1),
            shift=np.array([DISTANCE, 0.0, 0.0]),
        )  # fmt: skip
        worker, one_core = Path(__file__).with_name("crocoddyl_worker.py"), {"OMP_NUM_THREADS": "1"}
        command = [python, "-I", str(worker), str(source), str(target)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=TIMEOUT, check=False,
                env=os.environ | one_core,
            )  # fmt: skip
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"not run: {error}"
        if done.returncode:
            said = done.stderr.strip() or f"ended with {done.returncode}"
            return f"not run: {python}: {said.splitlines()[-1]}"
        with np.load(target) as file:
            found = dict(file)
    motion = Trajectory.blank(robot, problem.knots, problem.dt, MU)
    motion.q[:], motion.v[:], motion.torques[:] = found["q"], found["v"], found["torques"]
    motion.impulses[:] = problem.dt * found["forces"]
    names = ("seconds", "iterations", "converged")
    return judged(problem, motion, *(found[name].item() for name in names))
