"""The typed log of a run or a robot: channels over time, the facts about them, and the files they come in."""

from surefoot.log.arrays_in import log_from_arrays
from surefoot.log.channels import CHANNELS, Channel
from surefoot.log.doubts import find_doubts
from surefoot.log.facts import FACTS, Fact
from surefoot.log.formats import Format, format_names, read_log, read_source, register_format
from surefoot.log.guesses import guess_mapping
from surefoot.log.log import Ending, Log
from surefoot.log.mapped import log_from_source
from surefoot.log.mapping import LogMapping, Take, read_mapping
from surefoot.log.recorder import Recorder
from surefoot.log.source import Source, Topic

__all__ = [
    "CHANNELS",
    "FACTS",
    "Channel",
    "Ending",
    "Fact",
    "Format",
    "Log",
    "LogMapping",
    "Recorder",
    "Source",
    "Take",
    "Topic",
    "find_doubts",
    "format_names",
    "guess_mapping",
    "log_from_arrays",
    "log_from_source",
    "read_log",
    "read_mapping",
    "read_source",
    "register_format",
]
