"""Plans that failed, and the reasons: codes for programs, text for people and language models."""

from __future__ import annotations

from enum import Enum
from typing import Literal

from stucksolver.scene.base_model import FrozenModel


class RejectCode(str, Enum):
    """Reason for which the guard rejects or aborts a plan."""

    STALE = "stale_surroundings"
    IMPLAUSIBLE = "unsound_input"
    PRECONDITION = "precondition"
    APPROVAL = "approval_missing"
    NO_PATH = "no_path"
    """The plan has no path to check; `PlanFailure` has the reason."""
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
    OFF_LANES = "off_driving_lanes"
    OFF_ROAD = "off_road"
    DOOR = "door_may_open"
    OFF_ROUTE = "off_route"
    AUTHORITY = "own_authority"
    WAIT_FIRST = "wait_first"
    NOT_PASSABLE = "not_passable"
    LEAVES_LANE = "leaves_its_lane"
    STOPPING_PLACE = "no_place_to_stop"
    PATH_NOT_VISIBLE = "way_not_seen"
    NO_ABORT = "no_safe_abort"
    OVERSPEED = "overspeed"
    DEVIATION = "off_the_path"
    TIMEOUT = "timeout"
    NOT_IMMOBILIZED = "not_immobilized"
    REPEATED = "repeated"


class PlanFailure(str, Enum):
    """Reason for which a behavior has no path."""

    PRECONDITION = "precondition"
    EMPTY = "empty_plan"
    NOT_SEEN = "object_not_seen"
    NOT_IN_THE_WAY = "object_not_in_the_way"
    NOT_LEADING = "object_does_not_lead"
    NO_LANE = "no_such_lane"
    NOT_OUR_LANE = "lane_of_oncoming_traffic"
    LANE_TOO_NARROW = "lane_too_narrow"
    NO_ROOM_ASIDE = "no_room_aside"
    NO_SPACE_TO_PULL_AROUND = "no_room_to_swing_out"
    NO_ROOM_TO_COME_BACK = "no_room_to_come_back"
    NO_ROOM_TO_TURN = "no_room_to_turn_round"
    TOO_LONG = "too_long_to_pass"
    MUST_BE_STOPPED = "must_stand_first"


class AttemptOutcome(str, Enum):
    """Outcome of a plan that failed."""

    REJECTED = "refused"
    """The plan was never started."""
    ABORTED = "given_up"
    """The plan was started and ended early."""
    DECLINED = "denied"
    """A person declined the plan."""
    INEFFECTIVE = "useless"
    """The plan finished, but the ego made no progress."""


class MissingAmount(FrozenModel):
    """Requirement that a plan did not meet, with the amount that was missing (in `unit`, positive)."""

    code: RejectCode
    amount: float
    unit: Literal["m", "s", "m/s"]


class FailedAttempt(FrozenModel):
    """Plan of this intervention that failed, and the reasons."""

    time_s: float
    behaviors: tuple[str, ...]
    ended: AttemptOutcome = AttemptOutcome.REJECTED
    codes: tuple[RejectCode, ...] = ()
    failures: tuple[PlanFailure, ...] = ()
    too_near: tuple[str, ...] = ()
    """Ids of the objects to which the plan did not keep the required gap."""
    plan: tuple[str, ...] = ()
    """Its behaviors with their parameters, each in its JSON form; empty in old records."""
    blocker: str | None = None
    """Id of the object of the binding constraint; None without one, and in old records."""
    missing: tuple[MissingAmount, ...] = ()
    """What was missing, for requirements that have an amount; empty in old records."""
    outcome: str
    """Reason as text for people and language models."""
