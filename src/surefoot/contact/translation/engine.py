"""Contact parameters in one engine's words, and the table of engines.

Steps of Drake, PhysX and Bullet are implicit: they take the overlap at the step's end, which adds k dt to
the damping d of a spring k. Of two bodies Drake's stiffness is k1 k2 / (k1 + k2), dissipation is weighed
by the other's stiffness, relaxation times add up ("Hydroelastic contact"; `MultibodyPlant`, "Modeling of
contact"). What its step cannot resolve SAP takes for nearly rigid: 1 / (dt (dt + tau) k) is at least
1 / (4 π² m) (A. Castro et al., "An unconstrained convex formulation of compliant contact", IEEE T-RO 2022,
with beta = 1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from surefoot.base.errors import ProblemError, check_name
from surefoot.contact.laws.soft.hunt_crossley import HuntCrossley
from surefoot.contact.laws.soft.mujoco import IMPEDANCE_RANGE, MujocoLaw
from surefoot.contact.laws.soft.soft_law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper
from surefoot.contact.translation.fitting import Situation, hunt_crossley, implicit_linear, linear

Fit = Callable[[SoftLaw, Situation], tuple[float, float, list[str]]]
"""Two numbers that stand for a law, and in words what is lost."""
Words = dict[str, Any]


class Engine(NamedTuple):
    """An engine's words for a contact.

    Attributes
    ----------
    law
        (situation, **words) -> the law that the engine makes of them; its parameters are the words.
    words
        (law, situation) -> the words that come closest to a law, and what is lost.
    each_body
        **words -> further settings: of each of two equal bodies, or of the engine.
    implicit
        Whether the engine's implicit step adds damping that its words cannot take off again.
    """

    law: Callable[..., SoftLaw]
    words: Callable[[SoftLaw, Situation], tuple[Words, list[str]]]
    each_body: Callable[..., Words] = lambda **_: {}
    implicit: bool = False


@dataclass(frozen=True)
class EngineContact:
    """Contact parameters in one engine's words.

    Attributes
    ----------
    engine
        A name in `ENGINES`.
    words
        Parameter -> value.

    Raises
    ------
    ProblemError
        For an unknown engine (the message lists the names), or values that mean no contact.
    """

    engine: str
    words: Mapping[str, Any]

    def __post_init__(self) -> None:
        check_name("engine", self.engine, ENGINES)
        self.law(Situation(mass=1.0))  # its checks are ours

    def law(self, situation: Situation) -> SoftLaw:
        """Return the contact law that the engine makes of them."""
        return ENGINES[self.engine].law(situation, **self.words)

    def settings(self) -> Words:
        """Return the parameters as the engine's own fields."""
        return {**self.words, **ENGINES[self.engine].each_body(**self.words)}


def two_words(
    first: str, second: str, fit: Fit, *said: str
) -> Callable[[SoftLaw, Situation], tuple[Words, list[str]]]:
    """Return what words a law by the two numbers of a fit; `said` is lost whatever the law."""

    def words(law: SoftLaw, situation: Situation) -> tuple[Words, list[str]]:
        one, other, lost = fit(law, situation)
        return {first: one, second: other}, [*lost, *said]

    return words


def _spring(situation: Situation, stiffness: float, damping: float) -> SoftLaw:
    """Return a linear spring [N/m] and damper [N s/m], cut where it would pull."""
    return SpringDamper(stiffness, damping)


def _hunt_crossley(situation: Situation, stiffness: float, dissipation: float) -> SoftLaw:
    """Return f = stiffness depth (1 + dissipation rate): [N/m], [s/m]."""
    return HuntCrossley(stiffness, dissipation)


