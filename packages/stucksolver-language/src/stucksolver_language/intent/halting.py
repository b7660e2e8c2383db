"""Words that hold the vehicle back if nothing else is understood: doubt leads to waiting, never to going on."""

from __future__ import annotations

import re

WORDS = (
    "stop|stopp|wait|halt|whoa|hold on|hold it|no|don'?t|do not|never|careful|watch out|"  # English
    "para|pare|alto|espera|espere|cuidado|"  # Spanish
    "warte|warten|wart|nein|nicht|anhalten|vorsicht|achtung|"  # German
    "arr[êe]te|arr[êe]tez|attends|attendez|non|pas|doucement"  # French
)
SIGNS = "[停等别別慢]|不[要行能可]|小心"
"""Chinese is written without spaces."""
SHORT = 40
"""Characters. People call out in few words; a longer sentence that is unclear is asked back."""
PUTTING_OFF = re.compile(
    r"(?<!\w)(?:wait|hold on|hang on|one moment|espera|espere|warten?|warte mal|attends|attendez)(?!\w)|等",
    re.IGNORECASE,
)
HALTING = re.compile(rf"(?<!\w)(?:{WORDS})(?!\w)|{SIGNS}", re.IGNORECASE)


def is_stop_phrase(text: str) -> bool:
    """True if `text` is short and has a word that holds someone back.

    It is used only for what the network finds unclear, and can only keep the vehicle where it is.
    """
    said = text.strip().replace("\u2019", "'")
    return len(said) <= SHORT and HALTING.search(said) is not None


def puts_off(text: str) -> bool:
    """True if `text` has a word that asks to wait, rather than one that refuses."""
    return PUTTING_OFF.search(text) is not None
