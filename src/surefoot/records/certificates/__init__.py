"""Certificates of motions: whether the ground and the motors could give the forces that a motion needs."""
