"""How simulators word contact parameters, and the translation between them."""

from surefoot.contact.engines.combination import combination_rules, combine_friction
from surefoot.contact.engines.engine import ENGINES, EngineContact
from surefoot.contact.engines.translation import Comparison, Translation, translate

__all__ = [
    "ENGINES",
    "Comparison",
    "EngineContact",
    "Translation",
    "combination_rules",
    "combine_friction",
    "translate",
]
