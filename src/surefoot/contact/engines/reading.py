"""Read an engine's contact parameters from names and values, as a user types them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any

from surefoot.arrays import finite_array, real_number
from surefoot.contact.engines.engine import ENGINES, EngineContact
from surefoot.contact.laws.soft.hunt_crossley import Hertz, HuntCrossley
from surefoot.contact.laws.soft.law import SoftLaw
from surefoot.contact.laws.soft.spring_damper import SpringDamper
from surefoot.errors import ProblemError, check_name


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
