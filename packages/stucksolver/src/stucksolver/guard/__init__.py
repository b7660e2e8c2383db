"""Guard: the independent safety check of every plan."""

from stucksolver.guard.guard import Guard
from stucksolver.guard.lane_entry import GivingWay
from stucksolver.guard.nose_out import begin_nosed_out
from stucksolver.guard.occluded_traffic import PhantomVehicle
from stucksolver.guard.policy import NOBODY, RULES, Approvals, GuardPolicy
from stucksolver.guard.proven_plan import ProvenPlan
from stucksolver.guard.turn_around import ProvenLeg
from stucksolver.guard.verdict import OK, RejectReason, Verdict, no_path
from stucksolver.scene.failed_attempts import RejectCode

__all__ = [
    "NOBODY",
    "OK",
    "RULES",
    "Approvals",
    "GivingWay",
    "Guard",
    "GuardPolicy",
    "PhantomVehicle",
    "ProvenLeg",
    "ProvenPlan",
    "RejectCode",
    "RejectReason",
    "Verdict",
    "begin_nosed_out",
    "no_path",
]
