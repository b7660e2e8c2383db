"""What a passenger's words ask for. Words are data: they choose among intents, nothing else."""

from __future__ import annotations

import re

from stucksolver.decision import GuidanceIntent

_PATTERNS: tuple[tuple[GuidanceIntent, str], ...] = (
    # What others will do ("they will never stop for us") is no refusal.
    (
        GuidanceIntent.WAIT,
        r"\b(do ?n.?t|do not|(?<!will )(?<!will never )(never(?! mind)|stop|wait|stay)|hold on|not yet)\b",
    ),
    (GuidanceIntent.PULL_OVER, r"\b(pull(ing)? over|pull to the side|to the roadside)\b"),
    (GuidanceIntent.BACK_UP, r"\b(back (it )?up|reverse|go back a (bit|little))\b"),
    (GuidanceIntent.DRIVE_OVER, r"\bdrive (right )?over\b"),
    (GuidanceIntent.OVERTAKE, r"\b(over ?take|pass|get past|go (a)?round|drive (a)?round|get (a)?round)\b"),
    (GuidanceIntent.CHANGE_LEFT, r"\bleft\b"),
    (GuidanceIntent.CHANGE_RIGHT, r"\bright\b"),
    (GuidanceIntent.GO, r"\b(go|drive|move|edge|creep|continue|proceed)\b"),
)


def guidance_intent(text: str) -> GuidanceIntent:
    """The first intent whose words occur; a refusal ("don't overtake") wins over what it refuses."""
    lowered = text.lower()
    for intent, pattern in _PATTERNS:
        if re.search(pattern, lowered):
            return intent
    return GuidanceIntent.UNCLEAR
