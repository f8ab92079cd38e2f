"""The world of a simulated run, made of its options and of what its scenario says of the ground."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from surefoot.base.errors import ProblemError, check_name, unknown_name
from surefoot.worlds.interface.world_names import WORLDS

if TYPE_CHECKING:
    from surefoot.app.cli.options import RunOptions
    from surefoot.app.cli.scenario_file import ScenarioFile
    from surefoot.laws import SoftLaw
    from surefoot.mechanics import Robot, Terrain
    from surefoot.worlds.interface.world import World
    from surefoot.worlds.mujoco.mujoco_world import MujocoWorld

_PLAIN = {"collision": "feet", "actuators": "ideal"}
"""What every world is unless asked for more."""
_OWNERS = {
    "law": ("rigid",), "solref": ("mujoco",), "solimp": ("mujoco",), "substeps": ("mujoco", "mujoco-exact"),
    "collision": ("mujoco", "mujoco-exact", "rigid"), "actuators": ("mujoco", "mujoco-exact", "rigid"),
}  # fmt: skip
"""What is said -> the worlds that take it."""
_IN_A_FILE = ("solref", "solimp", "substeps", "collision")
"""What the world of an MJCF file takes."""


def contact_law(said: Mapping[str, Any], mu: float) -> SoftLaw:
    """Return the soft law of a scenario, with exact friction.

    >>> contact_law({"name": "spring-damper", "stiffness": 2e4, "damping": 100.0}, 0.6).stiffness
    20000.0
    """
    from surefoot import laws
    from surefoot.app.cli.scenario_keys import Law

    makers: dict[str, Any] = {
        "spring-damper": laws.SpringDamper, "hunt-crossley": laws.HuntCrossley, "hertz": laws.Hertz,
        "sphere": laws.Hertz.sphere, "mujoco": laws.MujocoLaw,
    }  # fmt: skip
    name, values = said["name"], {key: value for key, value in said.items() if key != "name"}
    maker = makers[name]
    takes = inspect.signature(maker).parameters
    for key in values:
        if key not in takes:
            known = takes.keys() & Law.__annotations__.keys()
            raise ProblemError(unknown_name(f"parameter of the law {name}", key, known))
    missing = [key for key, one in takes.items() if one.default is one.empty and key not in values]
    if missing:
        raise ProblemError(f"the law {name} needs {', '.join(missing)}")
    return cast("SoftLaw", replace(maker(**values), friction=laws.ExactFriction(mu)))


def world_settings(asked: RunOptions, said: ScenarioFile) -> dict[str, Any]:
    """Return what options and scenario say to the world, or raise for what it does not have."""
    check_name("world", asked.world, WORLDS)
    given = {name: getattr(asked if name in _PLAIN else said, name) for name in _OWNERS}
    settings = {name: value for name, value in given.items() if value != _PLAIN.get(name)}
    for name, value in settings.items():
        option = f"--{name} {value}" if name in _PLAIN else name
        if asked.world not in _OWNERS[name]:
            owners = " or ".join(_OWNERS[name])
            raise ProblemError(f"{option} is of --world {owners}, got --world {asked.world}")
        if asked.world_file is not None and name not in _IN_A_FILE:
            raise ProblemError(f"{asked.robot} is a world of its own: it goes without {option}")
    if said.law is not None:
        settings["law"] = contact_law(said.law, asked.mu)
    return settings


def build_world(asked: RunOptions, robot: Robot, terrain: Terrain, settings: dict[str, Any]) -> World:
    """Return the world; `settings` are those of `world_settings`."""
    from surefoot.worlds.interface.world_names import make_world

    (mass, place), file, mu = asked.payload_mass, asked.world_file, asked.mu
    parts = settings.pop("substeps", 1)
    at = {"payload_position": place} if any(place) else {}
    if file is None:
        world = make_world(asked.world, robot, terrain, mu, payload=mass, **at, **settings)
    else:
        from surefoot.worlds.mujoco.mjcf_world import MjcfWorld

        exact = asked.world == "mujoco-exact"
        settings = {"collision": "feet", "payload_position": place, "exact": exact, **settings}
        world = MjcfWorld(robot, file, terrain, mu, payload=mass, **settings)
    if parts != 1 or file is not None:  # only MuJoCo's is asked
        cast("MujocoWorld", world).divide(parts)
    return world
