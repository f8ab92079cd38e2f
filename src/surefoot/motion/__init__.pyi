"""Names of this wing that other wings use; the modules behind them are its own matter."""

from .control.controller import Command as Command
from .control.controller import Controller as Controller
from .control.controller import JointTargets as JointTargets
from .control.controller import Wrapper as Wrapper
from .control.controller import as_controller as as_controller
from .control.controller import state_of as state_of
from .drive.postures import BodyPostures as BodyPostures
from .drive.readings import RobotReadings as RobotReadings
from .drive.readings import motor_order as motor_order
from .drive.standstill import Standstill as Standstill
from .drive.state_kinds import STATE_KINDS as STATE_KINDS
from .drive.state_tracker import StateTracker as StateTracker
from .drive.watchdog import damping_targets as damping_targets
from .drive.wire.dialect import Dialect as Dialect
from .drive.wire.link import WireEnd as WireEnd
from .estimation.inekf import FilterNoise as FilterNoise
from .estimation.state_estimator import Reading as Reading
from .gaits.library import gait_names as gait_names
from .planning.plan import planned_ground as planned_ground
from .planning.stand_up.stand_up_controller import controller_of as controller_of
from .planning.tracking.reference import Reference as Reference
from .state import HeightScan as HeightScan
from .state import RobotState as RobotState
from .walking.walking_body import VelocityCommand as VelocityCommand
from .walking.walking_controller import WalkingController as WalkingController
from .walking.walking_settings import WalkSettings as WalkSettings
