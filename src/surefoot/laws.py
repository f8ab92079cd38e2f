"""Contact laws by name: `surefoot.laws.COULOMB`, `surefoot.laws.HuntCrossley(stiffness=2e5, ...)`."""

from surefoot.contact.laws import CONVEX, COULOMB, Law, pressure, soft
from surefoot.contact.laws.pressure import *  # noqa: F403 - their own lists say what is public
from surefoot.contact.laws.soft import *  # noqa: F403

__all__ = ["CONVEX", "COULOMB", "Law"]
__all__ += pressure.__all__
__all__ += soft.__all__
