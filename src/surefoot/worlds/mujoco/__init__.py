"""Worlds on MuJoCo, and logs and contact problems from anybody's MuJoCo model and data."""
