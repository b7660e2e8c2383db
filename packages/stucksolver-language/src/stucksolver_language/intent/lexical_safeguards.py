"""Word lists that complement the network: words that can count as a yes, and words that hold the vehicle.

Sounds without meaning are no consent. While a question is open, the network takes unknown words such as "hrmpf grmbl"
for a yes. So a yes counts only if it contains a word of agreement. Otherwise it is unclear, and the passenger gets the
question again. Words that hold the vehicle count if the rest of the utterance is unclear: uncertainty leads to waiting,
never to driving on.
"""

from __future__ import annotations

import re

STOP_WORDS = (
    "stop|stopp|wait|halt|whoa|hold on|hold it|no|don'?t|do not|never|careful|watch out|"  # English
    "para|pare|alto|espera|espere|cuidado|"  # Spanish
    "warte|warten|wart|nein|nicht|anhalten|vorsicht|achtung|"  # German
    "arr[êe]te|arr[êe]tez|attends|attendez|non|pas|doucement"  # French
)
STOP_SIGNS = "[停等别別慢]|不[要行能可]|小心"
"""Stop words in Chinese, which is written without spaces."""
SHORT = 40
"""Longest utterance in which a stop word counts (characters).

Exclamations are short; a longer unclear sentence gets a question instead. Ours.
"""
PUTTING_OFF = re.compile(
    r"(?<!\w)(?:wait|hold on|hang on|one moment|espera|espere|warten?|warte mal|attends|attendez)(?!\w)|等",
    re.IGNORECASE,
)
HALTING = re.compile(rf"(?<!\w)(?:{STOP_WORDS})(?!\w)|{STOP_SIGNS}", re.IGNORECASE)


def is_stop_phrase(text: str) -> bool:
    """True if `text` is short and contains a stop word.

    It applies only to utterances that are unclear to the network, and can only keep the vehicle stopped.
    """
    phrase = text.strip().replace("\u2019", "'")
    return len(phrase) <= SHORT and HALTING.search(phrase) is not None


def puts_off(text: str) -> bool:
    """True if `text` contains a word that postpones, rather than one that declines."""
    return PUTTING_OFF.search(text) is not None


YES_WORDS = (
    "y|yes|yeah|yep|yup|ya|aye|ok|okay|okey|sure|fine|right|alright|good|great|correct|agreed?|absolutely|certainly|"
    "definitely|course|affirmative|confirm(?:ed)?|proceed|please|go|do|may|can|will|try|carry on|continue|happy|"
    "approved?|allow(?:ed)?|permission|granted|why not|no (?:problem|objections?)|mind|"  # English
    "s[ií]|claro|vale|adelante|bueno|dale|"  # Spanish
    "ja|jawohl|klar|gerne?|mach|los|einverstanden|genau|"  # German
    "oui|ouais|d'accord|vas-y|allez|bien s[ûu]r"  # French
)
YES_SIGNS = "[是好对行可]|同意|继续"
AGREES = re.compile(rf"(?<!\w)(?:{YES_WORDS})(?!\w)|{YES_SIGNS}", re.IGNORECASE)


def is_meaningful_yes(text: str) -> bool:
    """True if `text` contains a word of agreement."""
    return AGREES.search(text.replace("\u2019", "'")) is not None
