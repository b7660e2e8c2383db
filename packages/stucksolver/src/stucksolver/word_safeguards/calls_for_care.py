"""A call for care after a request: "go round, but mind the cyclist" asks for the same as "go round".

The guard always takes care, so nothing is lost without the call. The network knows too few such calls and reads some as
a refusal.
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
"""Inside the call these words may be a reason to wait: the text is left to the network."""
REQUEST_AND_CALL = re.compile(
    r"^(?P<request>.*\w)\s*(?:[,.;:!–-]\s*|\s(?=but|and|just))(?:but |and |just |please |then )*"
    rf"(?:{CALLS})(?!\w)(?P<of>[^,.;:!?–]*)[.!]*$",
    re.IGNORECASE | re.DOTALL,
)


def strip_caution(text: str) -> str | None:
    """Return the request before a call for care that ends the text; None if there is none."""
    found = REQUEST_AND_CALL.match(text.strip().replace("\u2019", "'"))
    if found is None or WARNS.search(found["of"]):
        return None
    return found["request"]
