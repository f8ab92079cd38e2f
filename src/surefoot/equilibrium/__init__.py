"""Questions to a stance: can it stand, how much friction does it need, where may its weight be."""

from surefoot.equilibrium.batch import Verdicts, can_stand_batch, com_region_batch
from surefoot.equilibrium.limits import ForceLimits
from surefoot.equilibrium.region import Region
from surefoot.equilibrium.regions import com_region, support_polygon, zmp_region
from surefoot.equilibrium.statics import can_stand, friction_needed
from surefoot.equilibrium.verdict import Verdict
from surefoot.equilibrium.volume import ComVolume, com_volume
from surefoot.equilibrium.wrench_cone import wrench_cone, wrench_cone_size

__all__ = [
    "ComVolume",
    "ForceLimits",
    "Region",
    "Verdict",
    "Verdicts",
    "can_stand",
    "can_stand_batch",
    "com_region",
    "com_region_batch",
    "com_volume",
    "friction_needed",
    "support_polygon",
    "wrench_cone",
    "wrench_cone_size",
    "zmp_region",
]
