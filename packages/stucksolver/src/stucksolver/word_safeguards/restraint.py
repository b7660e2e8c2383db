"""Removes from an interpretation what the utterance denies, forbids or warns of. It never adds a permission.

The network classifies kinds of sentences, and misses many denials, alarms and prohibitions. These rules process the
same words independently, and the more careful result counts.
"""

from __future__ import annotations

import re

from stucksolver.scene.interpretation import MOVES, Claim, GuidanceIntent, Interpretation
from stucksolver.word_safeguards.alarms import WAVES, calls_to_stop, foresees_collision, states_danger, warns
from stucksolver.word_safeguards.calls_for_care import strip_caution
from stucksolver.word_safeguards.clauses import Clause, any_of, clauses_of, is_of_another_time
from stucksolver.word_safeguards.evidence import GIVES, Evidence, denies_softness, evidence_for
from stucksolver.word_safeguards.living_beings import ALIVE, HARD, WHO, WHO_SIGNS
from stucksolver.word_safeguards.prohibitions import forbids

NAME = "alarms-1"
"""Name of the interpreter in an interpretation that these rules made without the network."""
AHEAD = frozenset({GuidanceIntent.GO, GuidanceIntent.OVERTAKE, GuidanceIntent.DRIVE_OVER})
"""Requests that lead past or over the object ahead: a danger or a prohibition holds them."""
STOPPING = frozenset({GuidanceIntent.PULL_OVER, GuidanceIntent.LET_ME_OUT})
"""Requests that end in a stop, so that a call to stop does not change them."""
HOLDABLE = AHEAD | {GuidanceIntent.YES, GuidanceIntent.NONE, GuidanceIntent.UNCLEAR, GuidanceIntent.UNLAWFUL}
"""Intents that an alarm turns into a wait."""
THIS = (
    r"(?:it|that|this|there|here|those|these|they|that (?:thing|bag|box|bundle|sack)|the (?:thing|bag|box|bundle|"
    r"sack))(?:'s|s|'re| is| are| was| were| (?:could|might|may|must) be)|looks like|full of|"
    r"i (?:can )?(?:see|saw|think)|das (?:ist|sind)|da (?:ist|sind|liegt|sitzt)|es ist|c'est|ce sont|il y a|y a|"
    r"(?:es|son|hay|parece)"
)
INSIDE = (
    r"(?:in|inside|under|underneath|beneath|with) (?:it|there|that|this|the|a)(?: (?:bag|box|bundle|sack|blanket|"
    r"cardboard|carton|cardboard box))?|inside|"
    r"drin|darin|in der \w+|dedans|dans (?:le|la|ce|l')\w*|dentro(?: de \w+)?|debajo"
)
IS_ALIVE = re.compile(
    rf"(?<!\w)(?:something|somebody|someone)(?: \w+)? (?:{INSIDE})(?!\w)|"
    rf"(?<!\w)(?:{THIS})(?: [\w'-]+){{0,4}}? (?:{WHO})(?!\w)|"
    rf"(?<!\w)(?:{WHO})(?!\w)(?: [\w'-]+){{0,2}}? (?:{INSIDE})(?!\w)|(?:是|有).{{0,4}}(?:{WHO_SIGNS})",
    re.IGNORECASE,
)
"""A living being as the object ahead, or inside it."""
IS_HARD = re.compile(
    rf"(?<!\w)(?:contains?|filled with|loaded with|holds)(?: \w+)? (?:{HARD.pattern})|"
    rf"(?<!\w)(?:{THIS})(?: [\w'-]+){{0,4}}? (?:{HARD.pattern})|"
    rf"(?:{HARD.pattern})(?: [\w'-]+){{0,2}}? (?:{INSIDE})(?!\w)|是.{{0,3}}(?:{HARD.pattern})",
    re.IGNORECASE,
)
DRIVE_OVER_IT = re.compile(
    any_of(
        r"(?:driv|run|roll|go|squash|crush|flatten)\w* (?:right |straight |him |her |it |them |that )*(?:over|"
        r"across) ?\w*", "überfahr\\w*", "drüber\\w*", "darüber\\w*",
        "rouler? (?:dessus|sur)", "écrase\\w*", "pas\\w+ (?:por )?encima", "aplast\\w*",
    ) + "|压过|壓過|开过去",
    re.IGNORECASE,
)  # fmt: skip


def restrained(reading: Interpretation, text: str) -> Interpretation:
    """Return the interpretation without what its utterance denies, forbids or warns of.

    Args:
        reading: The network's interpretation of `text`.
        text: The utterance. A call for care after a request does not change the request.
    """
    if reading.intent in MOVES:
        text = strip_caution(text) or text
    denied = denied_claims(text)
    claims = tuple(c for c in reading.claims if c not in GIVES or _is_given(c, reading, text))
    bars = bars_driving_over(text)
    changes = {"claims": claims, "denied": denied, "danger": bars}
    if _holds(reading, text):
        changes |= {"intent": GuidanceIntent.WAIT}
    return reading.model_copy(update=changes)


def alarm(text: str) -> Interpretation | None:
    """Return the interpretation of a call to stop or a predicted collision, without the network; else None."""
    if strip_caution(text) is not None or not (calls_to_stop(text) or foresees_collision(text)):
        return None
    return holding_interpretation(text)


def holding_interpretation(text: str) -> Interpretation:
    """Return the interpretation of an utterance that holds the vehicle, without the network."""
    wait = GuidanceIntent.WAIT
    return Interpretation(
        intent=wait,
        likely=wait,
        urgent=True,
        confidence=1.0,
        reader=NAME,
        denied=denied_claims(text),
        danger=bars_driving_over(text),
    )


def denied_claims(text: str) -> tuple[Claim, ...]:
    """Return the claims that the utterance denies. Earlier claims of these kinds then no longer count."""
    denied = {claim for claim in GIVES if evidence_for(claim, text) is Evidence.DENIED}
    if bars_driving_over(text):
        denied.add(Claim.SOFT_OBJECT)
    if forbids(text):
        denied.add(Claim.WAVED_THROUGH)
    return tuple(claim for claim in Claim if claim in denied)


def bars_driving_over(text: str) -> bool:
    """True if the utterance bars driving over the object ahead: it is alive, hard, or not what it looks like."""
    if is_of_another_time(text):
        return False
    is_danger = states_danger(text) or foresees_collision(text) or denies_softness(text)
    return is_danger or any(_is_dangerous(clause) for clause in clauses_of(text))


def _is_dangerous(clause: Clause) -> bool:
    if clause.is_negated(DRIVE_OVER_IT):
        return True
    if WAVES.search(clause.text):
        return False
    return any(clause.mentions(pattern) for pattern in (ALIVE, IS_ALIVE, IS_HARD))


def _is_given(claim: Claim, reading: Interpretation, text: str) -> bool:
    return (
        claim not in denied_claims(text)
        and evidence_for(claim, text) is Evidence.ASSERTED
        and not _holds(reading, text)
    )


def _holds(reading: Interpretation, text: str) -> bool:
    """True if the utterance holds the vehicle, regardless of the network's result."""
    if reading.intent not in HOLDABLE:
        return False
    return calls_to_stop(text) or warns(text) or states_danger(text) or forbids(text)
