"""Landings that are none: a shin on an edge, or a leg braked in the air, looks like a foot on the ground.

What is felt of the ground is a force at the foot by the torques of its leg. An edge that touches the shin
gives such a force as well, and so does a leg whose mass is not quite what is believed. A foot that is taken
to stand then is loaded in the air, and strikes the ground within some hundredths of a second. So a touch well
above ground that is known counts only once it has lasted, and a foot that feels nothing more right after its
landing has not landed [1]_.

References
----------
.. [1] G. Bledt, P. Wensing, S. Ingersoll, S. Kim, "Contact model fusion for event-based locomotion in
   unstructured terrains", ICRA 2018 (height and force together tell a contact).
"""

from __future__ import annotations

import numpy as np

from surefoot.arrays import BoolArray, FloatArray

LASTING, LASTING_FAR = 0.02, 0.1
"""How long a force must last that is felt above the ground, and far above it [s]."""
FAR = 3.0
"""How far above the ground is far, over what may be noise."""
YOUNG, SILENT = 0.04, 0.008
"""So long after a landing it may be taken back [s], if the foot has felt nothing for this long [s]."""


class LandingWatch:
    """Doubts landings, see the module.

    Parameters
    ----------
    feet
        Number of them.
    dt
        Time between steps [s].
    """

    def __init__(self, feet: int, dt: float) -> None:
        self.dt = dt
        self._felt, self._silent = np.zeros((2, feet))
        self._stood = np.full(feet, np.inf)

    def believe(self, sensed: BoolArray, carrying: BoolArray, above: FloatArray) -> BoolArray:
        """Return which feet have landed of those that feel the ground: (n,).

        Parameters
        ----------
        sensed, carrying
            (n,) which feet feel it, and which are taken to stand on it.
        above
            (n,) how far above the ground they are by what is known of it, over what may be noise [-].
        """
        self._felt = np.where(sensed, self._felt + self.dt, 0.0)
        self._silent = np.where(sensed, 0.0, self._silent + self.dt)
        lasting = np.where(above > FAR, LASTING_FAR, np.where(above > 1.0, LASTING, 0.0))
        return sensed & (carrying | (self._felt >= lasting))

    def taken_back(self, carrying: BoolArray) -> BoolArray:
        """Return which feet that carry have not landed after all: (n,); to be called at each step."""
        self._stood = np.where(carrying, self._stood + self.dt, 0.0)
        return carrying & (self._stood < YOUNG) & (self._silent >= SILENT)
