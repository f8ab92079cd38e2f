"""Where a simulated robot's controller has its state from, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from surefoot.errors import check_name

if TYPE_CHECKING:
    from surefoot.simulation.sensors import SensorModel

ESTIMATORS = ("inekf", "truth")
EstimatorName: TypeAlias = Annotated[
    str,
    typer.Option(
        help="inekf: the state is estimated from IMU, encoders and torques; truth: the controller knows it."
    ),
]


def sensors_of(estimator: str, noise: float | None) -> tuple[SensorModel | None, float]:
    """Return the sensors of an estimator, None for the truth, and the level of noise on the true state.

    Raises
    ------
    ProblemError
        For an unknown name.
    """
    check_name("estimator", estimator, ESTIMATORS)
    if estimator == "truth":
        return None, 0.0 if noise is None else noise
    from surefoot.simulation.sensors import SensorModel

    return SensorModel().scaled(1.0 if noise is None else noise), 0.0
