"""Contact parameters as a user types them, in another engine's words, and what is lost on the way."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from surefoot.base.arrays import finite_array, of_kind, real_number
from surefoot.base.errors import ProblemError, check_name
from surefoot.base.spatial import GRAVITY
from surefoot.contact.laws.soft.behaviour import MassOnContact, behaviour
from surefoot.contact.laws.soft.hunt_crossley import Hertz, HuntCrossley
from surefoot.contact.laws.soft.soft_law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper
from surefoot.contact.translation.engine import ENGINES, EngineContact
from surefoot.contact.translation.fitting import Situation


def _bouncing_spring(mass: float, speed: float, stiffness: float, restitution: float) -> SoftLaw:
    return SpringDamper.bouncing(stiffness, restitution, mass)


def _bouncing_hunt_crossley(mass: float, speed: float, stiffness: float, restitution: float) -> SoftLaw:
    return HuntCrossley.bouncing(stiffness, restitution, speed)


def _hertz(
    mass: float, speed: float, radius: float, modulus: float, poisson: float = 0.5, dissipation: float = 0.0
) -> SoftLaw:
    return Hertz.sphere(radius, modulus, poisson, dissipation)


_RECIPES: dict[tuple[str, str], Callable[..., SoftLaw]] = {
    ("physical", "restitution"): _bouncing_spring,
    ("hunt-crossley", "restitution"): _bouncing_hunt_crossley,
    ("hertz", ""): _hertz,
}
"""(source, name that calls for it, "" always) -> law made of other words than its own."""


def source_names() -> list[str]:
    """Return what contact parameters can be read from."""
    return sorted({*ENGINES, *(name for name, _ in _RECIPES)})


def read_contact(
    source: str, values: Mapping[str, Any], *, mass: float, speed: float
) -> SoftLaw | EngineContact:
    """Return the contact that a source's parameters describe.

    Parameters
    ----------
    source
        An engine's name, or "hertz".
    values
        Parameter -> number, or numbers for MuJoCo's solref and solimp. "physical" and "hunt-crossley" take a
        restitution in place of their damping.
    mass, speed
        Effective mass [kg] and impact speed [m/s] at which a restitution holds.

    Raises
    ------
    ProblemError
        For a source or parameter that is not known (the message lists the names), or one that is missing.

    Examples
    --------
    >>> read_contact("physical", {"stiffness": 1e4, "damping": 20.0}, mass=1.0, speed=1.0)
    EngineContact(engine='physical', words={'stiffness': 10000.0, 'damping': 20.0})
    """
    check_name("source", source, source_names())
    recipe = next((r for (s, key), r in _RECIPES.items() if s == source and (not key or key in values)), None)
    maker: Callable[..., SoftLaw] = recipe if recipe is not None else ENGINES[source].law
    given_apart = ("mass", "speed", "situation")
    parameters = {n: p for n, p in inspect.signature(maker).parameters.items() if n not in given_apart}
    for name in values:
        check_name(f"parameter of {source}", name, parameters)
    missing = [n for n, p in parameters.items() if p.default is p.empty and n not in values]
    if missing:
        raise ProblemError(f"{source} needs {', '.join(missing)} (got {', '.join(values) or 'nothing'})")
    given = {name: _number(name, value, parameters[name].default) for name, value in values.items()}
    return EngineContact(source, given) if recipe is None else recipe(mass, speed, **given)


def _number(name: str, value: Any, default: Any) -> Any:
    """Return a number, or a tuple where the parameter is one."""
    if isinstance(default, tuple):
        return tuple(float(x) for x in finite_array(name, value).ravel())
    return real_number(name, value, low=0.0, high=1e300)


AGREED = 0.01
"""Relative difference up to which two contacts agree."""


class Comparison(NamedTuple):
    """One number of two contacts, side by side.

    Attributes
    ----------
    given, translated
        Its values.
    agrees
        Whether they differ by at most 1 %.
    """

    given: float
    translated: float
    agrees: bool

    def proven(self, measured: float | None) -> bool:
        """Return whether what an engine was seen to do is what was given, too; None where it was not run."""
        return self.agrees and (measured is None or _compare(self.given, measured).agrees)


@dataclass(frozen=True)
class Translation:
    """Contact parameters in another engine's words.

    Attributes
    ----------
    contact
        The parameters; `contact.settings()` as the engine's fields.
    law
        What the engine makes of them.
    lost
        What the translation could not keep, in words.
    given, translated
        What the mass does on either contact.
    """

    contact: EngineContact
    law: SoftLaw
    lost: tuple[str, ...]
    given: MassOnContact
    translated: MassOnContact

    @property
    def parameters(self) -> dict[str, Any]:
        """Return the engine's fields."""
        return self.contact.settings()

    @property
    def agreement(self) -> dict[str, Comparison]:
        """Return rest depth [m], restitution, frequency [rad/s] and settling time [s] of both contacts."""
        return {
            name: _compare(getattr(self.given, name), getattr(self.translated, name))
            for name in ("rest_depth", "restitution", "frequency", "settling_time")
        }


