"""Questions to a stance: can it stand, how much friction does it need, where may its weight be."""

from surefoot.equilibrium.limits import ForceLimits
from surefoot.equilibrium.statics import can_stand, friction_needed
from surefoot.equilibrium.verdict import Verdict

__all__ = ["ForceLimits", "Verdict", "can_stand", "friction_needed"]
