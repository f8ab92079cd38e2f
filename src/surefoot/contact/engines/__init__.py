"""How simulators word contact parameters, and the translation between them."""

from surefoot.contact.engines.combination import combination_rules as combination_rules
from surefoot.contact.engines.combination import combine_friction as combine_friction
from surefoot.contact.engines.engine import ENGINES as ENGINES
from surefoot.contact.engines.engine import EngineContact as EngineContact
from surefoot.contact.engines.translation import Comparison as Comparison
from surefoot.contact.engines.translation import Translation as Translation
from surefoot.contact.engines.translation import translate as translate
