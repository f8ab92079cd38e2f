"""Contact sequences as data: a file of one's own, and what other tools read."""

from surefoot.app.export.sequence import ContactSequence as ContactSequence
from surefoot.app.export.sequence import SequencePhase as SequencePhase
from surefoot.app.export.sequence_file import read_sequence as read_sequence
from surefoot.app.export.sequence_file import write_sequence as write_sequence
from surefoot.app.export.sequence_log import sequence_from_log as sequence_from_log
from surefoot.app.export.sequence_log import sequence_from_schedule as sequence_from_schedule
from surefoot.app.export.targets.target_names import TARGETS as TARGETS
from surefoot.app.export.targets.target_names import export_sequence as export_sequence
