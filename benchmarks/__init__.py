"""Measurements against rivals in the same run; `surefoot bench` in a checkout of the repository runs them.

They are no part of the installed package: rivals come and go, and a user needs none of them. Problems come
from `benchmarks.problems`, outside solvers are driven by `surefoot.contact.solvers.backends`.
"""
