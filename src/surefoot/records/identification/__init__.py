"""Estimates from recordings: contact forces, friction, restitution, ground, bodies, motors and delays."""
