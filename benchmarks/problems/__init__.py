"""Problems to try solvers, questions and controllers on: contact problems, stances, allocations, walks.

Everything is made from a seed, so that two machines and two versions are asked the same. Benchmarks and tests
use them, and whoever writes a solver can.
"""
