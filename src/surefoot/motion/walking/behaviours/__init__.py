"""What a walk does of its own accord: one file each, by rank in one table; see docs/add-a-behaviour.md."""

from surefoot.motion.walking.behaviours.behaviour import MakeBehaviour
from surefoot.motion.walking.behaviours.cruise import Cruise
from surefoot.motion.walking.behaviours.push_recovery import PushRecovery
from surefoot.motion.walking.behaviours.seen_stairs import SeenStairs
from surefoot.motion.walking.behaviours.slip import Slip
from surefoot.motion.walking.behaviours.stand_still import StandStill
from surefoot.motion.walking.behaviours.stop_at_drop import StopAtDrop
from surefoot.motion.walking.behaviours.stumble import Stumble

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
