"""Surefoot: the contact layer for legged robots.

Names are loaded on first use, so that importing the package costs nothing.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from surefoot.cones import Cone as Cone
    from surefoot.cones import FrictionCone as FrictionCone
    from surefoot.cones import FrictionPyramid as FrictionPyramid
    from surefoot.cones import PolyhedralCone as PolyhedralCone
    from surefoot.cones import ProductCone as ProductCone
    from surefoot.cones import WrenchCone as WrenchCone
    from surefoot.contact import LCP as LCP
    from surefoot.contact import ContactProblem as ContactProblem
    from surefoot.contact import ContactSet as ContactSet
    from surefoot.contact import ContactSolution as ContactSolution
    from surefoot.contact import InfeasibilityProof as InfeasibilityProof
    from surefoot.contact import Redundancy as Redundancy
    from surefoot.contact import Residuals as Residuals
    from surefoot.contact import Status as Status
    from surefoot.contact import carry_over as carry_over
    from surefoot.contact import check_proof as check_proof
    from surefoot.contact import contacts as contacts
    from surefoot.contact import laws as laws
    from surefoot.contact import persisting as persisting
    from surefoot.contact import read_lcp as read_lcp
    from surefoot.contact import read_problem as read_problem
    from surefoot.contact import redundancy as redundancy
    from surefoot.contact import residuals as residuals
    from surefoot.contact import stewart_trinkle as stewart_trinkle
    from surefoot.contact import write_problem as write_problem
    from surefoot.control.force_distribution import ForceDistributor as ForceDistributor
    from surefoot.control.gait import Gait as Gait
    from surefoot.control.gait import ModeSchedule as ModeSchedule
    from surefoot.control.mpc import ConvexMpc as ConvexMpc
    from surefoot.control.stance_forces import distribute as distribute
    from surefoot.control.standing import StandingController as StandingController
    from surefoot.control.standing_plan import StandingPlan as StandingPlan
    from surefoot.control.walking import WalkingController as WalkingController
    from surefoot.control.whole_body import WholeBodyController as WholeBodyController
    from surefoot.equilibrium import ForceLimits as ForceLimits
    from surefoot.equilibrium import Region as Region
    from surefoot.equilibrium import Verdict as Verdict
    from surefoot.equilibrium import can_stand as can_stand
    from surefoot.equilibrium import com_region as com_region
    from surefoot.equilibrium import com_volume as com_volume
    from surefoot.equilibrium import friction_needed as friction_needed
    from surefoot.equilibrium import support_polygon as support_polygon
    from surefoot.equilibrium import wrench_cone as wrench_cone
    from surefoot.equilibrium import zmp_region as zmp_region
    from surefoot.errors import MissingExtra as MissingExtra
    from surefoot.errors import ModelError as ModelError
    from surefoot.errors import NoSolution as NoSolution
    from surefoot.errors import ProblemError as ProblemError
    from surefoot.errors import SolverNotFound as SolverNotFound
    from surefoot.errors import SurefootError as SurefootError
    from surefoot.robot import Robot as Robot
    from surefoot.robot import load_robot as load_robot
    from surefoot.robot import place as place
    from surefoot.robot import robot_names as robot_names
    from surefoot.simulation.mujoco import MujocoWorld as MujocoWorld
    from surefoot.simulation.rigid import RigidWorld as RigidWorld
    from surefoot.solvers import ContactForces as ContactForces
    from surefoot.solvers import ContactSolver as ContactSolver
    from surefoot.solvers import minimum_norm as minimum_norm
    from surefoot.solvers import solve as solve
    from surefoot.solvers import solve_lcp as solve_lcp
    from surefoot.solvers import solver_names as solver_names
    from surefoot.stance import FlatTerrain as FlatTerrain
    from surefoot.stance import HeightfieldTerrain as HeightfieldTerrain
    from surefoot.stance import PatchContact as PatchContact
    from surefoot.stance import PointContact as PointContact
    from surefoot.stance import SlopeTerrain as SlopeTerrain
    from surefoot.stance import StairsTerrain as StairsTerrain
    from surefoot.stance import Stance as Stance
    from surefoot.stance import Terrain as Terrain
    from surefoot.stance import read_stance as read_stance
    from surefoot.stance import write_stance as write_stance

__version__ = "0.1.0"

_HOMES = {
    "cones": ("Cone", "FrictionCone", "FrictionPyramid", "PolyhedralCone", "ProductCone", "WrenchCone"),
    "contact": (
        "LCP",
        "ContactProblem",
        "ContactSet",
        "ContactSolution",
        "InfeasibilityProof",
        "Redundancy",
        "Residuals",
        "Status",
        "carry_over",
        "check_proof",
        "contacts",
        "laws",
        "persisting",
        "read_lcp",
        "read_problem",
        "redundancy",
        "residuals",
        "stewart_trinkle",
        "write_problem",
    ),
    "control.force_distribution": ("ForceDistributor",),
    "control.gait": ("Gait", "ModeSchedule"),
    "control.mpc": ("ConvexMpc",),
    "control.stance_forces": ("distribute",),
    "control.standing": ("StandingController",),
    "control.standing_plan": ("StandingPlan",),
    "control.walking": ("WalkingController",),
    "control.whole_body": ("WholeBodyController",),
    "equilibrium": (
        "ForceLimits",
        "Region",
        "Verdict",
        "can_stand",
        "com_region",
        "com_volume",
        "friction_needed",
        "support_polygon",
        "wrench_cone",
        "zmp_region",
    ),
    "errors": ("MissingExtra", "ModelError", "NoSolution", "ProblemError", "SolverNotFound", "SurefootError"),
    "robot": ("Robot", "load_robot", "place", "robot_names"),
    "simulation.mujoco": ("MujocoWorld",),
    "simulation.rigid": ("RigidWorld",),
    "solvers": ("ContactForces", "ContactSolver", "minimum_norm", "solve", "solve_lcp", "solver_names"),
    "stance": (
        "FlatTerrain",
        "HeightfieldTerrain",
        "PatchContact",
        "PointContact",
        "SlopeTerrain",
        "StairsTerrain",
        "Stance",
        "Terrain",
        "read_stance",
        "write_stance",
    ),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = [*sorted(_HOME_OF), "__version__"]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'surefoot' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"surefoot.{_HOME_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
