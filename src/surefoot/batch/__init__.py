"""Many contact problems at once, and one in a caller's own compiled loop."""
