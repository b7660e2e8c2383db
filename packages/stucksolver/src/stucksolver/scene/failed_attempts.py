"""Plans that did not work, and why: codes for programs, and text for people and models."""

from __future__ import annotations

from enum import Enum

from stucksolver.scene.base_model import FrozenModel


class RejectCode(str, Enum):
    """Why the guard refuses or ends a plan."""

    STALE = "stale_surroundings"
    IMPLAUSIBLE = "unsound_input"
    PRECONDITION = "precondition"
    APPROVAL = "approval_missing"
    NO_PATH = "no_path"
    """There is no path to judge; `PlanFailure` says why."""
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
    """Why behaviours have no path here."""

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
    """How a plan ended."""

    REJECTED = "refused"
    """It was never started."""
    ABORTED = "given_up"
    """It was started and then ended early."""
    DECLINED = "denied"
    """A person said no."""
    INEFFECTIVE = "useless"
    """It finished, but the vehicle did not move on."""


class FailedAttempt(FrozenModel):
    """A plan of this episode that did not work, and why."""

    time_s: float
    behaviors: tuple[str, ...]
    ended: AttemptOutcome = AttemptOutcome.REJECTED
    codes: tuple[RejectCode, ...] = ()
    failures: tuple[PlanFailure, ...] = ()
    too_near: tuple[str, ...] = ()
    """Ids of the objects to which the plan did not keep the required gap."""
    outcome: str
    """The reason as text for people and language models."""
