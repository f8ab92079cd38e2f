"""The contact benchmark: our solvers, Pinocchio's and Siconos' on problems of `benchmarks.problems`."""
