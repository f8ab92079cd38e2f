"""Contact sequences as data: a file of one's own, and what other tools read."""

from surefoot.interop.sequence import ContactSequence as ContactSequence
from surefoot.interop.sequence import SequencePhase as SequencePhase
from surefoot.interop.sequence_file import read_sequence as read_sequence
from surefoot.interop.sequence_file import write_sequence as write_sequence
from surefoot.interop.sequence_log import sequence_from_log as sequence_from_log
from surefoot.interop.sequence_log import sequence_from_schedule as sequence_from_schedule
from surefoot.interop.targets.table import TARGETS as TARGETS
from surefoot.interop.targets.table import export_sequence as export_sequence
