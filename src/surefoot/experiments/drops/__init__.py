"""One mass on one contact, run in an engine: what a translation of contact parameters is held against."""

from surefoot.experiments.drops.drop import available_engines, measure

__all__ = ["available_engines", "measure"]
