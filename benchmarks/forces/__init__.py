"""The force distribution benchmark: accuracy against time, exact cones and facets, warm starts."""
