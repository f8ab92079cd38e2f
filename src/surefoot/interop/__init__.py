"""Contact sequences as data: a file of one's own, and what other tools read."""

from surefoot.interop.sequence import ContactSequence, SequencePhase
from surefoot.interop.sequence_file import read_sequence, write_sequence
from surefoot.interop.sequence_log import sequence_from_log, sequence_from_schedule
from surefoot.interop.targets.table import export_sequence, target_names

__all__ = [
    "ContactSequence",
    "SequencePhase",
    "export_sequence",
    "read_sequence",
    "sequence_from_log",
    "sequence_from_schedule",
    "target_names",
    "write_sequence",
]
