"""How simulators word contact parameters, and the translation between them."""

from surefoot.contact.translation.combination import combination_rules as combination_rules
from surefoot.contact.translation.combination import combine_friction as combine_friction
from surefoot.contact.translation.engine import ENGINES as ENGINES
from surefoot.contact.translation.engine import EngineContact as EngineContact
from surefoot.contact.translation.translation import Comparison as Comparison
from surefoot.contact.translation.translation import Translation as Translation
from surefoot.contact.translation.translation import translate as translate
