"""What a robot's motion and torques tell of its contacts; above the audit, which it does not touch."""

from surefoot.estimation.forces import ForceEstimate, estimate_forces

__all__ = ["ForceEstimate", "estimate_forces"]
