"""Which contacts are excluded by the assumptions in `docs/SAFETY.md`, and by which one."""

from __future__ import annotations

from benchmarks.guard_oracle.contact import Contact
from benchmarks.guard_oracle.others import STOOD_LONG_S
from benchmarks.guard_oracle.world import ANSWERS_S, HARD_MPS2

AT_REST_MPS = 0.1
JUNCTION_M = 15.0
"""Someone first seen less than this distance of our path ago was not in sight when we reached the junction."""
TOLERANCE_M = 0.15
"""Reduction of each gap by a tracking error."""
GO_OUR_WAY = ("leads", "queues", "comes up in the lane entered", "goes beside us", "filters past us")
RESTS = "runs into the standing vehicle: those who meet one that stands keep their own distance"
SIDE = "steps off into our side: a step off the kerb is promised never to be met by the front"
LEADS = "traffic ahead in our lane: the stack follows it"
SILENT = "in silence the rest is driven with the stack's own braking only, which the oracle's vehicle lacks"
FILTERS = "comes from behind in our own lane, and leaves less room beside us than a tracking error may take"
SETS_OFF = "not covered: stands before us, sets off while we pass, and does not brake for who is entering their lane"
HIDDEN = "not covered: on a crossing road, and not in sight when the junction was entered"
TRAPPED = "not covered: on the rails from the start, behind somebody who leaves them no quicker"
THROUGH = "impossible: comes through somebody else, since the oracle's others do not look at each other"
UNSEEN = "not in sight until it was too late to stop, by 6 m/s² after half a second"


def excluded_by(contact: Contact) -> str | None:
    """The assumption that excludes a contact, or None."""
    if contact.through:
        return THROUGH
    stop_m = contact.seen_mps * ANSWERS_S + contact.seen_mps**2 / (2 * HARD_MPS2)
    if not contact.from_start and contact.seen_m < stop_m:
        return UNSEEN
    if contact.role in GO_OUR_WAY and contact.their_part == "rear" and not contact.follows:
        return LEADS
    if contact.role == "filters past us" and contact.room < TOLERANCE_M:
        return FILTERS
    if contact.role == "crosses" and not contact.from_start and contact.seen_m < JUNCTION_M:
        return HIDDEN
    stands, never_seen = abs(contact.closing - abs(contact.ego_speed)) < AT_REST_MPS, contact.seen_s == 0.0
    if contact.role == "queues" and (contact.their_part == "front" or (contact.their_part == "side" and not stands)):
        return SETS_OFF
    if contact.order == "silent" and (stands or never_seen or contact.part == "front"):
        return SILENT
    walks = contact.kind == "pedestrian"
    stood_long = contact.role == "crosses" and contact.stood_s >= STOOD_LONG_S
    if abs(contact.ego_speed) < AT_REST_MPS and (walks or stood_long or contact.role == "follows us"):
        return RESTS
    if contact.role == "train" and contact.led_from_rails:
        return TRAPPED
    if contact.role.startswith("steps") and contact.part != "front":
        return SIDE
    return None
