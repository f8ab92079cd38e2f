"""Who touches what, where, and with which friction."""

from surefoot.mechanics.stance.contact import Contact as Contact
from surefoot.mechanics.stance.contact import PointContact as PointContact
from surefoot.mechanics.stance.contact import SoleContact as SoleContact
from surefoot.mechanics.stance.files import StanceQuestion as StanceQuestion
from surefoot.mechanics.stance.files import read_stance as read_stance
from surefoot.mechanics.stance.halfspaces import HalfSpaces as HalfSpaces
from surefoot.mechanics.stance.stance import Stance as Stance
