"""The independent safety check of every plan."""

from stucksolver.guard.guard import Guard, Proven
from stucksolver.guard.policy import NOBODY, RULES, Approvals, GuardPolicy
from stucksolver.guard.verdict import OK, Reject, RejectCode, Verdict

__all__ = ["NOBODY", "OK", "RULES", "Approvals", "Guard", "GuardPolicy", "Proven", "Reject", "RejectCode", "Verdict"]
