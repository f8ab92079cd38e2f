"""The derivative of a time step: the state behind it and its impulses, by everything that goes into it."""
