"""The typed log of a run or a robot: channels over time, the facts about them, and the files they come in."""

from surefoot.log.channels import CHANNELS, Channel
from surefoot.log.facts import FACTS, Fact
from surefoot.log.formats import Format, format_names, read_log, register_format
from surefoot.log.log import Ending, Log
from surefoot.log.recorder import Recorder

__all__ = [
    "CHANNELS",
    "FACTS",
    "Channel",
    "Ending",
    "Fact",
    "Format",
    "Log",
    "Recorder",
    "format_names",
    "read_log",
    "register_format",
]
