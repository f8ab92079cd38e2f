"""A world on Bullet."""
