"""The walking benchmark: the MPC step against QP solvers with pyramids and against exact Clarabel."""
