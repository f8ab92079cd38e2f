"""Engines as they come, run on scenes of boxes and balls without a layer of ours."""
