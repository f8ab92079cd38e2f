"""A value of every public class, and of what public functions return."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import numpy as np

import surefoot as sf
from surefoot.mechanics.collision import Box
from tests.motion.policy.onnx_file import write_onnx
from tests.odd_arguments import (
    COM,
    CONE,
    FEET,
    FLOOR,
    FREE,
    LAW,
    PROBLEM,
    SOLE,
    WRENCH,
    G,
    balance,
    log,
    loop,
    motion,
    robot,
    tasks,
    walker,
)  # fmt: skip

FLAT, SETS, LAWS, STILL = sf.FlatTerrain(), sf.contact_sets, sf.laws, np.zeros(12)
SOLID = LAWS.CompliantSolid.sole([[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05], [-0.1, 0.05]], 0.01)
BALL = (
    "<mujoco><option cone='elliptic'/><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 0.1'>"
    "<freejoint/><geom size='.1'/></body></worldbody></mujoco>"
)


def standing_plan() -> sf.StandingPlan:
    """Return a plan of a Go2 that stands."""
    return sf.StandingPlan(robot(), FLAT, sf.place(robot()))


def standing() -> sf.StandingController:
    """Return what holds a Go2 there."""
    return sf.StandingController(robot(), standing_plan(), FLAT, sf.place(robot()))


def state() -> sf.RobotState:
    """Return a Go2 at rest."""
    return sf.RobotState(sf.place(robot()), np.zeros(18), 0.0, np.ones(4, dtype=bool))


@cache
def policy() -> sf.Policy:
    """Return a network that gives its last inputs back, and 0.1 more."""
    spec = {
        "joints": list(robot().joint_names), "default": robot().nominal[7:].tolist(), "stiffness": 20,
        "damping": 0.5, "action_scale": 0.25,
        "observations": ["angular_velocity", "gravity", "command", "joint_positions", "joint_velocities",
                         "last_action"],
    }  # fmt: skip
    file = write_onnx(Path(mkdtemp()) / "go2_net.onnx", np.eye(45, 12, k=-33), np.full(12, 0.1))
    return sf.Policy(file, spec, robot())


def stepper() -> sf.MujocoStepper:
    """Return what steps a ball on the ground."""
    import mujoco

    return sf.MujocoStepper(mujoco.MjModel.from_xml_string(BALL))


def scene() -> sf.Scene:
    """Return a cube on the ground."""
    return sf.Scene([sf.Body("cube", Box((0.2, 0.2, 0.2)), position=(0.0, 0.0, 0.1))])


VALUES: dict[str, Callable[[], Any]] = {
    "Answer": lambda: sf.Answer(np.ones((2, 3)), 3),
    "Body": lambda: scene().bodies[0],
    "Command": lambda: standing().step(state()),
    "ContactProblem": lambda: PROBLEM,
    "ContactSolver": lambda: sf.ContactSolver(2, 0.5),
    "Controller": standing,
    "ConvexMpc": lambda: sf.ConvexMpc(15.0, np.eye(3)),
    "FlatTerrain": sf.FlatTerrain,
    "ForceDistributor": lambda: sf.ForceDistributor(0.6),
    "ForceModel": lambda: sf.ForceModel(
        robot(),
        np.eye(3),
        *np.zeros((1, 3)),
        0.0,
        0.1,
        ((1.0,),),
        *np.ones((6, 3)),
        {"knee": {"dry": (1.0, 0.9, 1.1)}},
    ),
    "FrictionCone": lambda: CONE,
    "FrictionTracker": lambda: sf.FrictionTracker(1, 0.001, least=5.0),
    "Gait": lambda: sf.named_gait("trot"),
    "Guard": lambda: sf.Guard(standing(), 0.3),
    "Ice": lambda: sf.Ice(0.1, 0.2),
    "InvariantEkf": lambda: sf.InvariantEkf(robot(), 0.002),
    "LCP": lambda: sf.LCP(np.eye(2), -np.ones(2)),
    "Log": log,
    "Motion": motion,
    "MpcWeights": sf.MpcWeights,
    "MujocoStepper": stepper,
    "MujocoWorld": lambda: sf.MujocoWorld(robot()),
    "Plan": lambda: sf.plan(None, "ball"),
    "PointContact": lambda: FLOOR.contacts[0],
    "Policy": policy,
    "ProblemError": lambda: sf.ProblemError("so"),
    "Push": lambda: sf.Push(0.0, (1.0, 0.0, 0.0), 1.0),
    "RigidWorld": lambda: sf.RigidWorld(robot()),
    "Robot": robot,
    "RobotLoop": loop,
    "RobotReadings": lambda: sf.RobotReadings(0.0, np.eye(4)[3], *np.zeros((2, 3)), STILL, STILL, STILL),
    "RobotState": state,
    "Scenario": lambda: sf.Scenario(1.0, pushes=[sf.Push(0.0, (1.0, 0.0, 0.0), 1.0)]),
    "Scene": scene,
    "SceneWorld": lambda: sf.SceneWorld(scene()),
    "SensorModel": sf.SensorModel,
    "SlopeTerrain": lambda: sf.SlopeTerrain(5.0),
    "Sole": lambda: SOLE,
    "SoleContact": lambda: sf.SoleContact(FEET[0], SOLE),
    "SolverSettings": sf.SolverSettings,
    "StairsTerrain": lambda: sf.StairsTerrain(0.1, 0.3, 4),
    "Stance": lambda: FLOOR,
    "StanceBatch": lambda: sf.StanceBatch([FEET], [0, 0, 1.0], 0.6, counts=[4]),
    "StanceCone": lambda: sf.StanceCone(FLOOR, COM),
    "StandingController": standing,
    "StandingPlan": standing_plan,
    "Status": lambda: sf.Status.SOLVED,
    "StepLaws": lambda: sf.StepLaws(4, 0.6, 12.0, 0.02),
    "SurefootError": lambda: sf.SurefootError("so"),
    "Tasks": tasks,
    "VelocityCommand": lambda: sf.VelocityCommand.constant(0.3),
    "WalkSettings": sf.WalkSettings,
    "WalkingController": walker,
    "WholeBodyController": balance,
    "contact_sets.Bilateral": SETS.Bilateral,
    "contact_sets.ContactKind": lambda: SETS.Point(0.5),
    "contact_sets.ContactSet": lambda: SETS.ContactSet([SETS.Point(0.5), SETS.Rolling(0.5, 0.01)]),
    "contact_sets.DecoupledSole": lambda: SETS.DecoupledSole(0.5, 0.2, 0.1, 0.01),
    "contact_sets.Factor": lambda: SETS.Factor((0, 1), 0.5),
    "contact_sets.Frictionless": SETS.Frictionless,
    "contact_sets.Planar": lambda: SETS.Planar(0.5),
    "contact_sets.Point": lambda: SETS.Point(0.5),
    "contact_sets.Pyramid": lambda: SETS.Pyramid(0.5),
    "contact_sets.Rolling": lambda: SETS.Rolling(0.5, 0.01),
    "contact_sets.SoftFinger": lambda: SETS.SoftFinger(0.5, 0.01),
    "laws.CompliantSolid": lambda: SOLID,
    "laws.ExactFriction": lambda: LAWS.ExactFriction(0.5),
    "laws.ForceJacobian": lambda: LAWS.SpringDamper(1e4, friction=LAWS.RegularisedFriction(0.5)).jacobian(
        [-1e-3], [[0.0, 0.0, -0.1]]
    ),
    "laws.Friction": lambda: LAWS.RegularisedFriction(0.5),
    "laws.Hertz": lambda: LAWS.Hertz(1e5),
    "laws.HuntCrossley": lambda: LAW,
    "laws.Law": lambda: PROBLEM.law,
    "laws.MassOnContact": lambda: LAWS.behaviour(LAW, 4.0),
    "laws.MujocoLaw": LAWS.MujocoLaw,
    "laws.PressureField": lambda: LAWS.PressureField(1e6, 0.01),
    "laws.PressurePatch": lambda: LAWS.PressureField(1e6, 0.01).contact(SOLID, np.eye(3), [0, 0, -1e-4]),
    "laws.RegularisedFriction": lambda: LAWS.RegularisedFriction(0.5),
    "laws.SoftLaw": lambda: LAWS.SpringDamper(1e4),
    "laws.SpringDamper": lambda: LAWS.SpringDamper(1e4),
}
"""By the class's public name."""
ANSWERS: dict[str, Callable[[], Any]] = {
    "audit_log": lambda: sf.audit_log(log()),
    "can_stand": lambda: sf.can_stand(FLOOR, COM, 15.0),
    "can_stand_batch": lambda: sf.can_stand_batch([FLOOR], COM, 15.0),
    "certify_motion": lambda: sf.certify_motion(robot(), motion(), mu=0.6, window=0.1),
    "com_region": lambda: sf.com_region(FLOOR, 15.0),
    "com_region_batch": lambda: sf.com_region_batch([FLOOR], 15.0),
    "contact_times": lambda: sf.contact_times(log()),
    "distribute": lambda: sf.distribute(FLOOR, WRENCH, about=COM),
    "estimate_forces": lambda: sf.estimate_forces(
        robot(), robot().nominal, *np.zeros((2, 18)), STILL, mu=0.6
    ),
    "friction_needed": lambda: sf.friction_needed(FLOOR, COM, 15.0),
    "redundancy": lambda: sf.redundancy(PROBLEM),
    "Robot.lint": lambda: robot().lint(),
    "rollout": lambda: sf.rollout(
        robot(), sf.place(robot()), np.zeros(18), np.zeros((2, 12)), dt=0.01, mu=0.6
    ),
    "wrench_cone": lambda: sf.wrench_cone(FLOOR, COM),
    "Sole.verdict": lambda: SOLE.verdict(WRENCH),
    "solve": lambda: sf.solve(PROBLEM),
    "solve_batch": lambda: sf.solve_batch(G[None], FREE[None], 0.5),
    "solve(...).derivative": lambda: sf.solve(PROBLEM).derivative(),
    "translate": lambda: sf.translate(LAW, to="mujoco", mass=4.0),
}  # fmt: skip
"""By the function that returns it."""
