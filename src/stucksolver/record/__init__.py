"""The event log of each intervention: hash-chained, and derived again offline."""

from stucksolver.record.chain import RecordError
from stucksolver.record.recorder import Recorder
from stucksolver.record.replay import Finding, Report, replay

__all__ = ["Finding", "RecordError", "Recorder", "Report", "replay"]
