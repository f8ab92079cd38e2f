"""What a shooting solver is given, and what it returns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from surefoot.base.arrays import FloatArray, real_array, real_number, whole_number
from surefoot.base.errors import ProblemError
from surefoot.contact import Status
from surefoot.mechanics import Robot, Terrain
from surefoot.motion.planning.shooting.costs import Costs
from surefoot.motion.planning.trajectory import Trajectory


@dataclass(frozen=True)
class Goal:
    """What a motion has to reach for its plan to count.

    Attributes
    ----------
    distance
        Of a trajectory from the goal, zero or more.
    tolerance
        Up to which it is reached.
    """

    distance: Callable[[Trajectory], float]
    tolerance: float


@dataclass(frozen=True)
class ShootingProblem:
    """A robot, a horizon and a cost.

    Attributes
    ----------
    robot
        With point contacts, or none.
    costs
        What to minimise.
    knots, dt
        N, and the length of a knot [s].
    mu, terrain
        Friction and shape of the ground; None for flat.
    limits
        (joints,) largest torques [N m]; None for the robot's effort limits.
    goal
        What has to be reached; None: any lawful motion counts.
    momentum
        Whether its knots keep momentum (`MomentumKnot`), as those of plans; a controller that looks anew
        every few knots does without (`Knot`).

    Raises
    ------
    ProblemError
        For numbers out of range.
    """

    robot: Robot
    costs: Costs
    knots: int
    dt: float = 0.02
    mu: float = 0.6
    terrain: Terrain | None = None
    limits: FloatArray | None = None
    goal: Goal | None = None
    momentum: bool = True

    def __post_init__(self) -> None:
        whole_number("knots", self.knots, low=1)
        real_number("dt", self.dt, low=1e-6, high=1.0)
        real_number("mu", self.mu, low=0.0, high=1e6)
        limits = self.robot.effort_limits if self.limits is None else self.limits
        object.__setattr__(self, "limits", real_array("limits", limits, (self.robot.joints,)))


@dataclass(frozen=True)
class ShootingSettings:
    """How a solve goes.

    Attributes
    ----------
    smoothings
        κ of the derivatives, one stage after another [N s m/s]; the forward steps are exact in all.
    max_iterations
        Over all stages.
    tol
        Relative change of the cost at which a stage ends.
    damping
        Weight of ½ ||du||² to begin with, relative to the torques' mean weight; it is raised when a line
        search fails.
    least, most
        Bounds on it.
    shares
        Shares of the step that a line search tries.
    """

    smoothings: tuple[float, ...] = (1e-1, 1e-2, 1e-3)
    max_iterations: int = 200
    tol: float = 1e-5
    damping: float = 1e-3
    least: float = 1e-6
    most: float = 1e8
    shares: tuple[float, ...] = (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)

    def __post_init__(self) -> None:
        if not self.smoothings:
            raise ProblemError("smoothings must hold at least one number")
        for k, value in enumerate(self.smoothings):
            real_number(f"smoothings[{k}]", value, low=0.0)
        whole_number("max_iterations", self.max_iterations, low=1)
        real_number("tol", self.tol, low=0.0)


@dataclass(frozen=True)
class ShootingResult:
    """What a solve found.

    Attributes
    ----------
    trajectory
        The rollout of its torques: exact steps, no gaps.
    gains
        (N, m, 2nv) K of u = u_k + K (x ⊖ x_k), by tangents as in `state_space.difference`.
    status
        SOLVED only where the trajectory is lawful to 1e-8 and the goal reached within its tolerance.
    cost
        Of the trajectory.
    costs
        After every iteration.
    iterations
        Backward passes.
    distance
        From the goal, in its own unit; zero without one.
    """

    trajectory: Trajectory
    gains: FloatArray
    status: Status
    cost: float
    costs: tuple[float, ...]
    iterations: int
    distance: float

    @property
    def law_residual(self) -> float:
        """Largest velocity error of the trajectory's contact problems."""
        return self.trajectory.law_residual
