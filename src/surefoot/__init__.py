"""Surefoot: the contact layer for legged robots.

Names are loaded on first use, so that importing the package costs nothing. What is public, and where it
lives, stands in `__init__.pyi` and nowhere else. By what one does with them:

Constrain
    FrictionCone, Sole, PointContact, SoleContact, Stance, StanceBatch, StanceCone, wrench_cone,
    read_stance, FlatTerrain, SlopeTerrain, StairsTerrain, contact_sets, laws, translate,
    combine_friction.
Solve
    ContactProblem, ContactSolver, solve, solve_batch, solver_names, SolverSettings, register, Answer,
    Status, carry_over, LCP, solve_lcp, distribute, ForceDistributor, plan, Plan, rollout,
    trajectory_gradient, read_problem, write_problem.
Check
    can_stand, can_stand_batch, friction_needed, com_region, com_region_batch, audit_log, audit_batch,
    StepLaws, rl, assert_lawful, seeded_faults, contact_times, summarise_walk, check_proof, residuals,
    redundancy, replay_log, certify_motion, transfer.
Walk
    Robot, load_robot, robot_names, place, run, Scenario, Push, Ice, SensorModel, RigidWorld, MujocoWorld,
    Body, Scene, SceneWorld, Controller, Command, RobotState, StandingController, StandingPlan,
    WalkingController, WalkSettings, VelocityCommand, WholeBodyController, Tasks, ConvexMpc, MpcWeights,
    Gait, named_gait, RobotLoop, RobotReadings, Policy, Guard, MujocoStepper, exact_contact.
Look
    picture, Log, read_log, record, log_from_arrays, contacts_from_mujoco, estimate_forces, ForceModel,
    FrictionTracker, InvariantEkf, estimate_state, identify, read_tosses, read_sweep, run_sweep,
    read_sequence, write_sequence, export_sequence, sequence_from_log, SurefootError, ProblemError,
    Motion, read_motion, read_motions, repair_motion.
"""

from __future__ import annotations

from surefoot.base.faces import face

__version__ = "0.1.0"

__getattr__, __dir__ = face(__name__, __file__, "__version__")
