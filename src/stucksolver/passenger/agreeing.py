"""A second look at a yes: sounds without meaning are no consent.

With a question open, the network takes what it has never seen, "hrmpf grmbl" for instance, for a yes. So a yes counts
only where there is a word in it with which people agree; without one it is unclear, and is asked back.
"""

from __future__ import annotations

import re

from stucksolver.scene import GuidanceIntent, Reading
from stucksolver.words import WordsReader

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


class AgreeingReader:
    """Reads as another reader does, but a yes needs a word of agreement."""

    def __init__(self, reader: WordsReader) -> None:
        self._reader = reader

    @property
    def name(self) -> str:
        """The other reader's: a record tells of that."""
        return self._reader.name

    def read(self, text: str, situation: str) -> Reading:
        """What `text` asks for, in doubt nothing."""
        reading = self._reader.read(text, situation)
        if reading.intent is GuidanceIntent.YES and AGREES.search(text.replace("\u2019", "'")) is None:
            return reading.model_copy(update={"intent": GuidanceIntent.UNCLEAR})
        return reading
