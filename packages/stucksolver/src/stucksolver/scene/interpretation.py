"""How a passenger's words were understood: an intent from a closed list, a side, the claims, and the confidence."""

from enum import Enum
from typing import Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from stucksolver.scene.base_model import FrozenModel


class GuidanceIntent(str, Enum):
    """What the words ask the vehicle to do."""

    GO = "go"
    OVERTAKE = "overtake"
    """Pass or go round something ahead."""
    WAIT = "wait"
    """Stay or stop. With `negated` also the rejection of a manoeuvre."""
    BACK_UP = "back_up"
    REROUTE = "reroute"
    TURN_AROUND = "turn_round"
    DRIVE_OVER = "drive_over"
    PULL_OVER = "pull_over"
    FOLLOW = "follow"
    """Stay behind someone."""
    LET_ME_OUT = "let_me_out"
    CANCEL = "cancel"
    """End the current manoeuvre and forget what was said."""
    YES = "yes"
    """Consent to the vehicle's question."""
    NO = "no"
    NONE = "none"
    """The words ask for nothing to be driven: small talk, or a fact."""
    UNCLEAR = "unclear"
    UNLAWFUL = "unlawful"
    """Something forbidden, or an attempt to change the system's rules."""


REQUESTS = frozenset(
    {
        GuidanceIntent.GO,
        GuidanceIntent.OVERTAKE,
        GuidanceIntent.BACK_UP,
        GuidanceIntent.REROUTE,
        GuidanceIntent.TURN_AROUND,
        GuidanceIntent.DRIVE_OVER,
        GuidanceIntent.PULL_OVER,
        GuidanceIntent.LET_ME_OUT,
    }
)
"""Intents that may require the vehicle to move."""
MOVES = REQUESTS | {GuidanceIntent.YES}
"""Readings that may move the vehicle. `follow` only keeps it from passing."""
STAYS = frozenset({GuidanceIntent.WAIT, GuidanceIntent.NO, GuidanceIntent.CANCEL, GuidanceIntent.FOLLOW})


class Side(str, Enum):
    """The side to which the vehicle is asked to go."""

    LEFT = "left"
    RIGHT = "right"


class Claim(str, Enum):
    """What a passenger says about the world. Evidence for people and reasoners; it never overrides what is seen."""

    CLEAR = "clear"
    """Nobody is coming."""
    NOT_CLEAR = "not_clear"
    RETURNING_SOON = "returning_soon"
    """The driver of the obstacle is about to move it."""
    LONG_STAY = "long_stay"
    EMPTY = "empty"
    SOFT_OBJECT = "soft_object"
    WAVED_THROUGH = "waved_through"
    BLOCKED_AHEAD = "blocked_ahead"
    BROKEN_LIGHT = "broken_light"
    HURRY = "hurry"
    NO_HURRY = "no_hurry"


class GuidanceLimits(FrozenModel):
    """How far, how fast and how long, as the words said it; None where they did not.

    They only choose parameters within a behaviour's bounds, and never raise a speed.
    """

    distance_m: float | None = Field(default=None, gt=0.0)
    speed_mps: float | None = Field(default=None, gt=0.0)
    """Upper limit of the speed."""
    wait_s: float | None = Field(default=None, gt=0.0)

    @property
    def description(self) -> str:
        """The amounts in words: `3 m, at most 10 km/h, for 30 s`."""
        far = None if self.distance_m is None else f"{self.distance_m:.3g} m"
        fast = None if self.speed_mps is None else f"at most {3.6 * self.speed_mps:.0f} km/h"
        long = None if self.wait_s is None else f"for {self.wait_s:.0f} s"
        return ", ".join(filter(None, (far, fast, long)))


class Interpretation(FrozenModel):
    """A passenger's words as the vehicle understood them.

    The vehicle may act on `intent`. It is `unclear` if the reader doubts a reading that would move the vehicle;
    `likely` is then its best guess.
    """

    intent: GuidanceIntent
    side: Side | None = None
    negated: bool = False
    claims: tuple[Claim, ...] = ()
    urgent: bool = False
    confidence: float = Field(ge=0.0, le=1.0)
    """Calibrated probability that `likely` is what was meant."""
    likely: GuidanceIntent
    reader: str
    """Name and version of the reader."""
    limits: GuidanceLimits | None = None
    """Left out of the JSON form if nothing was said."""
    denied: tuple[Claim, ...] = ()
    """The claims that the words deny: an earlier claim of that kind no longer counts. Left out if there are none."""
    danger: bool = False
    """True if the words say that what lies ahead must not be driven over. Left out if not."""

    @model_serializer(mode="wrap")
    def _short(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = handler(self)
        for name in ("limits", "denied", "danger"):
            if not getattr(self, name):
                data.pop(name, None)
        return data

    @property
    def description(self) -> str:
        """The reading in words: `overtake on the left (91 %)`, `unclear (overtake? 87 %)`."""
        intent, likely = (item.value.replace("_", " ") for item in (self.intent, self.likely))
        sure = f"{100 * self.confidence:.0f} %"
        if intent != likely:
            return f"{intent} ({likely}? {sure})"
        if self.intent is GuidanceIntent.NONE:
            return f"nothing to do with the driving ({sure})"
        side = f" on the {self.side.value}" if self.side is not None else ""
        limits = "" if self.limits is None else f", {self.limits.description}"
        return f"{intent}{side} ({sure}){limits}"
