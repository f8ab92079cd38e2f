"""Plans by sampling: joint targets drawn at random, rolled out, and drawn again around the best."""

from surefoot.planning.sampling.cross_entropy import CrossEntropyResult, cross_entropy
from surefoot.planning.sampling.forward import ForwardModel, RigidModel
from surefoot.planning.sampling.postures import Postures, postures

__all__ = ["CrossEntropyResult", "ForwardModel", "Postures", "RigidModel", "cross_entropy", "postures"]
