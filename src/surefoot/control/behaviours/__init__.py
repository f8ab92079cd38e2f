"""What a walk does of its own accord: one file each, by rank in one table; see docs/add-a-behaviour.md."""

from surefoot.control.behaviours.behaviour import MakeBehaviour
from surefoot.control.behaviours.cruise import Cruise
from surefoot.control.behaviours.push_recovery import PushRecovery
from surefoot.control.behaviours.seen_stairs import SeenStairs
from surefoot.control.behaviours.slip import Slip
from surefoot.control.behaviours.stand_still import StandStill
from surefoot.control.behaviours.stop_at_drop import StopAtDrop
from surefoot.control.behaviours.stumble import Stumble

BEHAVIOURS: tuple[MakeBehaviour, ...] = (
    StandStill,
    PushRecovery,
    StopAtDrop.of,
    Slip.of,
    SeenStairs.of,
    Stumble.of,
    Cruise,
)
"""What makes each behaviour, the highest rank first."""
__all__ = ["BEHAVIOURS", "Cruise", "MakeBehaviour", "StandStill"]
