"""Who touches what, where, and with which friction."""

from surefoot.stance.batch import StanceBatch
from surefoot.stance.contact import Contact, PatchContact, PointContact
from surefoot.stance.files import StanceQuestion, read_stance
from surefoot.stance.halfspaces import HalfSpaces
from surefoot.stance.stance import Stance

__all__ = [
    "Contact",
    "HalfSpaces",
    "PatchContact",
    "PointContact",
    "Stance",
    "StanceBatch",
    "StanceQuestion",
    "read_stance",
]
