"""The independent safety check of every plan."""

from stucksolver.guard.guard import Guard, Proven
from stucksolver.guard.policy import GuardPolicy
from stucksolver.guard.verdict import Reject, RejectCode, Verdict

__all__ = ["Guard", "GuardPolicy", "Proven", "Reject", "RejectCode", "Verdict"]
