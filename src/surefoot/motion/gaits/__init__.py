"""Gaits and mode schedules: which feet are on the ground at which time."""
