"""Rivals of the package's own thrown body: other simulators as an `estimation.toss_model`."""
