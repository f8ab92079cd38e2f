"""Learned policies as controllers: a network, what it is fed with, and what its numbers mean."""