def _mujoco(
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


def _mujoco_words(given: SoftLaw, situation: Situation) -> tuple[dict[str, Any], list[str]]:
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


def _drake(situation: Situation, point_stiffness: float, relaxation_time: float) -> SoftLaw:
    """Return f = point_stiffness (depth + relaxation_time rate), [N/m], [s], softened by SAP."""
    step = situation.dt
    regularised = step * (step + relaxation_time) * point_stiffness
    rigid = 4.0 * math.pi**2 * situation.mass
    stiffness = point_stiffness * min(1.0, rigid / regularised if regularised else 1.0)
    return SpringDamper(stiffness, stiffness * (relaxation_time + step))


def _drake_words(law: SoftLaw, situation: Situation) -> tuple[Words, list[str]]:
    stiffness, damping, lost = implicit_linear(law, situation)
    return {"point_stiffness": stiffness, "relaxation_time": damping / stiffness}, lost


def _each_in_drake(point_stiffness: float, relaxation_time: float) -> Words:
    """Return the proximity properties of each of two equal bodies: in series, halves of the time."""
    own = {"point_contact_stiffness": 2.0 * point_stiffness, "relaxation_time": 0.5 * relaxation_time}
    return {"discrete_contact_approximation": "sap", "each_body": own}


def _drake_hunt_crossley(
    situation: Situation, point_stiffness: float, hunt_crossley_dissipation: float
) -> SoftLaw:
    """Return Hunt and Crossley's law of exponent 1, of "tamsi", "similar", "lagged" and continuous time."""
    return HuntCrossley(point_stiffness, hunt_crossley_dissipation)


def _each_in_lagged(point_stiffness: float, hunt_crossley_dissipation: float) -> Words:
    own = {
        "point_contact_stiffness": 2.0 * point_stiffness,
        "hunt_crossley_dissipation": hunt_crossley_dissipation,
    }
    return {"discrete_contact_approximation": "lagged", "each_body": own}


def _compliant(
    situation: Situation, compliant_contact_stiffness: float, compliant_contact_damping: float
) -> SoftLaw:
    """Return the implicit spring [N/m] and damper [N s/m] of a PhysX material (its restitution is idle)."""
    k = compliant_contact_stiffness
    return SpringDamper(k, compliant_contact_damping + situation.dt * k)


COMPLIANT = "compliant_contact_stiffness", "compliant_contact_damping", implicit_linear
PER_POINT = "a stiffness counts per contact point: PhysX gives a flat sole up to four, which share the load"


def _material(
    situation: Situation,
    compliant_contact_stiffness: float,
    compliant_contact_damping: float,
    static_friction: float = 0.6,
    dynamic_friction: float = 0.6,
) -> SoftLaw:
    """Return the same of the fields of Isaac Lab's `RigidBodyMaterialCfg`."""
    return _compliant(situation, compliant_contact_stiffness, compliant_contact_damping)


def _material_words(law: SoftLaw, situation: Situation) -> tuple[Words, list[str]]:
    words, lost = two_words(*COMPLIANT, PER_POINT)(law, situation)
    return {**words, "static_friction": law.friction.mu, "dynamic_friction": law.friction.mu}, lost


def _material_modes(**_: float) -> Words:
    return {
        "restitution": 0.0,
        **dict.fromkeys(("friction_combine_mode", "restitution_combine_mode"), "average"),
    }


def _bullet(situation: Situation, contactStiffness: float, contactDamping: float) -> SoftLaw:
    """Return the spring [N/m] and damper [N s/m] of Bullet's implicit step."""
    return SpringDamper(contactStiffness, contactDamping + situation.dt * contactStiffness)


def _each_in_bullet(contactStiffness: float, contactDamping: float) -> Words:
    """Return `changeDynamics` for each of two equal bodies: stiffnesses in series, dampings added."""
    return {"each_body": {"contactStiffness": 2.0 * contactStiffness, "contactDamping": 0.5 * contactDamping}}


IN_SERIES = (
    "Bullet puts both bodies' stiffnesses in series and adds their dampings: each_body is for two "
    "equal ones, and a ground that was given none is rigid only if it is given a large stiffness"
)
ENGINES: dict[str, Engine] = {
    "physical": Engine(_spring, two_words("stiffness", "damping", linear)),
    "hunt-crossley": Engine(_hunt_crossley, two_words("stiffness", "dissipation", hunt_crossley)),
    "mujoco": Engine(_mujoco, _mujoco_words),
    "drake": Engine(_drake, _drake_words, _each_in_drake),
    "drake-hunt-crossley": Engine(
        _drake_hunt_crossley,
        two_words("point_stiffness", "hunt_crossley_dissipation", hunt_crossley),
        _each_in_lagged,
        implicit=True,
    ),
    "physx": Engine(_compliant, two_words(*COMPLIANT, PER_POINT)),
    "isaaclab": Engine(_material, _material_words, _material_modes),
    "bullet": Engine(
        _bullet, two_words("contactStiffness", "contactDamping", implicit_linear, IN_SERIES), _each_in_bullet
    ),
}
"""An engine is one line here, and its words are the parameters of its law."""
