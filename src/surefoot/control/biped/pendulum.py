"""The linear inverted pendulum of a biped: its divergent motion over the coming steps, and the steady gait.

Over a level path the centre of mass c moves as c̈ = ω² (c - p), with p the centre of pressure and
ω = sqrt(g / h). What diverges is ξ = c + ċ / ω (the capture point [1]_, or divergent component of
motion [2]_): ξ̇ = ω (ξ - p), while c follows it, ċ = ω (ξ - c). So ξ is fixed by where p goes from now on,
read backwards in time, and c by where it has been.

References
----------
.. [1] J. Pratt, J. Carff, S. Drakunov, A. Goswami, "Capture point: a step toward humanoid push recovery",
   Humanoids 2006.
.. [2] J. Englsberger, C. Ott, A. Albu-Schäffer, "Three-dimensional bipedal walking control based on divergent
   component of motion", IEEE T-RO 2015.
"""

from __future__ import annotations

import math

import numpy as np

from surefoot.arrays import FloatArray


class PendulumPreview:
    """The motion of the pendulum whose centre of pressure goes where it is told and that never diverges.

    Parameters
    ----------
    omega
        Pendulum frequency sqrt(g / h) [1/s].
    dt
        Length of a step [s].
    steps
        Steps that are looked ahead; the centre of pressure stays where it is after them.

    Examples
    --------
    >>> preview = PendulumPreview(4.0, 0.02, 100)
    >>> place, speed = preview.motion(np.array([0.1, 0.0]), np.tile([0.1, 0.0], (100, 1)))
    >>> bool(np.allclose(place, [0.1, 0.0]) and np.allclose(speed, 0.0))
    True
    """

    def __init__(self, omega: float, dt: float, steps: int) -> None:
        self.omega, self.dt, self.steps = omega, dt, steps
        keep = math.exp(-omega * dt)
        power = np.subtract.outer(np.arange(steps + 1), np.arange(steps))  # row minus column
        # ξ_i = keep^(n-i) p_last + Σ_(j >= i) (1 - keep) keep^(j-i) p_j: exact for p constant over each step
        self._diverging = np.where(power <= 0, (1.0 - keep) * keep ** np.abs(power), 0.0)
        self._diverging[:, -1] += keep ** (steps - np.arange(steps + 1))
        # c_(i+1) = keep c_i + (1 - keep) p_i + sinh(ω dt) (ξ_i - p_i)
        self._following = np.where(power > 0, keep ** np.maximum(power - 1, 0), 0.0)
        self._decay = keep ** np.arange(steps + 1)
        self._keep, self._sinh = keep, math.sinh(omega * dt)

    def divergent(self, pressure: FloatArray) -> FloatArray:
        """Return ξ at the times 0, dt, ... (steps + 1, 2) [m] for centres of pressure (steps, 2) [m]."""
        return np.asarray(self._diverging @ pressure)

    def motion(self, com: FloatArray, pressure: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place (steps + 1, 2) [m] and velocity (steps + 1, 2) [m/s] of the centre of mass.

        It starts at (2,) `com` [m] with the velocity that makes its ξ the one of `divergent`.
        """
        ahead = self.divergent(pressure)
        drive = (1.0 - self._keep) * pressure + self._sinh * (ahead[:-1] - pressure)
        place = self._decay[:, None] * com + self._following @ drive
        return place, self.omega * (ahead - place)


def steady_offset(
    stride: tuple[float, float], width: float, side: float, omega: float, step: float, double: float
) -> FloatArray:
    """Return ξ minus the foot that touches down at that moment, in steady walking: (2,) forward, left [m].

    In double support the centre of pressure moves evenly from the old foot to the new one, in single support
    it stays. With E = exp(ω step), γ = 1 - (1 - exp(-ω double)) / (ω double) and s the step that has led to
    the foot, ξ - foot goes from b to E (b + γ s) until the next touchdown; the steady gait repeats it.

    Parameters
    ----------
    stride
        How far the body goes in a step, forward and left [m].
    width
        Distance of the feet [m].
    side
        1 for a left foot that touches down, -1 for a right one.
    omega
        Pendulum frequency [1/s].
    step, double
        Time from touchdown to touchdown, and part of it on both feet [s].

    Examples
    --------
    >>> steady_offset((0.1, 0.0), 0.2, 1.0, 4.0, 0.4, 0.1).round(4)
    array([ 0.0044, -0.0630])
    """
    growth = math.exp(-omega * step)  # 1 / E, which does not overflow
    spread = omega * double
    gamma = 1.0 - (1.0 - math.exp(-spread)) / spread if spread > 1e-9 else 0.0
    along = (growth - gamma) / (1.0 - growth)
    across = -side * width * (growth + gamma) / (1.0 + growth)
    return np.array([stride[0] * along, stride[1] * along + across])
