"""What `identify` finds: numbers with intervals, the body and its surroundings, the errors of the tosses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import FloatArray, IntArray
from surefoot.base.drawn import Drawn
from surefoot.records.identification.frame_weights import frame_weights, frames_since
from surefoot.records.identification.ground_plane import CLEAR, GroundPlane
from surefoot.records.identification.relevel_tosses import Levelling
from surefoot.records.identification.thrown_body import ThrownBody
from surefoot.records.identification.thrown_body_tree import sphere_places
from surefoot.records.identification.toss_errors import TossErrors, TossMeasure
from surefoot.records.identification.toss_impacts import ImpactFit
from surefoot.records.identification.toss_model import TossScene
from surefoot.records.identification.toss_start import TossFlight, flying_frames
from surefoot.records.identification.tosses import Tosses

SLOPES = ("slope_x", "slope_y")
"""Names of the ground's slopes among the values of a fit."""


def plane_at(values: dict[str, float], clear: float = CLEAR) -> GroundPlane:
    """Return the ground whose height and slopes are among values by name; see `GroundPlane.clear`."""
    return GroundPlane(values["ground"], np.array([values[name] for name in SLOPES]), clear)


@dataclass(frozen=True)
class Estimate:
    """A fitted number and its 95 % interval, in `unit`."""

    value: float
    low: float
    high: float
    unit: str = ""


class BodyNumbers(NamedTuple):
    """What a law's fit changes of a `BodyFit`: `values`, `draws`, `parameters`, `scale`, `growth` there."""

    values: dict[str, float]
    draws: dict[str, FloatArray]
    parameters: dict[str, Estimate]
    scale: FloatArray | None
    growth: FloatArray | None


class BodyFit(NamedTuple):
    """What is known before a law is chosen: the body, the ground, gravity, and how their numbers spread.

    Attributes
    ----------
    body
        As identified.
    plane, gravity
        The ground, and [m/s²].
    parameters
        Those of the body and its surroundings, by name.
    flight
        The first states.
    values
        Of everything that was fitted on the way, the first law and the ground's slopes too, by name.
    draws
        (S,) what the bootstrap samples say of the same but the law, by name.
    nominal
        The body before it was fitted.
    levelled
        How the tosses stood before they were levelled one by one; None if they were not.
    notes
        A line each.
    first
        Body, ground and gravity by which first touches and first states were found: those before a law's fit.
    scale
        (G,) from which errors a loss is robust [widths], see `toss_loss`: of all laws; None before the first.
    growth
        (T, G) by which frames are weighed, see `frame_weights`: of all laws, too; None before the first.
    """

    body: ThrownBody
    plane: GroundPlane
    gravity: float
    parameters: dict[str, Estimate]
    flight: TossFlight
    values: dict[str, float]
    draws: dict[str, FloatArray]
    nominal: ThrownBody
    levelled: Levelling | None
    notes: tuple[str, ...]
    first: tuple[ThrownBody, GroundPlane, float]
    scale: FloatArray | None = None
    growth: FloatArray | None = None

    @property
    def numbers(self) -> BodyNumbers:
        """What `at` takes to find this fit again from one to the same tosses."""
        return BodyNumbers(self.values, self.draws, self.parameters, self.scale, self.growth)

    def at(self, numbers: BodyNumbers) -> BodyFit:
        """Return the fit with other numbers, as a law's fit to the same tosses leaves it."""
        values = numbers.values
        return self._replace(
            body=self.nominal.at(values), gravity=values["gravity"],
            plane=plane_at(values, self.plane.clear), **numbers._asdict(),
        )  # fmt: skip

    def scene(self, tosses: Tosses) -> TossScene:
        """Return the scene of tosses, these or others of the same body on the same ground."""
        body, _, gravity = self.first
        flight = TossFlight(tosses, self.before(tosses), body.tree, gravity)
        starts = flight.corrected(self.body.tree, self.gravity)
        return TossScene(starts, tosses.frames, tosses.dt, self.plane, self.gravity, self.body)

    def upright(self, tosses: Tosses) -> Tosses:
        """Return tosses in the axes of the scene, which are their own unless they were levelled."""
        return tosses if self.levelled is None else self.levelled.upright(tosses)

    @property
    def measure(self) -> TossMeasure:
        """In widths of the body as first found, whatever a law made of it since: of every law alike."""
        return TossMeasure(self.first[0].width, self.first[0].arm)

    def weighed_measure(self, tosses: Tosses) -> TossMeasure:
        """Return the measure of tosses whose frames count as `growth` says; alike before that is known."""
        if self.growth is None:
            return self.measure
        since = frames_since(tosses.frames, self.before(tosses))
        return self.measure._replace(weights=frame_weights(self.growth, since, 6 + tosses.joints))

    def before(self, tosses: Tosses) -> IntArray:
        """Return (B,) the frames before the first touch."""
        body, plane, _ = self.first
        return flying_frames(tosses, sphere_places(body.tree, tosses.poses), plane, body.width)


@dataclass(frozen=True, repr=False)
class TossFit(Drawn):
    """What `identify` found.

    Attributes
    ----------
    model
        Name of the contact law or simulator.
    parameters
        By name: those of the law, then of the body, ground [m], tilt_x and tilt_y [deg], gravity [m/s²].
    train, test
        Errors on the tosses it was fitted to, and on the others (None without any).
    train_poses, test_poses
        (N, nq) the simulated poses behind them, in the axes of `found`.
    found
        The body and its surroundings.
    impacts
        Errors in first impacts, of the test where there is one; None where few are over at once.
    position_noise, rotation_noise
        Standard deviations of a recorded coordinate [m] and angle [rad], from free flight.
    loss
        Robust mean [widths] over the tosses it was fitted to, see `toss_loss`: that of a law which contains
        another one is not larger.
    evaluations, seconds
        How often all tosses were simulated [-], and how long the fit took [s].
    notes
        What to know about the result, a line each.
    """

    model: str
    parameters: dict[str, Estimate]
    train: TossErrors
    test: TossErrors | None
    train_poses: FloatArray
    test_poses: FloatArray | None
    found: BodyFit
    impacts: ImpactFit | None
    position_noise: float
    rotation_noise: float
    loss: float
    evaluations: float
    seconds: float
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        tosses = len(self.train.position)
        return f"TossFit({self.model!r}, {len(self.parameters)} parameters, {tosses} tosses)"

    def __str__(self) -> str:
        own = self.train if self.test is None else self.test
        seen = "fitted to" if self.test is None else "not seen"
        errors = f"{own.position.mean():.3g} widths and {own.rotation.mean():.3g} deg"
        names = ", ".join([*self.parameters][:12])
        return (
            f"{self.model}: mean errors {errors} on {len(own.position)} tosses {seen}; parameters: {names}."
        )

    def __getitem__(self, name: str) -> Estimate:
        return self.parameters[name]
