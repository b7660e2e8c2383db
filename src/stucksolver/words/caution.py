"""A call for care behind a request: "go round, but mind the cyclist" asks for what "go round" asks for.

The guard takes care at all times, so that nothing is lost with the call. The network knows too few of them and takes
some for a refusal.
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
"""In the call itself, these tell of something that may be a reason to wait: it is left to the network."""
REQUEST_AND_CALL = re.compile(
    r"^(?P<request>.*\w)\s*(?:[,.;:!–-]\s*|\s(?=but|and|just))(?:but |and |just |please |then )*"
    rf"(?:{CALLS})(?!\w)(?P<of>[^,.;:!?–]*)[.!]*$",
    re.IGNORECASE | re.DOTALL,
)


def without_call_for_care(text: str) -> str | None:
    """The request before a call for care that ends the text; None where there is none."""
    found = REQUEST_AND_CALL.match(text.strip().replace("\u2019", "'"))
    if found is None or WARNS.search(found["of"]):
        return None
    return found["request"]
