"""The linear inverted pendulum of a biped: its divergent motion over the coming steps.

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

from surefoot.base.arrays import FloatArray


class PendulumPreview:
    """The motion of the pendulum whose centre of pressure goes where it is to go and that never diverges.

    Parameters
    ----------
    omega
        Pendulum frequency sqrt(g / h) [1/s].
    dt
        Length of a step [s].
    steps
        Steps that are looked ahead; the centre of pressure stays where it is after them.

    Attributes
    ----------
    middles
        (steps,) times of the steps' middles [s].

    Examples
    --------
    >>> preview = PendulumPreview(4.0, 0.02, 100)
    >>> place, speed = preview.motion(np.array([0.1, 0.0]), np.tile([0.1, 0.0], (100, 1)))
    >>> bool(np.allclose(place, [0.1, 0.0]) and np.allclose(speed, 0.0))
    True
    """

    def __init__(self, omega: float, dt: float, steps: int) -> None:
        self.omega, self.dt, self.steps = omega, dt, steps
        self.middles = dt * (np.arange(steps, dtype=np.float64) + 0.5)
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
