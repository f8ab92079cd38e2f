"""Worlds of rigid bodies with exact Coulomb friction: robots, scenes of bodies, gradients of rollouts."""
