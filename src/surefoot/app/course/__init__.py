"""Exercises of the course that grade themselves: stubs, solutions, and properties on random inputs."""
