"""What is of use where policies are trained: terms of rewards, and the audit of every episode."""

from surefoot.worlds.training import names

rl = names
