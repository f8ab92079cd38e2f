"""Ground that the loops stand on, and things that fall on robots or hit them, as MJCF."""

from __future__ import annotations

from dataclasses import dataclass

FAR = 40.0
"""Where things wait that are not needed yet [m]."""
DECK = "rgba='.55 .57 .6 1'"
ICE = "rgba='.7 .85 .95 1'"


@dataclass(frozen=True)
class Ground:
    """What a robot stands on.

    Attributes
    ----------
    mu
        Friction of the ground, which counts for every foot.
    slope
        Its tilt about y [rad]: positive falls towards +x.
    ice
        Where a patch with friction `ice_mu` begins in x, and its length [m]; None for none.
    edge
        Where a step begins in x, and its height, negative for a drop [m]; None for none.
    solref, solimp
        Of all contacts with it.
    thick
        Whether flat ground is a box instead of a plane.
    """

    mu: float = 0.8
    slope: float = 0.0
    ice: tuple[float, float] | None = None
    ice_mu: float = 0.03
    edge: tuple[float, float] | None = None
    solref: str = "0.01 1"
    solimp: str = "0.95 0.99 0.001"
    thick: bool = False

    def geoms(self) -> str:
        """Return the MJCF of its geoms."""
        common = f"priority='1' condim='4' solref='{self.solref}' solimp='{self.solimp}'"
        dry = f"{common} friction='{self.mu} 0.01 0.0001' {DECK}"
        wet = f"{common} friction='{self.ice_mu} 0.001 0.0001' {ICE}"
        if self.ice is not None:
            begin, end = self.ice[0], sum(self.ice)
            return (
                slab("deck", -6.0, begin, 0.0, dry)
                + slab("ice", begin, end, 0.0, wet)
                + slab("beyond", end, end + 6.0, 0.0, dry)
            )
        if self.edge is not None:
            at, height = self.edge
            return slab("deck", -6.0, at, 0.0, dry) + slab("terrace", at, at + 8.0, height, dry)
        if self.thick:
            return f"<geom name='deck' type='box' size='8 8 .5' pos='0 0 -.5' {dry}/>".replace(
                "pos='0 0 -.5'", f"euler='0 {self.slope} 0' pos='{tilted(-0.5, self.slope)}'"
            )
        return f"<geom name='deck' type='plane' size='20 20 1' euler='0 {self.slope} 0' {dry}/>"


def tilted(height: float, slope: float) -> str:
    """Return a point at a height over a tilted plane through the origin, as MJCF writes it."""
    from math import cos, sin

    return f"{height * sin(slope)} 0 {height * cos(slope)}"


def slab(name: str, begin: float, end: float, top: float, properties: str) -> str:
    """Return a box of ground from x to x [m] with its top at a height [m]."""
    half, middle = 0.5 * (end - begin), 0.5 * (begin + end)
    return f"<geom name='{name}' type='box' size='{half} 6 .5' pos='{middle} 0 {top - 0.5}' {properties}/>"


def sack(mass: float, half: float = 0.06, name: str = "sack") -> str:
    """Return a box that waits far away until it is put over a robot."""
    return (
        f"<body name='{name}' pos='{FAR} {FAR / 2} {half}'><freejoint/>"
        f"<geom name='{name}_skin' type='box' size='{half} {half} {half}' mass='{mass}' friction='1.2'/>"
        "</body>"
    )


def ball(mass: float, radius: float = 0.06, name: str = "ball") -> str:
    """Return a ball that waits far away until it is thrown."""
    return (
        f"<body name='{name}' pos='{FAR} {-FAR / 2} {radius}'><freejoint/>"
        f"<geom name='{name}_skin' type='sphere' size='{radius}' mass='{mass}'/></body>"
    )
