"""Worlds that a controller can run in, and the log of a run."""
