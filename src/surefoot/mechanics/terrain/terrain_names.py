"""Terrains by name, one line each: what the command line reads."""

from __future__ import annotations

from collections.abc import Callable

from surefoot.base.errors import ProblemError
from surefoot.base.text_files import finite_in_text
from surefoot.mechanics.terrain.flat import FlatTerrain
from surefoot.mechanics.terrain.pit import PitTerrain
from surefoot.mechanics.terrain.rough import rough_ground
from surefoot.mechanics.terrain.slope import SlopeTerrain
from surefoot.mechanics.terrain.stairs import StairsTerrain
from surefoot.mechanics.terrain.terrain import Terrain

TERRAINS: dict[str, tuple[str, Callable[..., Terrain]]] = {
    "flat": ("", FlatTerrain),
    "slope": ("DEG", SlopeTerrain),
    "stairs": ("HEIGHT,DEPTH", StairsTerrain),
    "rough": ("SEED,HEIGHT", rough_ground),
    "pit": ("START,LENGTH,DEPTH", PitTerrain),
}
"""Name to the numbers that follow it (angles in degrees, lengths in metres), and what takes them."""


def terrain_forms() -> str:
    """Return the forms of a terrain's text, for help and error messages.

    >>> terrain_forms()[:21]
    'flat, slope:DEG, stai'
    """
    return ", ".join(f"{name}:{numbers}" if numbers else name for name, (numbers, _) in TERRAINS.items())


def read_terrain(text: str, name: str = "terrain") -> Terrain:
    """Return the terrain of a text such as "flat", "slope:20" or "stairs:0.12,0.25".

    Parameters
    ----------
    text
        A name of `TERRAINS` and, behind a colon, its numbers.
    name
        What the text is called in error messages.

    Raises
    ------
    ProblemError
        For another form or a number that is not finite; from the terrain for numbers it cannot take.

    Examples
    --------
    >>> read_terrain("slope:15")
    SlopeTerrain(15)
    """
    kind, _, rest = text.partition(":")
    given = rest.split(",") if rest else []
    numbers, make = TERRAINS.get(kind, (None, None))
    if make is None or numbers is None or len(given) != len(numbers.split(",") if numbers else []):
        raise ProblemError(f"{name} {text!r} is not one of: {terrain_forms()}")
    return make(*(finite_in_text(name, part) for part in given))
