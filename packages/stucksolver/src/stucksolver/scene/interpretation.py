"""Interpretation of a passenger's utterance: an intent from a closed list, a side, claims, and the confidence."""

from enum import Enum
from typing import Any

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from stucksolver.scene.base_model import FrozenModel


class GuidanceIntent(str, Enum):
    """Action for which an utterance asks."""

    GO = "go"
    OVERTAKE = "overtake"
    """Pass an object ahead."""
    WAIT = "wait"
    """Stay or stop. With `negated` also the rejection of a maneuver."""
    BACK_UP = "back_up"
    REROUTE = "reroute"
    TURN_AROUND = "turn_round"
    DRIVE_OVER = "drive_over"
    PULL_OVER = "pull_over"
    FOLLOW = "follow"
    """Stay behind another vehicle."""
    LET_ME_OUT = "let_me_out"
    CANCEL = "cancel"
    """End the current maneuver and drop the earlier guidance."""
    YES = "yes"
    """Approve the open question of the vehicle."""
    NO = "no"
    NONE = "none"
    """The utterance does not concern the driving: small talk, or a fact."""
    UNCLEAR = "unclear"
    UNLAWFUL = "unlawful"
    """A forbidden action, or an attempt to change the system's rules."""


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
"""Intents that may move the vehicle. `follow` only keeps it from passing."""
STAYS = frozenset({GuidanceIntent.WAIT, GuidanceIntent.NO, GuidanceIntent.CANCEL, GuidanceIntent.FOLLOW})


class DirectedSide(str, Enum):
    """Side to which the utterance directs the vehicle."""

    LEFT = "left"
    RIGHT = "right"


class Claim(str, Enum):
    """Claim of a passenger about the world: evidence for people and reasoners. It never overrides perception."""

    CLEAR = "clear"
    """No road user is approaching."""
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
    """Distance, speed and time in an utterance; None for a quantity that it does not contain.

    They only choose parameters within the bounds of a behavior, and never raise a speed.
    """

    distance_m: float | None = Field(default=None, gt=0.0)
    speed_mps: float | None = Field(default=None, gt=0.0)
    """Upper limit of the speed."""
    wait_s: float | None = Field(default=None, gt=0.0)

    @property
    def description(self) -> str:
        """Quantities in words: `3 m, at most 10 km/h, for 30 s`."""
        far = None if self.distance_m is None else f"{self.distance_m:.3g} m"
        fast = None if self.speed_mps is None else f"at most {3.6 * self.speed_mps:.0f} km/h"
        long = None if self.wait_s is None else f"for {self.wait_s:.0f} s"
        return ", ".join(filter(None, (far, fast, long)))


class Interpretation(FrozenModel):
    """A passenger's utterance as interpreted.

    The vehicle may act on `intent`. The intent is `unclear` if the interpreter is not certain of an intent that moves
    the vehicle; `likely` is then its best guess.
    """

    intent: GuidanceIntent
    side: DirectedSide | None = None
    negated: bool = False
    claims: tuple[Claim, ...] = ()
    urgent: bool = False
    confidence: float = Field(ge=0.0, le=1.0)
    """Calibrated probability that `likely` is the intended meaning."""
    likely: GuidanceIntent
    reader: str
    """Name and version of the interpreter."""
    limits: GuidanceLimits | None = None
    """Omitted from the JSON form if the utterance contains no quantity."""
    denied: tuple[Claim, ...] = ()
    """Claims that the utterance denies: an earlier claim of that kind no longer counts. Omitted from JSON if empty."""
    danger: bool = False
    """True if the utterance warns against driving over the object ahead. Omitted from JSON if False."""

    @model_serializer(mode="wrap")
    def _short(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = handler(self)
        for name in ("limits", "denied", "danger"):
            if not getattr(self, name):
                data.pop(name, None)
        return data

    @property
    def description(self) -> str:
        """Interpretation in words: `overtake on the left (91 %)`, `unclear (overtake? 87 %)`."""
        intent, likely = (item.value.replace("_", " ") for item in (self.intent, self.likely))
        sure = f"{100 * self.confidence:.0f} %"
        if intent != likely:
            return f"{intent} ({likely}? {sure})"
        if self.intent is GuidanceIntent.NONE:
            return f"nothing to do with the driving ({sure})"
        side = f" on the {self.side.value}" if self.side is not None else ""
        limits = "" if self.limits is None else f", {self.limits.description}"
        return f"{intent}{side} ({sure}){limits}"
