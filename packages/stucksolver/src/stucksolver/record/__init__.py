"""Event log of each intervention: hash-chained, and replayed offline."""

from stucksolver.record.anchor import Anchor, check_anchor, head_of, read_heads, write_heads
from stucksolver.record.decisions import RecordedDecision, read_decisions
from stucksolver.record.hash_chain import RecordError
from stucksolver.record.recorder import Recorder
from stucksolver.record.replay import ReplayFinding, Report, replay

__all__ = [
    "Anchor",
    "RecordError",
    "RecordedDecision",
    "Recorder",
    "ReplayFinding",
    "Report",
    "check_anchor",
    "head_of",
    "read_decisions",
    "read_heads",
    "replay",
    "write_heads",
]
