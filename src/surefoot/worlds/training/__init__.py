"""What is of use where policies are trained: terms of rewards."""

from surefoot.worlds.training import names

rl = names
