"""The laws of contact inside a training loop: a cost at every step, and the audit's verdicts at any time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from surefoot.base.arrays import FloatArray, positive_number, real_array, whole_number
from surefoot.base.errors import ProblemError
from surefoot.base.spatial import GRAVITY
from surefoot.records.audit.batch.array_functions import array_module
from surefoot.records.audit.batch.audit_batch import audit_batch
from surefoot.records.audit.batch.batch_report import BatchReport
from surefoot.records.audit.batch.join_reports import join_reports
from surefoot.records.audit.batch.step_cost import StepCost, step_cost
from surefoot.records.audit.limits import LIMITS, AuditLimits
from surefoot.records.log.from_arrays import host_array
from surefoot.records.log.mapping import name_list

ROWS = 250
"""Steps that are kept until they are judged together."""
MEMORY = 256 * 2**20
"""Bytes that kept steps may take: with many environments fewer steps are kept."""


class StepLaws:
    """Judge many environments step by step: ``cost = laws(forces, gaps, velocities)``.

    The cost is in the arrays' own framework, on their device, and may stand in a reward. The steps are also
    kept on the host, up to `rows` of them, and judged by `audit_batch` then: a law that looks at several
    steps looks no further than an episode's end, or that of the kept steps.

    Parameters
    ----------
    feet
        Number of contacts of an environment, or their names.
    mu
        Friction: a number, (N,) or (N, feet).
    mass
        Of each robot: a number or (N,) [kg].
    dt
        Time between steps [s].
    facts
        Of all environments, see `audit_batch`.
    rows
        Steps that are kept until they are judged; 0 for costs alone.
    limits
        What is judged by.

    Raises
    ------
    ProblemError
        For numbers that cannot be, and at a step for shapes that do not fit.

    Examples
    --------
    >>> import numpy as np
    >>> laws = StepLaws(feet=4, mu=0.6, mass=16.3, dt=0.02)
    >>> forces = np.zeros((2, 4, 3)) + [0.0, 0.0, 40.0]
    >>> forces[1, 0] = [60.0, 0.0, 40.0]
    >>> for _ in range(50):
    ...     cost = laws(forces, np.zeros((2, 4)), np.zeros((2, 4, 3)))
    >>> cost.total.round(3).tolist()
    [0.0, 0.225]
    >>> laws.report().verdicts
    ('lawful', 'broken')
    """

    def __init__(
        self, feet: int | Sequence[str], mu: Any, mass: Any, dt: float, *,
        facts: Mapping[str, Any] | None = None, rows: int = ROWS, limits: AuditLimits = LIMITS,
    ) -> None:  # fmt: skip
        self.names = () if isinstance(feet, int | np.integer) else name_list("StepLaws", "feet", feet)
        self.feet = whole_number(
            "feet", feet if isinstance(feet, int | np.integer) else len(self.names), low=1
        )
        self.dt, self.limits = positive_number("dt", dt, "s"), limits
        self.mu, self.mass = real_array("mu", mu), real_array("mass", mass)
        if not (np.isfinite(self.mass) & (self.mass > 0.0)).all() or self.mass.ndim > 1:
            raise ProblemError("mass must be positive [kg], one number or (N,)")
        if not (self.mu >= 0.0).all() or self.mu.ndim > 2:
            raise ProblemError("mu must be >= 0, a number, (N,) or (N, feet)")
        self._facts, self._room = facts, whole_number("rows", rows)
        self._kept: list[tuple[FloatArray, ...]] = []
        self._done: list[Any] = []
        self._channels: tuple[str, ...] = ()
        self._reports: list[BatchReport] = []
        self._own: tuple[str, Any, Any] | None = None

    def __call__(self, forces: Any, gaps: Any = None, velocities: Any = None) -> StepCost:
        """Return the cost of a step, and keep the step.

        Parameters
        ----------
        forces
            (N, feet, 3) in contact axes [N].
        gaps, velocities
            (N, feet) [m] and (N, feet, 3) [m/s], in every step or in none.
        """
        self._check(forces, gaps, velocities)
        mu, weight = self._constants(forces)
        if self._room:
            self._keep(forces, gaps, velocities)
        return step_cost(forces, gaps, velocities, mu, weight, self.limits)

    def reset(self, done: Any) -> None:
        """Say which environments (N,) ended an episode with the last step."""
        if not self._kept:
            return
        ended = np.asarray(host_array("done", done)) != 0
        if ended.shape != self._kept[-1][0].shape[:1]:
            raise ProblemError(f"done must have shape ({len(self._kept[-1][0])},), got {ended.shape}")
        self._done[-1] = self._done[-1] | ended

    def report(self) -> BatchReport:
        """Return the audit of all steps so far.

        Raises
        ------
        ProblemError
            If no step was kept.
        """
        if self._kept:
            self._judge()
        if not self._reports:
            raise ProblemError("no step was kept: call it with a step's forces first, and rows > 0")
        self._reports = [join_reports(self._reports)]
        return self._reports[0]

    def _check(self, forces: Any, gaps: Any, velocities: Any) -> None:
        """Raise unless a step's arrays fit."""
        shape = tuple(getattr(forces, "shape", ()))
        if len(shape) != 3 or shape[1:] != (self.feet, 3):
            raise ProblemError(f"forces must have shape (N, {self.feet}, 3), got {shape}")
        for name, array, wanted in (("gaps", gaps, shape[:2]), ("velocities", velocities, shape)):
            has = tuple(getattr(array, "shape", ()))
            if array is not None and has != wanted:
                raise ProblemError(f"{name} must have shape {wanted}, got {has}")
        for name, array in (("forces", forces), ("gaps", gaps), ("velocities", velocities)):
            if isinstance(array, np.ndarray):  # what is on a device stays there
                host_array(name, array)
        for name, array in (("mu", self.mu), ("mass", self.mass)):
            if array.ndim and len(array) != shape[0]:
                raise ProblemError(f"{name} is that of {len(array)} environments, forces has {shape[0]}")

    def _constants(self, like: Any) -> tuple[Any, Any]:
        """Return friction and weights in the framework, on the device and in the precision of an array."""
        framework = array_module(like).__name__
        if self._own is None or self._own[0] != framework:
            mu = self.mu[:, None] if self.mu.ndim == 1 else self.mu
            self._own = framework, _as(like, mu), _as(like, self.mass * GRAVITY)
        return self._own[1], self._own[2]

    def _keep(self, *arrays: Any) -> None:
        """Keep a step, and judge those that are kept when there are enough."""
        names = ("forces", "gaps", "contact_velocities")
        channels = tuple(name for name, array in zip(names, arrays, strict=True) if array is not None)
        if self._kept and channels != self._channels:
            before, now = ", ".join(self._channels), ", ".join(channels)
            raise ProblemError(f"steps so far had {before}, this one {now}")
        self._channels = channels
        step = tuple(np.array(host_array("step", array)) for array in arrays if array is not None)
        self._kept.append(step)
        self._done.append(np.zeros(len(step[0]), dtype=bool))
        size = sum(array.nbytes for array in step)
        if len(self._kept) >= max(2, min(self._room, MEMORY // size)):
            self._judge()

    def _judge(self) -> None:
        """Judge the steps that are kept, and let go of them."""
        arrays = {name: np.stack([step[k] for step in self._kept]) for k, name in enumerate(self._channels)}
        self._reports.append(
            audit_batch(
                arrays, self.dt, self.mu, mass=self.mass, done=np.stack(self._done), facts=self._facts,
                feet=self.names, limits=self.limits,
            ).without_rows()
        )  # fmt: skip
        if len(self._reports) > 1:
            self._reports = [join_reports(self._reports)]
        self._kept, self._done = [], []


def _as(like: Any, values: FloatArray) -> Any:
    """Return numbers as an array of another's framework, device and precision."""
    xp = array_module(like)
    if xp is np:
        return np.asarray(values, dtype=np.result_type(np.asarray(like).dtype, np.float32))
    if xp.__name__ == "torch":
        return xp.as_tensor(values, dtype=like.dtype, device=like.device)
    return xp.asarray(values, dtype=like.dtype)
