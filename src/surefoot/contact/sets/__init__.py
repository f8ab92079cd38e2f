"""Kinds of contact, each with the forces that it can carry: `sf.contact_sets`."""

from surefoot.contact.sets.bilateral import Bilateral
from surefoot.contact.sets.contact import ContactKind, Factor
from surefoot.contact.sets.contact_set import ContactSet
from surefoot.contact.sets.kinds import DecoupledSole, Frictionless, Planar, Point, Rolling, SoftFinger
from surefoot.contact.sets.pyramid import Pyramid

__all__ = [
    "Bilateral",
    "ContactKind",
    "ContactSet",
    "DecoupledSole",
    "Factor",
    "Frictionless",
    "Planar",
    "Point",
    "Pyramid",
    "Rolling",
    "SoftFinger",
]
