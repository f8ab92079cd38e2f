"""Kinds of contact, each with the forces that it can carry in one file: `sf.contact_sets`."""

from surefoot.contact.sets.bilateral import Bilateral
from surefoot.contact.sets.contact import ContactKind, Factor
from surefoot.contact.sets.contact_set import ContactSet
from surefoot.contact.sets.frictionless import Frictionless
from surefoot.contact.sets.patch import Patch
from surefoot.contact.sets.planar import Planar
from surefoot.contact.sets.point import Point
from surefoot.contact.sets.pyramid import Pyramid
from surefoot.contact.sets.rolling import Rolling
from surefoot.contact.sets.soft_finger import SoftFinger

__all__ = [
    "Bilateral",
    "ContactKind",
    "ContactSet",
    "Factor",
    "Frictionless",
    "Patch",
    "Planar",
    "Point",
    "Pyramid",
    "Rolling",
    "SoftFinger",
]
