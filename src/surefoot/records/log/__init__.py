"""The typed log of a run or a robot: channels over time, and facts about them; `reading` reads files."""

from surefoot.records.log.channels import CHANNELS, Channel
from surefoot.records.log.facts import FACTS, Fact
from surefoot.records.log.log import Ending, Log

__all__ = ["CHANNELS", "FACTS", "Channel", "Ending", "Fact", "Log"]
