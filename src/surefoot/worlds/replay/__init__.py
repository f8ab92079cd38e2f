"""The motion of a log, run again in another world."""
