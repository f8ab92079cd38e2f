"""The same questions under joint torque limits: what the ground allows, the motors may not.

At rest the motors give τ = g(q) - Jᵀ f, so a torque limit is a pair of linear bounds on the contact
forces: exact, no approximation. With them as its `limits`, `com_region` keeps the joint angles and
moves the weight, as a payload that shifts would: R. Orsolino et al., "Application of Wrench-Based
Feasibility Analysis to the Online Trajectory Optimization of Legged Robots", IEEE RA-L 2018.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from surefoot.base.arrays import FloatArray
from surefoot.base.errors import ProblemError
from surefoot.contact import Fit
from surefoot.mechanics.stance import Stance
from surefoot.mechanics.statics import statics
from surefoot.mechanics.statics.limits import ForceLimits
from surefoot.mechanics.statics.verdict import Verdict

if TYPE_CHECKING:
    from surefoot.mechanics.robot import Robot


def torque_limits(robot: Robot, q: ArrayLike | None, stance: Stance, share: float = 1.0) -> ForceLimits:
    """Return the joint torque limits of a robot at rest as bounds on its contact forces.

    Parameters
    ----------
    robot
        With a floating base.
    q
        (nq,) configuration; None for the nominal one.
    stance
        Contacts of the robot at that configuration, named after its frames (`Robot.stance`).
    share
        Share of the limits that may be used, > 0.

    Returns
    -------
    ForceLimits
        Two rows per limited joint, named like "FL_calf_joint >" and "FL_calf_joint <".

    Raises
    ------
    ProblemError
        For a robot with a fixed base or a share that is not positive.
    """
    if not robot.floating:
        raise ProblemError(f"{robot.name} has a fixed base: its contacts do not carry it")
    if not 0.0 < share < np.inf:
        raise ProblemError(f"share must be positive and finite, got {share:g}")
    gravity, jacobian = _at_rest(robot, q, stance)
    limit = share * robot.effort_limits
    known = np.flatnonzero(np.isfinite(limit))
    rows = np.vstack([-jacobian[known], jacobian[known]])
    bound = np.concatenate([(limit - gravity)[known], (limit + gravity)[known]])
    names = [robot.joint_names[k] for k in known]
    return ForceLimits(rows, bound, (*(f"{n} >" for n in names), *(f"{n} <" for n in names)))


def _at_rest(robot: Robot, q: ArrayLike | None, stance: Stance) -> tuple[FloatArray, FloatArray]:
    """Return (joints,) torques that hold the weight alone and Jᵀ (joints, dim): τ = g(q) - Jᵀ f."""
    from surefoot.mechanics.robot.dynamics import bias_forces
    from surefoot.mechanics.robot.jacobians import contact_jacobian

    configuration, base = robot.configuration(q), robot.base_dof
    gravity = bias_forces(robot, configuration, np.zeros(robot.model.nv))
    return gravity[base:], contact_jacobian(robot, configuration, stance)[:, base:].T


def can_stand(
    robot: Robot,
    stance: Stance,
    q: ArrayLike | None = None,
    external_wrench: ArrayLike | float = 0.0,
    facets: int | None = None,
    fit: Fit = "inner",
    share: float = 1.0,
) -> Verdict:
    """Tell whether the ground and the motors together can hold a robot at rest.

    Parameters
    ----------
    robot, q, stance, share
        As for `torque_limits`; mass and centre of mass are the robot's at q.
    external_wrench, facets, fit
        As for `surefoot.can_stand`; the wrench acts on the base.

    Returns
    -------
    Verdict
        Its margin counts the distance of the forces to the torque limits too [N]. Where it is
        impossible, `Verdict.limiting` names the joints in the proof.

    Examples
    --------
    >>> from surefoot.mechanics.robot import load_robot
    >>> robot = load_robot("go2")
    >>> bool(can_stand(robot, robot.stance())), bool(can_stand(robot, robot.stance(), share=0.05))
    (True, False)
    """
    limits = torque_limits(robot, q, stance, share)
    return statics.can_stand(stance, robot.com(q), robot.mass, external_wrench, facets, fit, limits)
