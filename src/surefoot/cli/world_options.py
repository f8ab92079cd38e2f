"""Which physics a simulated run obeys: the options of its world, and what they make."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias, cast

import typer
from rich.console import Console

from surefoot.cli.console import say
from surefoot.errors import ProblemError, StiffContactWarning, unknown_name
from surefoot.simulation.worlds import WORLDS

if TYPE_CHECKING:
    from surefoot.laws import SoftLaw
    from surefoot.robot import Robot
    from surefoot.simulation.mujoco import MujocoWorld
    from surefoot.simulation.world import World
    from surefoot.terrain import Terrain

Substeps: TypeAlias = Annotated[
    int | None,
    typer.Option(
        help="Steps of MuJoCo in a millisecond; None: 16 where a blind robot may strike edges, else 1."
    ),
]

WHOLE = ("mujoco", "rigid")
"""Worlds that take whole robots: all of their links, and their actuators."""
_PLAIN = {"collision": "feet", "actuators": "ideal"}
"""What every world is unless told; other options are None then."""
_OWNERS = {
    "law": ("rigid",), "solref": ("mujoco",), "solimp": ("mujoco",), "collision": WHOLE, "actuators": WHOLE,
    "substeps": ("mujoco",),
}  # fmt: skip
"""Option -> the worlds that take it."""
_WORDS: dict[str, dict[str, str]] = {
    "spring-damper": {"k": "stiffness", "d": "damping"},
    "hunt-crossley": {"k": "stiffness", "a": "dissipation", "p": "exponent"},
    "hertz": {"k": "stiffness", "a": "dissipation", "radius": "", "modulus": "", "poisson": ""},
    "mujoco": {"tc": "", "zeta": "", "mass": "", "dmin": "", "dmax": "", "width": ""},
}
"""Law -> the names that it takes, and what they are called in `surefoot.laws`."""


def contact_law(text: str, mu: float) -> SoftLaw:
    """Return the soft law of "NAME:KEY=VALUE,...", with exact friction.

    >>> contact_law("spring-damper:k=2e4,d=100", 0.6).stiffness
    20000.0
    """
    from surefoot import laws
    from surefoot.cli import parsing

    name, _, rest = text.partition(":")
    if name not in _WORDS:
        raise ProblemError(unknown_name("law", name, _WORDS))
    values: dict[str, float] = {}
    for part in filter(None, rest.split(",")):
        key, equals, value = part.partition("=")
        if not equals or key not in _WORDS[name]:
            raise ProblemError(f"--law {text!r}: " + unknown_name(f"parameter of {name}", key, _WORDS[name]))
        if key in values:
            raise ProblemError(f"--law {text!r}: {key} is given twice")
        values[key] = parsing.number("--law", value)
    friction = laws.ExactFriction(mu)
    named = {_WORDS[name][key] or key: value for key, value in values.items()}
    try:
        if name == "mujoco":
            pair = (named.pop("tc", 0.02), named.pop("zeta", 1.0))
            limits = (named.pop("dmin", 0.9), named.pop("dmax", 0.95), named.pop("width", 0.001))
            return laws.MujocoLaw(pair, limits, friction=friction, **named)
        if name == "hertz" and "stiffness" not in named:
            ball = laws.Hertz.sphere(**named)
            return laws.Hertz(ball.stiffness, ball.dissipation, friction=friction)
        kind: Any = {
            "spring-damper": laws.SpringDamper, "hunt-crossley": laws.HuntCrossley, "hertz": laws.Hertz,
        }[name]  # fmt: skip
        made: SoftLaw = kind(friction=friction, **named)
        return made
    except TypeError as error:
        raise ProblemError(f"--law {text!r}: {name} takes {', '.join(_WORDS[name])}: {error}") from error


@dataclass(frozen=True)
class Physics:
    """Which physics it is, and what it is told."""

    world: Annotated[str, typer.Option(help=f"Physics: {' or '.join(WORLDS)}.")] = "mujoco"
    law: Annotated[
        str | None,
        typer.Option(
            help="Soft ground of the rigid world: spring-damper:k=2e4,d=100, hunt-crossley:k=2e5,a=0.5, "
            "hertz:radius=0.02,modulus=1e7 or mujoco:tc=0.02,zeta=1,mass=4 (effective mass of a contact)."
        ),
    ] = None
    explicit: Annotated[
        bool, typer.Option("--explicit", help="Integrate --law explicitly, to see it chatter.")
    ] = False
    collision: Annotated[
        str,
        typer.Option(help="What may touch (mujoco, rigid): feet alone, or full, the whole robot and itself."),
    ] = "feet"
    actuators: Annotated[
        str,
        typer.Option(
            "--actuators", help="ideal, or real: rotors, friction and torque-speed curves (mujoco, rigid)."
        ),
    ] = "ideal"
    solref: Annotated[
        str | None, typer.Option(help="MuJoCo's TC,ZETA [s, 1] or -K,-B [1/s^2, 1/s] of the ground.")
    ] = None
    solimp: Annotated[
        str | None, typer.Option(help="MuJoCo's DMIN,DMAX,WIDTH,MIDPOINT,POWER of the ground, or fewer.")
    ] = None

    def settings(self, mu: float, substeps: int | None = None) -> dict[str, Any]:
        """Return what the options say to the world, or raise for an option that it does not have."""
        from surefoot.cli import parsing

        if self.world not in WORLDS:
            raise ProblemError(unknown_name("world", self.world, tuple(WORLDS)))
        given = {name: getattr(self, name) for name in _OWNERS if name != "substeps"}
        given["substeps"] = substeps
        told: dict[str, Any] = {name: value for name, value in given.items() if value != _PLAIN.get(name)}
        for name, value in told.items():
            if self.world not in _OWNERS[name]:
                option = f"--{name} {value}" if name in _PLAIN else f"--{name}"
                owners = " or ".join(_OWNERS[name])
                raise ProblemError(f"{option} is of --world {owners}, got --world {self.world}")
        if self.law is not None:
            told["law"] = contact_law(self.law, mu)
        for name in ("solref", "solimp"):
            if name in told:
                told[name] = tuple(parsing.number(f"--{name}", part) for part in told[name].split(","))
        if self.explicit:
            if self.law is None:
                raise ProblemError("--explicit goes with --law")
            told["integration"] = "explicit"
        return told


def build_world(
    name: str,
    robot: Robot,
    terrain: Terrain,
    mu: float,
    payload: tuple[float, tuple[float, float, float]],
    told: dict[str, Any],
    console: Console,
) -> World:
    """Return the world, `payload` being mass and place; what it says about the chosen step is printed."""
    from surefoot.simulation.worlds import make_world

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", StiffContactWarning)
        mass, place = payload
        parts = told.pop("substeps", 1)
        at = {"payload_position": place} if any(place) else {}
        world = make_world(name, robot, terrain, mu, payload=mass, **at, **told)
        if parts != 1:  # only MuJoCo's is asked
            cast("MujocoWorld", world).divide(parts)
    say(console, *(str(warning.message) for warning in said))
    return world
