"""A call of every public function and of the methods of what they return, for odd values in each argument."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.mechanics.terrain import FlatTerrain
from surefoot.motion.control.controller import RobotState
from tests.robots import robot_of

FEET = [[0.2, 0.15, 0.0], [0.2, -0.15, 0.0], [-0.2, 0.15, 0.0], [-0.2, -0.15, 0.0]]
COM, WRENCH = [0.0, 0.0, 0.3], [0.0, 0.0, 150.0, 0.0, 0.0, 0.0]
FLOOR = sf.Stance([sf.PointContact(place, mu=0.6) for place in FEET])
CONE, SOLE, LAW = sf.FrictionCone(0.6), sf.Sole(0.6, 0.2, 0.1), sf.laws.HuntCrossley(2e5, 0.5)
G, FREE = np.eye(6) + 0.1, np.array([0.1, 0.0, -1.0] * 2)
PROBLEM = sf.ContactProblem(G, FREE, 0.5)
GRASP = FLOOR.grasp_map(COM)
FORCES = np.tile([1.0, 0.0, 40.0], (30, 4, 1))


def robot() -> sf.Robot:
    """Return Go2."""
    return robot_of("go2")


@cache
def log() -> sf.Log:
    """Return a log of four feet that push."""
    return sf.log_from_arrays(
        {"forces": FORCES}, dt=0.01, feet=("FL", "FR", "RL", "RR"), facts={"mass": 16.0}
    )


@cache
def resting_log() -> sf.Log:
    """Return the log of IMU and joints of a robot at rest, for a second."""
    rows = 101
    return sf.Log({
        "time": 0.01 * np.arange(rows), "imu_angular_velocity": np.zeros((rows, 3)),
        "imu_acceleration": np.tile([0.0, 0.0, 9.81], (rows, 1)),
        "joint_positions": np.tile(robot().nominal[7:], (rows, 1)),
    })  # fmt: skip


@cache
def solution() -> Any:
    """Return a solved problem."""
    return sf.solve(PROBLEM)


@cache
def balance() -> sf.WholeBodyController:
    """Return a whole-body controller of Go2."""
    return sf.WholeBodyController(robot())


def tasks(**given: Any) -> sf.Tasks:
    """Return tasks of a standing Go2."""
    usual = {
        "stance": np.ones(4, dtype=bool), "com_acceleration": np.zeros(3), "turn_acceleration": np.zeros(3),
        "feet": np.zeros((4, 6)), "joints": np.zeros(12), "forces": np.zeros((4, 3)),
        "frames": np.tile(np.eye(3), (4, 1, 1)), "gaps": np.zeros(4),
    }  # fmt: skip
    return sf.Tasks(**{**usual, **given})


def whole_body(q: Any, v: Any, **given: Any) -> Any:
    """Return a command for tasks."""
    return balance().step(q, v, tasks(**given))


def read(**given: Any) -> Any:
    """Return what a loop makes of readings."""
    still = np.zeros(12)
    usual = {
        "time": 0.0, "quaternion": [0, 0, 0, 1.0], "gyro": np.zeros(3), "accelerometer": [0, 0, 9.81],
        "positions": robot().nominal[7:], "speeds": still, "torques": still, "forces": None,
    }  # fmt: skip
    return loop().step(sf.RobotReadings(**{**usual, **given}))


@cache
def loop() -> sf.RobotLoop:
    """Return a loop of Go2."""
    return sf.RobotLoop(robot())


def world(name: str) -> Callable[..., Any]:
    """Return what steps a new world."""

    made = cache(lambda: getattr(sf, name)(robot()))

    def step(torques: Any, push: Any, q: Any) -> Any:
        one = made()
        one.reset(q)
        return one.step(torques, push)

    return step


def distributor(**given: Any) -> Any:
    """Return a distribution by a new distributor."""
    own = {"mu", "normal_min", "normal_max", "wrench_weights", "force_weight"}
    made = sf.ForceDistributor(**{name: value for name, value in given.items() if name in own})
    return made.solve(**{name: value for name, value in given.items() if name not in own})


@cache
def new_filter() -> sf.InvariantEkf:
    """Return a filter."""
    return sf.InvariantEkf(robot(), 0.002)


@cache
def walker() -> sf.WalkingController:
    """Return a controller that walks."""
    return sf.WalkingController(robot(), sf.VelocityCommand.constant(0.1))


def filtered(start: Any, gyro: Any, accelerometer: Any, positions: Any, speeds: Any, contact: Any) -> Any:
    """Return a step of a new filter."""
    ekf = new_filter()
    ekf.reset(start)
    ekf.predict(gyro, accelerometer)
    return ekf.update(positions, speeds, contact)


Q, V, T = np.zeros(3), np.zeros(3), np.zeros(12)


@cache
def motion() -> sf.Motion:
    """Return a second of a Go2 that stands."""
    return sf.Motion(robot(), np.tile(robot().nominal, (30, 1)), 30.0)


CALLS: dict[str, tuple[Callable[..., Any], dict[str, Any]]] = {
    "FrictionCone": (sf.FrictionCone, {"mu": 0.6}),
    "certify_motion": (
        lambda mu, sliding_mu, window: sf.certify_motion(
            robot(), motion(), mu=mu, sliding_mu=sliding_mu, window=window
        ),
        {"mu": 0.6, "sliding_mu": (0.3, 0.6), "window": 0.1},
    ),
    "audit_batch": (
        lambda forces, mu, mass, done: sf.audit_batch({"forces": forces}, 0.01, mu, mass=mass, done=done),
        {"forces": np.ones((20, 3, 4, 3)), "mu": 0.6, "mass": 9.0, "done": np.zeros((20, 3), dtype=bool)},
    ),
    "StepLaws": (sf.StepLaws, {"feet": 4, "mu": 0.6, "mass": 9.0, "dt": 0.01}),
    "StepLaws.step": (
        lambda forces, gaps: sf.StepLaws(4, 0.6, 9.0, 0.01)(forces, gaps),
        {"forces": np.ones((3, 4, 3)), "gaps": np.zeros((3, 4))},
    ),
    "read_motion": (
        lambda source, fps: sf.read_motion(source, robot(), fps=fps, order="depth", quaternion="xyzw"),
        {"source": np.tile(robot_of("go2").nominal, (30, 1)), "fps": 30.0},
    ),
    "FrictionCone.contains": (CONE.contains, {"x": [1.0, 0.0, 9.0]}),
    "FrictionCone.margin": (CONE.margin, {"x": [1.0, 0.0, 9.0]}),
    "FrictionCone.project": (CONE.project, {"x": [1.0, 0.0, 9.0]}),
    "FrictionCone.polyhedral": (CONE.polyhedral, {"facets": 8, "fit": "inner"}),
    "Sole": (sf.Sole, {"mu": 0.6, "length": 0.2, "width": 0.1}),
    "Sole.contains": (SOLE.contains, {"wrench": WRENCH}),
    "Sole.margin": (SOLE.margin, {"wrench": WRENCH}),
    "Sole.project": (SOLE.project, {"wrench": WRENCH}),
    "Sole.friction_needed": (SOLE.friction_needed, {"wrench": WRENCH}),
    "Sole.verdict": (SOLE.verdict, {"wrench": WRENCH}),
    "PointContact": (
        sf.PointContact, {"position": FEET[0], "normal": [0, 0, 1.0], "mu": 0.6, "normal_max": 9.0}
    ),
    "SoleContact": (
        sf.SoleContact, {"position": FEET[0], "sole": SOLE, "normal": [0, 0, 1.0], "heading": [1.0, 0, 0]}
    ),
    "Stance": (sf.Stance, {"contacts": FLOOR.contacts}),
    "Stance.grasp_map": (FLOOR.grasp_map, {"about": COM}),
    "Stance.halfspaces": (FLOOR.halfspaces, {"facets": 8}),
    "StanceBatch": (
        sf.StanceBatch, {"positions": [FEET], "normals": [0, 0, 1.0], "mu": 0.6, "counts": [4]},
    ),
    "can_stand": (
        sf.can_stand, {"stance": FLOOR, "com": COM, "mass": 15.0, "external_wrench": np.zeros(6)},
    ),
    "can_stand_batch": (sf.can_stand_batch, {"stances": [FLOOR], "com": COM, "mass": 15.0}),
    "com_region": (sf.com_region, {"stance": FLOOR, "mass": 15.0, "tol": 1e-3}),
    "com_region_batch": (sf.com_region_batch, {"stances": [FLOOR], "mass": 15.0}),
    "friction_needed": (sf.friction_needed, {"stance": FLOOR, "com": COM, "mass": 15.0}),
    "wrench_cone": (sf.wrench_cone, {"stance": FLOOR, "about": COM, "facets": 8}),
    "StanceCone.contains": (sf.wrench_cone(FLOOR, COM).contains, {"x": WRENCH}),
    "distribute": (sf.distribute, {"stance": FLOOR, "wrench": WRENCH, "about": COM}),
    "ForceDistributor": (
        distributor,
        {"mu": 0.6, "normal_min": 0.0, "normal_max": 1e3, "wrench_weights": np.ones(6), "force_weight": 1e-3,
         "grasp_map": GRASP, "wrench": WRENCH, "active": np.ones(4, dtype=bool)},
    ),
    "ContactProblem": (
        sf.ContactProblem,
        {"G": G, "g": FREE, "mu": 0.5, "normal_min": 0.0, "normal_max": 9.0, "bilateral": [False, False],
         "compliance": 0.0},
    ),
    "solve": (sf.solve, {"problem": PROBLEM, "solver": "auto", "tol": 1e-8}),
    "solve_batch": (sf.solve_batch, {"G": G[None], "g": FREE[None], "mu": 0.5, "tol": 1e-8}),
    "ContactSolver": (sf.ContactSolver, {"contacts": 2, "mu": [0.5, 0.6], "tol": 1e-8}),
    "ContactSolver.solve": (sf.ContactSolver(2, 0.5).solve, {"G": G, "g": FREE}),
    "residuals": (sf.residuals, {"problem": PROBLEM, "forces": np.zeros((2, 3))}),
    "check_proof": (sf.check_proof, {"problem": PROBLEM, "direction": np.zeros((2, 3))}),
    "redundancy": (sf.redundancy, {"problem": PROBLEM, "tol": 1e-9}),
    "carry_over": (sf.carry_over, {"forces": np.zeros((2, 3)), "kept": [0, 1]}),
    "solution.derivative": (lambda smoothing: solution().derivative(smoothing=smoothing), {"smoothing": 0.0}),
    "derivative.jvp": (lambda G, g, mu: solution().derivative().jvp(G=G, g=g, mu=mu),
                       {"G": G, "g": FREE, "mu": [0.1, 0.1]}),
    "derivative.vjp": (lambda **given: solution().derivative().vjp(**given),
                       {"forces": np.ones((2, 3)), "velocities": np.ones((2, 3))}),
    "LCP": (sf.LCP, {"M": np.eye(2), "q": -np.ones(2)}),
    "solve_lcp": (sf.solve_lcp, {"problem": sf.LCP(np.eye(2), -np.ones(2))}),
    "combine_friction": (sf.combine_friction, {"engine": "mujoco", "first": 0.5, "second": 0.6}),
    "translate": (sf.translate, {"law": LAW, "to": "mujoco", "mass": 4.0}),
    "law": (LAW.force, {"gap": [-1e-3], "velocity": [[0.0, 0.0, -0.1]]}),
    "laws.HuntCrossley": (sf.laws.HuntCrossley, {"stiffness": 2e5, "dissipation": 0.5}),
    "laws.SpringDamper": (sf.laws.SpringDamper, {"stiffness": 2e4, "damping": 100.0}),
    "place": (lambda **given: sf.place(robot(), **given),
              {"terrain": FlatTerrain(), "q": robot().nominal, "at": [0.0, 0.0]}),
    "Robot.stance": (lambda **given: robot().stance(**given), {"q": robot().nominal, "mu": 0.6}),
    "Robot.com": (lambda q: robot().com(q), {"q": robot().nominal}),
    "Robot.foot_positions": (lambda q: robot().foot_positions(q), {"q": robot().nominal}),
    "SlopeTerrain": (sf.SlopeTerrain, {"degrees": 5.0}),
    "StairsTerrain": (sf.StairsTerrain, {"rise": 0.1, "tread": 0.3, "steps": 4}),
    "ConvexMpc": (sf.ConvexMpc, {"mass": 15.0, "inertia": np.eye(3)}),
    "MpcWeights": (sf.MpcWeights, {"position": [1.0, 1.0, 1.0]}),
    "WholeBodyController": (
        sf.WholeBodyController, {"robot": robot(), "mu": 0.6, "normal_max": 500.0,
         "effort_limits": np.full(12, 20.0)},
    ),
    "WholeBodyController.step": (
        whole_body,
        {"q": robot().nominal, "v": np.zeros(18), "stance": np.ones(4, dtype=bool), "com_acceleration": Q,
         "turn_acceleration": Q, "feet": np.zeros((4, 6)), "joints": T, "forces": np.zeros((4, 3)),
         "frames": np.tile(np.eye(3), (4, 1, 1)), "gaps": np.zeros(4)},
    ),
    "VelocityCommand": (sf.VelocityCommand, {"times": [0.0, 1.0], "values": [[0.1, 0, 0], [0.2, 0, 0]]}),
    "VelocityCommand.constant": (sf.VelocityCommand.constant, {"forward": 0.1, "left": 0.1, "turn": 0.1}),
    "RobotLoop": (
        sf.RobotLoop, {"robot": robot(), "dt": 0.002, "mu": 0.6, "latency": 0.0, "imu_position": np.zeros(3)},
    ),
    "RobotLoop.step": (
        read,
        {"time": 0.0, "quaternion": [0, 0, 0, 1.0], "gyro": V, "accelerometer": V, "positions": T,
         "speeds": T, "torques": T, "forces": np.zeros(4)},
    ),
    "RobotLoop.steer": (lambda **given: loop().steer(**given), {"velocity": Q, "posture": Q}),
    "InvariantEkf": (sf.InvariantEkf, {"robot": robot(), "dt": 0.002, "imu_position": np.zeros(3)}),
    "InvariantEkf.update": (
        filtered,
        {"start": robot().nominal, "gyro": V, "accelerometer": V, "positions": T, "speeds": T,
         "contact": np.ones(4, dtype=bool)},
    ),
    "estimate_forces": (
        lambda **given: sf.estimate_forces(robot(), **given),
        {"q": robot().nominal, "v": np.zeros(18), "a": np.zeros(18), "tau": np.zeros(12), "mu": 0.6},
    ),
    "rollout": (
        lambda **given: sf.rollout(robot(), **given),
        {"q": sf.place(robot()), "v": np.zeros(18), "torques": np.zeros((2, 12)), "dt": 0.01, "mu": 0.6,
         "steps": 2},
    ),
    "MujocoWorld": (world("MujocoWorld"), {"torques": T, "push": Q, "q": robot().nominal}),
    "RigidWorld": (world("RigidWorld"), {"torques": T, "push": Q, "q": robot().nominal}),
    "WalkingController.step": (
        lambda q, v, contact, torques: walker().step(
            RobotState(q, v, 0.0, contact, torques)),
        {"q": robot().nominal, "v": np.zeros(18), "contact": np.ones(4, dtype=bool), "torques": T},
    ),
    "FrictionTracker": (sf.FrictionTracker, {"contacts": 1, "dt": 0.001, "least": 5.0}),
    "FrictionTracker.update": (
        lambda **given: sf.FrictionTracker(1, 0.001, least=5.0).update(**given),
        {"forces": [[1.0, 0.0, 9.0]], "velocities": [[0.1, 0.0, 0.0]]},
    ),
    "Gait": (sf.Gait, {"name": "mine", "switching": [0.0, 0.25, 0.5], "modes": [6, 9], "feet": 4}),
    "log_from_arrays": (
        lambda forces, time, q, **given: sf.log_from_arrays(
            {"forces": forces, "time": time, "q": q}, **given),
        {"forces": FORCES, "time": np.arange(30) * 0.01, "q": np.tile(robot().nominal, (30, 1)),
         "feet": ["FL", "FR", "RL", "RR"], "quaternion": "xyzw"},
    ),
    "Log.rows": (lambda rows: log().rows(rows), {"rows": np.ones(30, dtype=bool)}),
    "Scenario": (
        sf.Scenario, {"duration": 1.0, "mu": 0.5, "start": robot().nominal, "velocity": np.zeros(18),
         "seed": 3},
    ),
    "Push": (lambda **g: sf.Scenario(1.0, pushes=[sf.Push(**g)]),
             {"start": 0.0, "force": (1.0, 0, 0), "duration": 1.0}),
    "contact_times": (sf.contact_times, {"log": log()}),
    "estimate_state": (sf.estimate_state, {"log": resting_log(), "robot": robot()}),
}  # fmt: skip
