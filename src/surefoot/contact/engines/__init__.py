"""How simulators word contact parameters, one file per engine, and the translation between them."""

from surefoot.contact.engines.combination import combination_rules, combine_friction
from surefoot.contact.engines.engine import ENGINES, EngineContact, engine_named
from surefoot.contact.engines.translation import Comparison, Translation, translate

__all__ = [
    "ENGINES",
    "Comparison",
    "EngineContact",
    "Translation",
    "combination_rules",
    "combine_friction",
    "engine_named",
    "translate",
]
