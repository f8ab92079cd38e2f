"""Rivals of the package's own tossed cube: other simulators as an `estimation.toss_model`."""
