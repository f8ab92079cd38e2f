"""The ground as a walking robot estimates it: by touch, by a range sensor, stairs and drops in it."""
