"""Level ground."""

from __future__ import annotations

from surefoot.mechanics.terrain.slope import SlopeTerrain


class FlatTerrain(SlopeTerrain):
    """The plane z = 0."""

    def __init__(self) -> None:
        super().__init__(0.0)

    def __repr__(self) -> str:
        return "FlatTerrain()"

    @property
    def text(self) -> str:
        """See `Terrain.text`."""
        return "flat"
