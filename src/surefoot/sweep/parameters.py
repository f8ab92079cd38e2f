"""What a sweep can draw, one line each: name, unit, the values that make sense, and the value it replaces."""

from __future__ import annotations

import math
from dataclasses import dataclass

from surefoot.arrays import real_number
from surefoot.errors import ProblemError


@dataclass(frozen=True)
class Parameter:
    """A number that a sweep can draw.

    Attributes
    ----------
    unit
        Empty for none.
    low, high
        Values that make sense, both included; `low` is excluded where `positive`.
    meaning
        In a few words.
    positive
        Whether zero is no value.
    """

    unit: str
    low: float
    high: float
    meaning: str
    positive: bool = False

    def checked(self, name: str, value: object) -> float:
        """Return a value as a float.

        Raises
        ------
        ProblemError
            Naming the value, if it is no finite number or makes no sense.
        """
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise ProblemError(f"{name} must be a number, got {value!r:.60}")
        number = real_number(name, float("nan") if value == "" else value, low=self.low, high=self.high)  # type: ignore[arg-type]
        if not math.isfinite(number) or (self.positive and number == 0.0):
            wanted = "positive and finite" if self.positive else "finite"
            raise ProblemError(f"{name} must be {wanted}, got {number:g}")
        return number


PARAMETERS: dict[str, Parameter] = {
    "mu": Parameter("", 0.0, 1e3, "friction of the ground"),
    "restitution": Parameter("", 0.0, 1.0, "Newton's, of rigid ground"),
    "stiffness": Parameter("N/m", 0.0, 1e12, "of a spring-damper ground (rigid world)", True),
    "damping": Parameter("N s/m", 0.0, 1e9, "of a spring-damper ground (rigid world)"),
    "time_constant": Parameter("s", 0.0, 10.0, "solref's first number (MuJoCo)", True),
    "damping_ratio": Parameter("", 0.0, 100.0, "solref's second number (MuJoCo)", True),
    "mass": Parameter("x nominal", 1e-3, 1e3, "all masses and, with them, inertias"),
    "inertia": Parameter("x nominal", 1e-3, 1e3, "rotational inertias about the links' own centres of mass"),
    "com_x": Parameter("m", -10.0, 10.0, "shift of the base's centre of mass, forward"),
    "com_y": Parameter("m", -10.0, 10.0, "shift of the base's centre of mass, left"),
    "com_z": Parameter("m", -10.0, 10.0, "shift of the base's centre of mass, up"),
    "payload": Parameter("kg", 0.0, 1e4, "point mass on the base"),
    "motor_strength": Parameter("x nominal", 0.0, 10.0, "torque given over torque asked for"),
    "delay": Parameter("s", 0.0, 1.0, "between measurement and torques"),
    "noise": Parameter("", 0.0, 100.0, "of the sensors, 1 for ordinary ones"),
    "push_x": Parameter("N", -1e5, 1e5, "push on the base, forward"),
    "push_y": Parameter("N", -1e5, 1e5, "push on the base, left"),
    "slope": Parameter("deg", -80.0, 80.0, "ground that rises along +x"),
    "roughness": Parameter("m", 0.0, 10.0, "height of rough ground, another one for each sample"),
    "speed": Parameter("m/s", -10.0, 10.0, "forward velocity that is commanded"),
    "believed_mu": Parameter("", 0.0, 1e3, "friction that the controller believes in"),
}  # fmt: skip
"""Name to parameter. The order is that of the Sobol sequence's dimensions, whatever the file's order."""

TERRAIN = "terrain"
"""The one parameter that is a choice of texts, those of `surefoot.terrain.TERRAINS`."""
