"""The guard: the independent safety check of every plan."""

from stucksolver.guard.guard import Guard
from stucksolver.guard.lane_entry import GivingWay
from stucksolver.guard.nose_out import begun_waiting
from stucksolver.guard.occluded_traffic import Unseen
from stucksolver.guard.policy import NOBODY, RULES, Approvals, GuardPolicy
from stucksolver.guard.proven_plan import Proven
from stucksolver.guard.turn_around import ProvenLeg
from stucksolver.guard.verdict import OK, Reject, Verdict, no_path
from stucksolver.scene.failed_attempts import RejectCode

__all__ = [
    "NOBODY",
    "OK",
    "RULES",
    "Approvals",
    "GivingWay",
    "Guard",
    "GuardPolicy",
    "Proven",
    "ProvenLeg",
    "Reject",
    "RejectCode",
    "Unseen",
    "Verdict",
    "begun_waiting",
    "no_path",
]
