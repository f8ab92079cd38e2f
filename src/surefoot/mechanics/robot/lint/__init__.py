"""The lint of robot models: what in a file would make a walk or a verdict wrong, by a table of rules."""

from surefoot.mechanics.robot.lint.finding import Finding, Lint

__all__ = ["Finding", "Lint"]
