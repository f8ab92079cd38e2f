"""Runs of a controller in a world: the loop, its scenario, sensors, faults and observers."""
