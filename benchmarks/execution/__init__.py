"""Whether plans survive their execution: starts, friction and mass that they did not expect, two kinds of motors."""
