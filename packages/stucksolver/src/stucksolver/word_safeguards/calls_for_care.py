"""Recognizes a call for care after a request: "go round, but mind the cyclist" requests the same as "go round".

The guard always takes care, so nothing is lost without the call. The network has too few such calls in its training
data and classifies some as a refusal.
"""

from __future__ import annotations

import re

CALLS = (
    r"be (?:very |really )?careful|careful(?:ly)?|mind|watch(?: out)?(?: for)?|look out(?: for)?|"
    r"take (?:good )?care|keep an eye (?:on|out for)"
)
WARNS = re.compile(
    r"(?<!\w)(?:no|not|nobody|never|stop|wait|until|till|first|before|come|comes|coming|is|are|'s|have|has|\w+n'?t)(?!\w)",
    re.IGNORECASE,
)
"""Words that make the call a possible reason to wait: the network then interprets the whole text."""
REQUEST_AND_CALL = re.compile(
    r"^(?P<request>.*\w)\s*(?:[,.;:!–-]\s*|\s(?=but|and|just))(?:but |and |just |please |then )*"
    rf"(?:{CALLS})(?!\w)(?P<of>[^,.;:!?–]*)[.!]*$",
    re.IGNORECASE | re.DOTALL,
)


def strip_caution(text: str) -> str | None:
    """Return the request before a call for care that ends the text; None without such a call."""
    match = REQUEST_AND_CALL.match(text.strip().replace("\u2019", "'"))
    if match is None or WARNS.search(match["of"]):
        return None
    return match["request"]
