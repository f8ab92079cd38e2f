"""Between a controller and motors: joint targets, delays, stale states, a stop without a state."""
