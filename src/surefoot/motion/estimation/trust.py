"""Whether a state estimate deserves its own error bars, from what the filter was surprised by.

The innovations of a filter that knows its sensors are white and of variance one. What it does not know, a
bias that jumps, a foot that slips, a map that is wrong, legs that are not where their encoders say, shows in
them before it has moved the estimate far: as a mean, as a size, or as feet and heights that are refused.
These tests watch for that [1]_.

References
----------
.. [1] Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with applications to tracking and navigation",
   Wiley 2001, section 5.4 (normalised innovation squared, whiteness).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np

from surefoot.base.arrays import BoolArray, FloatArray, real_number
from surefoot.base.memory import Remembering


class Trust(NamedTuple):
    """Whether the estimate is as good as its covariance says, and the reason if it may not be."""

    good: bool
    reason: str = ""


@dataclass(frozen=True)
class TrustSettings:
    """When an estimate is not to be trusted.

    Attributes
    ----------
    memories
        Times over which innovations are averaged [s]: a third of a stance, and some strides.
    sigmas
        Standard deviations, of such means of white innovations, from which they are none: more for the short
        one, which landings colour.
    size
        Mean squared innovation over the first of `memories`, relative to white ones, from which they are
        wild; landings make twice that in a sound filter (benchmarks/estimate_trust.py).
    jump
        Squared Mahalanobis distance of a single innovation from which a standing foot has jumped.
    refused
        Time for which a foot in contact is not believed from which it slides [s]; a landing takes some ms.
    aloft
        Time without a foot on the ground [s] from which place and speed are the IMU's alone: longer than any
        jump's flight.
    landings
        Height innovations that are averaged [-].
    bias
        Size of a bias from which it is none, relative to its standard deviation at the start.
    hold
        Time for which a doubt lasts after its cause has gone [s].
    """

    memories: tuple[float, float] = (0.1, 2.0)
    sigmas: tuple[float, float] = (9.0, 5.0)
    size: float = 3.0
    jump: float = 100.0
    refused: float = 0.06
    aloft: float = 1.0
    landings: float = 6.0
    bias: float = 5.0
    hold: float = 1.0

    def __post_init__(self) -> None:
        for one in fields(self):
            for value in np.atleast_1d(getattr(self, one.name)):
                real_number(one.name, value, low=1e-6)


class TrustMonitor(Remembering):
    """Tests on a filter's innovations.

    Parameters
    ----------
    feet
        Their names.
    dt
        Time between corrections [s].
    largest
        (2,) standard deviations of the gyro's [rad/s] and the accelerometer's [m/s²] bias at the start.
    settings
        See `TrustSettings`; None for its defaults.
    """

    MEMORY = (
        "_means", "_sizes", "_refused", "_aloft", "_height", "_height_weight", "_doubt", "_since",
    )  # fmt: skip

    def __init__(
        self, feet: tuple[str, ...], dt: float, largest: FloatArray, settings: TrustSettings | None = None
    ) -> None:
        self.settings = settings or TrustSettings()
        self._feet, self._dt = feet, dt
        self._largest = np.repeat(np.maximum(self.settings.bias * largest, 1e-9), 3)
        self._gain = 1.0 - np.exp(-dt / np.array(self.settings.memories))
        self._sigmas = np.array(self.settings.sigmas)[:, None, None]
        # the variance of such a mean of white innovations, once it has run for some memories
        self._spread = np.sqrt(self._gain / (2.0 - self._gain))[:, None, None]
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        n = len(self._feet)
        self._means, self._sizes = np.zeros((2, n, 3)), np.ones(n)
        self._refused, self._aloft = np.zeros(n), 0.0
        self._height, self._height_weight = 0.0, 0.0
        self._doubt, self._since = "", math.inf

    @property
    def trust(self) -> Trust:
        """Whether the estimate is to be trusted now."""
        return Trust(
            self._since > self.settings.hold, self._doubt if self._since <= self.settings.hold else ""
        )

    def take_correction(
        self, innovations: FloatArray, on: BoolArray, used: BoolArray, contact: BoolArray, bias: FloatArray
    ) -> None:
        """Take a correction by feet.

        Parameters
        ----------
        innovations
            (n, 3) whitened.
        on
            (n,) which feet had one.
        used, contact
            (n,) which were believed, and which touch.
        bias
            (6,) of gyro [rad/s] and accelerometer [m/s²].
        """
        self._since += self._dt
        fed, gain = on & used, self._gain
        self._means[:, fed] += gain[:, None, None] * (innovations[fed] - self._means[:, fed])
        squares = (innovations**2).sum(axis=1)
        self._sizes[fed] += gain[0] * (squares[fed] / 3.0 - self._sizes[fed])
        self._refused = np.where(contact & ~used, self._refused + self._dt, 0.0)
        self._aloft = 0.0 if contact.any() else self._aloft + self._dt
        if reason := self._find_doubt(squares, bias):
            self._raise(reason)

    def _find_doubt(self, squares: FloatArray, bias: FloatArray) -> str:
        """Return the reason for doubt, if any, by (n,) squared innovations and (6,) biases; NaN is one."""
        if not (np.isfinite(bias).all() and np.isfinite(squares).all()):
            return "numbers are not finite"
        large = np.abs(bias) > self._largest
        if large.any():
            sensor = "gyro" if large[:3].any() else "accelerometer"
            return f"the {sensor}'s bias is {np.abs(bias / self._largest).max():.1f} times what it may be"
        if self._aloft > self.settings.aloft:
            return f"no foot has touched for {self.settings.aloft:g} s: place and speed are the IMU's alone"
        late = self._refused > self.settings.refused
        if late.any():
            return f"{self._feet[int(np.argmax(late))]} touches but does not stand still"
        if (squares > self.settings.jump).any():
            return f"{self._feet[int(np.argmax(squares))]} has jumped, or its leg's angles have"
        leaning = np.abs(self._means / self._spread / self._sigmas).max(axis=(0, 2))
        if not leaning.max() <= 1.0:  # NaN does not pass, here and below
            return f"{self._feet[int(np.argmax(leaning))]} moves as no standing foot does"
        if not self._sizes.max() <= self.settings.size:
            return f"innovations of {self._feet[int(np.argmax(self._sizes))]} are larger than their noise"
        return ""

    def take_landing(self, excess: float, deviation: float, believed: bool) -> None:
        """Take the height innovation [m] of a landing, its standard deviation and the filter's verdict."""
        keep = 1.0 - 1.0 / self.settings.landings
        self._height = keep * self._height + (1.0 - keep) * excess / max(deviation, 1e-9)
        self._height_weight = keep * keep * self._height_weight + (1.0 - keep) ** 2
        # Of some landings only, so that a single stone is no wrong map.
        most = self.settings.sigmas[1] * math.sqrt(self._height_weight)
        if not (believed and abs(self._height) <= most):
            self._raise(f"the map is {excess:+.2f} m off where a foot landed")

    def _raise(self, reason: str) -> None:
        if self._since > self.settings.hold:
            self._doubt = reason
        self._since = 0.0
