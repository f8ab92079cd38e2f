"""A world in Drake: the world, what it sends, and the worker that runs in Drake's own environment."""
