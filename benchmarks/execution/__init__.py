"""Whether plans survive their execution: starts, friction and mass they did not expect, two motor models."""
