"""MuJoCo's words: solref and solimp, which mean a stiffness only together with a mass and a load."""

from __future__ import annotations

from typing import Any

from surefoot.contact.engines.fitting import linear
from surefoot.contact.engines.situation import Situation
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.mujoco import IMPEDANCE_RANGE, MujocoLaw
from surefoot.errors import ProblemError


def law(
    situation: Situation,
    solref: tuple[float, float] = (0.02, 1.0),
    solimp: tuple[float, ...] = (0.9, 0.95, 0.001, 0.5, 2.0),
) -> SoftLaw:
    """Return what these parameters do to the situation's mass under its weight, refsafe on.

    Parameters
    ----------
    situation
        For which mass, weight and step.
    solref
        (time constant [s], damping ratio) or (-stiffness [1/s²], -damping [1/s]).
    solimp
        (d_min, d_max, width [m], midpoint, power).
    """
    return MujocoLaw(solref, solimp, situation.mass, -situation.gravity, situation.dt)


def words(given: SoftLaw, situation: Situation) -> tuple[dict[str, Any], list[str]]:
    """Return direct solref and constant impedance d: rest depth exact, frequency to d/2; and what is lost.

    With d_min = d_max = d and solref = (-s, -c), a mass m rests at (1 - d) g / s and moves as on a spring m s
    with a damper m c. So s = (1 - d) K / m; the smaller d, the less rest and motion disagree.
    """
    d = situation.impedance
    if not IMPEDANCE_RANGE[0] <= d <= IMPEDANCE_RANGE[1]:
        raise ProblemError(
            f"impedance must be between {IMPEDANCE_RANGE[0]:g} and {IMPEDANCE_RANGE[1]:g}, got {d:g}"
        )
    own = given.words("mujoco")
    if own is not None and (own.pop("mass"), own.pop("gravity")) == (situation.mass, situation.gravity):
        return own, []
    stiffness, damping, lost = linear(given, situation)
    share = 1.0 - d if situation.keep == "rest" or d <= 0.05 else 1.0
    solref = -share * stiffness / situation.mass, -damping / situation.mass
    lost.append(
        f"the force is proportional to the effective mass: right for {situation.mass:g} kg "
        "at this contact only"
    )
    if share == 1.0:
        lost.append(
            f"rest depth: {1.0 - d:.3g} of the law's, MuJoCo takes the share d of the weight for nothing"
        )
    elif d > 1e-4:
        lost.append(
            f"frequency: {50.0 * d:.3g} % low, by the share d of the weight that MuJoCo gives for nothing"
        )
    if d < 0.5:
        lost.append(
            f"sticking: with impedance {d:g} friction yields like a damper of {damping:.4g} N s/m "
            "before it holds; raise impratio, or take a larger impedance and keep the motion alone"
        )
    return {"solref": solref, "solimp": (d, d, 0.001, 0.5, 2.0)}, lost
