"""Who touches what, where, and with which friction."""

from surefoot.stance.batch import StanceBatch as StanceBatch
from surefoot.stance.contact import Contact as Contact
from surefoot.stance.contact import PatchContact as PatchContact
from surefoot.stance.contact import PointContact as PointContact
from surefoot.stance.files import StanceQuestion as StanceQuestion
from surefoot.stance.files import read_stance as read_stance
from surefoot.stance.halfspaces import HalfSpaces as HalfSpaces
from surefoot.stance.stance import Stance as Stance
