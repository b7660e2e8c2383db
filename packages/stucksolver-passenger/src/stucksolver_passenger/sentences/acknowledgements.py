"""The car's first reply to an utterance, before it has checked whether the request is possible."""

from __future__ import annotations

from stucksolver.scene import REQUESTS, Claim, GuidanceIntent, Interpretation

SEE = "Let me see whether that is possible."
INTENTS: dict[GuidanceIntent, str] = {
    GuidanceIntent.GO: f"You want me to drive on. {SEE}",
    GuidanceIntent.OVERTAKE: f"You want me to go past{{side}}. {SEE}",
    GuidanceIntent.WAIT: "All right, I will wait.",
    GuidanceIntent.BACK_UP: f"You want me to back up. {SEE}",
    GuidanceIntent.REROUTE: f"You want me to take another way. {SEE}",
    GuidanceIntent.TURN_AROUND: f"You want me to turn round. {SEE}",
    GuidanceIntent.DRIVE_OVER: f"You want me to drive over it. {SEE}",
    GuidanceIntent.PULL_OVER: f"You want me to pull over. {SEE}",
    GuidanceIntent.FOLLOW: "All right, I will stay behind.",
    GuidanceIntent.LET_ME_OUT: f"You want to get out. {SEE}",
    GuidanceIntent.CANCEL: "All right, I will drop that.",
    GuidanceIntent.YES: "You say yes, but I have not asked anything. What shall I do?",
    GuidanceIntent.NO: "All right, I will leave it.",
    GuidanceIntent.NONE: "Thank you. That asks nothing of my driving, so I will carry on.",
    GuidanceIntent.UNCLEAR: "I still do not understand, so I will carry on as before. The buttons show what I can do.",
    GuidanceIntent.UNLAWFUL: "I can't do that: it is not allowed. I will carry on as before.",
}
CLAIMS: dict[Claim, str] = {
    Claim.CLEAR: "Thank you. I will still look for myself before I go.",
    Claim.NOT_CLEAR: "Thank you. I will look out for that.",
    Claim.RETURNING_SOON: "All right, I will wait for them for a while.",
    Claim.LONG_STAY: "Thank you. Then I will look for a way past as soon as I may.",
    Claim.EMPTY: "Thank you. I will still keep my distance from it.",
    Claim.SOFT_OBJECT: "Thank you. I will drive over it only if it looks like that to me, too.",
    Claim.WAVED_THROUGH: "Thank you. I will go as soon as I see that it is safe.",
    Claim.BLOCKED_AHEAD: "Thank you. Tell me if I should take another way.",
    Claim.BROKEN_LIGHT: "Thank you. If I have to stop at it, I will ask the operator whether I may cross.",
    Claim.HURRY: "I understand. I will not wait for others longer than I must, but I take no risks.",
    Claim.NO_HURRY: "Thank you. I will take my time.",
}
"""Replies to an utterance that contains a claim about the world but no request. The first claim counts."""
ASKED_BACK = "I did not understand that. Shall I wait, drive on, go round it, or take another way?"
YES_OR_NO = "I did not understand that. Please answer with yes or no."
NOBODY_READS = "I could not read your words. Please try again, or use the buttons."
"""The interpreter was too late, failed, or is not installed."""

NOTHING_TO_STOP = (
    "All right, I will not begin anything new. I will keep to our route; ask me to pull over if I should stop."
)
"""Reply to a call to stop while no plan runs and the car drives: its own driving stack continues."""


def acknowledged(reading: Interpretation) -> str:
    """Return the first reply to an interpreted utterance."""
    if reading.intent is GuidanceIntent.NONE and reading.claims and not reading.negated:
        return CLAIMS[reading.claims[0]]
    side = "" if reading.side is None else f" on the {reading.side.value}"
    sentence = INTENTS[reading.intent].format(side=side)
    if reading.limits is None or reading.intent not in REQUESTS:
        return sentence
    return sentence.replace(f". {SEE}", f" ({reading.limits.description}). {SEE}")
