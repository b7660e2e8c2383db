"""What the guard says of a plan."""

from __future__ import annotations

from enum import Enum

from stucksolver.decision.behaviors import Abort
from stucksolver.scene.model import Model


class RejectCode(str, Enum):
    STALE = "stale_surroundings"
    UNSOUND = "unsound_input"
    PRECONDITION = "precondition"
    APPROVAL = "approval_missing"
    NO_PATH = "no_path"
    COLLISION = "collision"
    GAP = "gap"
    CLEARANCE = "vulnerable_clearance"
    RED_LIGHT = "red_light"
    STOP_LINE = "stop_line"
    ONCOMING_SIGHT = "oncoming_sight"
    ONCOMING_GAP = "oncoming_gap"
    LANE_ENTRY = "lane_entry"
    ZONE = "junction_or_crossing"
    SOLID_LINE = "solid_line"
    OFF_ROAD = "off_road"
    DOOR = "door_may_open"
    OFF_ROUTE = "off_route"
    AUTHORITY = "own_authority"
    WAIT_FIRST = "wait_first"
    NOT_PASSABLE = "not_passable"
    LEAVES_LANE = "leaves_its_lane"
    STOPPING_PLACE = "no_place_to_stop"
    UNSEEN = "way_not_seen"
    NO_ABORT = "no_safe_abort"
    OVERSPEED = "overspeed"
    DEVIATION = "off_the_path"
    TIMEOUT = "timeout"
    NOT_IMMOBILIZED = "not_immobilized"
    REPEATED = "repeated"


class Reject(Model):
    """One reason against a plan, with the offending object, when, and how near, where that applies."""

    code: RejectCode
    detail: str
    object_id: str | None = None
    time_s: float | None = None
    gap_m: float | None = None


class Verdict(Model):
    """`abort` is set only while a plan runs: what to do instead; `brake_mps2`: how hard, where it is to brake."""

    rejects: tuple[Reject, ...] = ()
    abort: Abort | None = None
    brake_mps2: float | None = None

    @property
    def accepted(self) -> bool:
        return not self.rejects

    def __str__(self) -> str:
        if self.accepted:
            return "accepted"
        return "; ".join(f"{r.code.value}: {r.detail}" for r in self.rejects)


OK = Verdict()
