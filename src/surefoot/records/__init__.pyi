"""Names of this wing that other wings use; the modules behind them are its own matter."""

from .audit.auditor import audit_log as audit_log
from .audit.batch.array_functions import array_module as array_module
from .audit.batch.array_functions import vector_length as vector_length
from .audit.batch.step_cost import step_cost as step_cost
from .audit.summary.walk_summary import summarise_walk as summarise_walk
from .identification.friction_tracker import FrictionTracker as FrictionTracker
from .identification.thrown_body import ThrownBody as ThrownBody
from .identification.thrown_body import TossParameter as TossParameter
from .identification.toss_model import FRICTION as FRICTION
from .identification.toss_model import ROUNDING as ROUNDING
from .identification.toss_model import TossScene as TossScene
from .identification.toss_model import in_plane as in_plane
from .identification.toss_model import in_world as in_world
from .log.channels import CHANNELS as CHANNELS
from .log.channels import Channel as Channel
from .log.from_arrays import log_from_arrays as log_from_arrays
from .log.log import Ending as Ending
from .log.log import Log as Log
from .log.plausibility import find_doubts as find_doubts
from .log.reading import read_log as read_log
from .log.recorder import Recorder as Recorder