def translate(
    law: SoftLaw | EngineContact,
    to: str,
    mass: float,
    *,
    gravity: float = GRAVITY,
    speed: float = 1.0,
    dt: float = 1e-3,
    keep: str = "motion",
    impedance: float = 1e-3,
) -> Translation:
    """Return a contact in an engine's own parameters.

    Parameters
    ----------
    law
        A soft law, or another engine's parameters.
    to
        The engine's name, see `surefoot.contact.translation.ENGINES`.
    mass
        Effective mass of the contact, 1 / G_nn [kg].
    gravity
        [m/s²].
    speed
        Impact speed at which the bounces are compared [m/s].
    dt
        The engine's step [s].
    keep
        "motion" (frequency, settling, bounce) or "rest" (depth), where both cannot be kept.
    impedance
        MuJoCo's d [-], where MuJoCo is the target: small ones keep rest and motion, large ones hold friction
        firmly.

    Raises
    ------
    ProblemError
        For an unknown engine or a number out of range.

    Examples
    --------
    >>> from surefoot.contact.laws.soft import SpringDamper
    >>> found = translate(SpringDamper(1e4, 20.0), to="physx", mass=1.0, dt=0.001)
    >>> found.parameters
    {'compliant_contact_stiffness': 10000.0, 'compliant_contact_damping': 10.0}
    """
    check_name("keep", keep, ["motion", "rest"])
    check_name("engine", to, ENGINES)
    situation = Situation(
        real_number("mass", mass, low=1e-9, high=1e9),
        real_number("gravity", gravity, low=1e-9, high=1e6),
        real_number("speed", speed, low=1e-6, high=1e6),
        real_number("dt", dt, low=0.0, high=10.0),
        keep,
        real_number("impedance", impedance, low=0.0, high=1.0),
    )
    source = law.law(situation) if isinstance(law, EngineContact) else law
    of_kind("law", source, SoftLaw)
    words, lost = ENGINES[to].words(source, situation)
    contact = EngineContact(to, words)
    made = contact.law(situation)
    given, translated = (behaviour(x, situation.mass, speed, gravity) for x in (source, made))
    for name, (a, b, agrees) in Translation(contact, made, (), given, translated).agreement.items():
        if not agrees:
            lost.append(f"{name.replace('_', ' ')}: {a:.6g} becomes {b:.6g}")
    extra = situation.mass * translated.frequency**2 * situation.dt
    if ENGINES[to].implicit and extra > AGREED * (
        damping := 2.0 * translated.ratio * translated.frequency * mass
    ):
        lost.append(
            f"settling: the engine's implicit step of {situation.dt:g} s adds {extra:.4g} N s/m of damping "
            f"to {damping:.4g}"
        )
    return Translation(contact, made, tuple(lost), given, translated)


def _compare(given: float, translated: float) -> Comparison:
    return Comparison(
        given, translated, given == translated or abs(given - translated) <= AGREED * abs(given)
    )
