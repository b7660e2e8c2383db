"""A second check of a yes: sounds without meaning are no consent.

With a question open, the network reads unknown words such as "hrmpf grmbl" as a yes. So a yes counts only if it has a
word with which people agree; otherwise it is unclear, and the passenger is asked again.
"""

from __future__ import annotations

import re

WORDS = (
    "y|yes|yeah|yep|yup|ya|aye|ok|okay|okey|sure|fine|right|alright|good|great|correct|agreed?|absolutely|certainly|"
    "definitely|course|affirmative|confirm(?:ed)?|proceed|please|go|do|may|can|will|try|carry on|continue|happy|"
    "approved?|allow(?:ed)?|permission|granted|why not|no (?:problem|objections?)|mind|"  # English
    "s[ií]|claro|vale|adelante|bueno|dale|"  # Spanish
    "ja|jawohl|klar|gerne?|mach|los|einverstanden|genau|"  # German
    "oui|ouais|d'accord|vas-y|allez|bien s[ûu]r"  # French
)
SIGNS = "[是好对行可]|同意|继续"
AGREES = re.compile(rf"(?<!\w)(?:{WORDS})(?!\w)|{SIGNS}", re.IGNORECASE)


def is_meaningful_yes(text: str) -> bool:
    """True if `text` has a word with which people agree."""
    return AGREES.search(text.replace("\u2019", "'")) is not None
