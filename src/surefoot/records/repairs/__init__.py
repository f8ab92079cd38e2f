"""Motions mended: the nearest one that forces exist for."""
