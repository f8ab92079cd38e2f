"""Contact for whoever trains a policy: `surefoot.rl.terms` of rewards, beside `surefoot.StepLaws`."""

from surefoot.worlds.training import terms

__all__ = ["terms"]
