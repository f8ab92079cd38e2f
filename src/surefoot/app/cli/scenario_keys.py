"""The keys of a scenario file with their units and bounds.

`scenario.schema.json` beside this file is made of them by `python -m tests.test_file_schemas`; what stands
under a key is its description there.
"""

from __future__ import annotations

from typing import Annotated, Literal, Required

from pydantic import Field, with_config
from typing_extensions import TypedDict

from surefoot.base.file_models import FILE, TUPLE, WHOLE, YAML, Number

Positive = Annotated[float, Field(ge=0), YAML]
Friction = Annotated[float, Field(ge=0, le=1000), YAML]
Pair = Annotated[tuple[Number, ...], Field(min_length=2, max_length=2), TUPLE]
Impedance = Annotated[tuple[Number, ...], Field(min_length=1, max_length=5), TUPLE]
TITLE = "A scenario file of surefoot walk and surefoot stand: what their options do not say"

Ice = TypedDict(
    "Ice",
    {  # a class cannot have the key "from"
        "mu": Required[Annotated[Friction, Field(description="Friction there [-].")]],
        "from": Annotated[Positive, Field(description="It holds everywhere from this time on [s].")],
        "lower": Annotated[Pair, Field(description="Corner x, y of the rectangle [m].")],
        "upper": Annotated[Pair, Field(description="The other corner, larger in both [m].")],
    },
    total=False,
)
with_config(FILE)(Ice)


@with_config(FILE)
class Law(TypedDict, total=False):
    """A law of surefoot.laws, in its own words."""

    name: Required[Literal["spring-damper", "hunt-crossley", "hertz", "sphere", "mujoco"]]
    """Which law."""
    stiffness: Positive
    """[N/m], of hertz [N/m^1.5]."""
    damping: Positive
    """Of spring-damper [N s/m]."""
    dissipation: Positive
    """Of hunt-crossley, hertz and sphere [s/m]."""
    exponent: Positive
    """Of hunt-crossley [-]."""
    radius: Positive
    """Of sphere [m]."""
    modulus: Positive
    """Young's modulus of sphere [Pa]."""
    poisson: Annotated[float, Field(ge=0, le=0.5), YAML]
    """Poisson's ratio of sphere [-]."""
    solref: Pair
    """Of mujoco: time constant [s] and damping ratio [-]."""
    solimp: Impedance
    """Of mujoco: dmin, dmax, width [m], midpoint, power."""
    mass: Positive
    """Of mujoco: effective mass of a contact [kg]."""


@with_config({**FILE, "title": TITLE})
class Scenario(TypedDict, total=False):
    """What happens to a simulated robot; no key is needed."""

    ice: Annotated[tuple[Ice, ...], TUPLE]
    """Changes of the ground's friction: from a time on, or in a rectangle of the ground (mujoco)."""
    law: Law
    """Soft ground of the world rigid: a law of surefoot.laws, in its own words."""
    solref: Pair
    """Softness of the ground in the world mujoco: time constant [s], damping ratio, or both negative:
    -stiffness, -damping [1/s^2, 1/s]."""
    solimp: Impedance
    """Impedance of the ground in the world mujoco: dmin, dmax, width [m], midpoint, power, or the first of
    them."""
    substeps: Annotated[int, Field(ge=1, le=64), WHOLE]
    """Steps of the world mujoco in a millisecond; by default 16 where a blind robot may strike edges,
    else 1."""
    delay: Annotated[float, Field(ge=0, le=1), YAML]
    """Delay of the commands [s]."""
    weak_joint: str
    """A joint that gives less torque than it is asked for."""
    torque_loss: Annotated[float, Field(ge=0, le=1), YAML]
    """Share of its torque that the weak joint loses [-]."""
    estimator: Literal["inekf", "truth"]
    """Where the controller has its state from: inekf, an estimate from IMU, encoders and torques, or
    truth."""
    noise: Annotated[float, Field(ge=0, le=100), YAML]
    """Noise of the sensors, 1 for that of ordinary ones; by default 1 with inekf, 0 with truth [-]."""
    believed_mu: Literal["auto"] | Friction
    """Friction that the controller believes in, or auto: as its feet find it; by default the ground's own."""
    period: Number
    """Length of a cycle of the gait [s]."""
    velocity_file: str
    """Lines of 'time vx vy yaw_rate' in place of --velocity; beside the scenario."""
    control_rate: Annotated[float, Field(ge=20, le=1000), YAML]
    """Steps of the controller in a second: 1000 over a whole number; drives go on at 1000."""
    latency: Literal["auto"] | Annotated[float, Field(ge=0, le=0.03), YAML]
    """Delay that the controller allows for [s]; auto: measured."""
