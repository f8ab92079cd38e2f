"""One mass on one contact, run in an engine: what a translation of contact parameters is held against."""

from surefoot.simulation.drops.drop import Track, available_engines, measure

__all__ = ["Track", "available_engines", "measure"]
