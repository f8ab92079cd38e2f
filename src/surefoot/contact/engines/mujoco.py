"""MuJoCo's words: solref and solimp, which mean a stiffness only together with a mass and a load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from surefoot.contact.engines.engine import EngineContact, Situation
from surefoot.contact.engines.physical import linear
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.mujoco import IMPEDANCE_RANGE, MujocoLaw
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class MujocoContact(EngineContact):
    """A geom's solref and solimp.

    Attributes
    ----------
    solref
        (time constant [s], damping ratio) or (-stiffness [1/s²], -damping [1/s]).
    solimp
        (d_min, d_max, width [m], midpoint, power).
    """

    engine: ClassVar[str] = "mujoco"
    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, ...] = (0.9, 0.95, 0.001, 0.5, 2.0)

    def __post_init__(self) -> None:
        MujocoLaw(self.solref, self.solimp)  # its checks are ours

    def law(self, situation: Situation) -> SoftLaw:
        """Return what these parameters do to the situation's mass under its weight, refsafe on."""
        return MujocoLaw(self.solref, self.solimp, situation.mass, -situation.gravity, situation.dt)

    @classmethod
    def from_law(cls, law: SoftLaw, situation: Situation) -> tuple[EngineContact, list[str]]:
        """Return direct solref and constant impedance d: rest depth exact, frequency to d/2.

        With d_min = d_max = d and solref = (-s, -c), a mass m rests at (1 - d) g / s and moves as on a spring
        m s with a damper m c. So s = (1 - d) K / m; the smaller d, the less rest and motion disagree.
        """
        d = situation.impedance
        if not IMPEDANCE_RANGE[0] <= d <= IMPEDANCE_RANGE[1]:
            raise ProblemError(
                f"impedance must be between {IMPEDANCE_RANGE[0]:g} and {IMPEDANCE_RANGE[1]:g}, got {d:g}"
            )
        own = law.words("mujoco")
        if own is not None and (own.pop("mass"), own.pop("gravity")) == (situation.mass, situation.gravity):
            return cls(**own), []
        stiffness, damping, lost = linear(law, situation)
        share = 1.0 - d if situation.keep == "rest" or d <= 0.05 else 1.0
        found = cls((-share * stiffness / situation.mass, -damping / situation.mass), (d, d, 0.001, 0.5, 2.0))
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
        return found, lost
