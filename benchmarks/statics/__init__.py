"""The statics benchmark: verdicts and times against SciPy's HiGHS, Clarabel and cddlib."""
