"""Extracts distance, speed and time from a passenger's utterance: "three meters", "not faster than 10 km/h", "slowly".

The network does not interpret numbers, so this grammar does. A quantity counts only if the words before it ask the
vehicle to drive that distance or wait that time; "a truck 50 meters ahead" is no distance to drive. A speed is always
an upper limit. Unmatched quantities are ignored: the plan then has its usual parameters.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from stucksolver.scene.interpretation import GuidanceLimits

ONES = (
    "one ein eine einen un una uno une|two zwei deux dos|three drei trois tres|four vier quatre cuatro|"
    "five fünf cinq cinco|six sechs seis|seven sieben sept siete|eight acht huit ocho|nine neun neuf nueve|"
    "ten zehn dix diez|eleven elf onze once|twelve zwölf douze doce|thirteen dreizehn treize trece|"
    "fourteen vierzehn quatorze catorce|fifteen fünfzehn quinze quince"
)
TENS = (
    "twenty zwanzig vingt veinte|thirty dreißig dreissig trente treinta|forty vierzig quarante cuarenta|"
    "fifty fünfzig cinquante cincuenta|sixty sechzig soixante sesenta|seventy|eighty|ninety"
)
TEEN = {"sixteen": 16.0, "seventeen": 17.0, "eighteen": 18.0, "nineteen": 19.0}
VAGUE = {"a": 1.0, "an": 1.0, "a couple of": 2.0, "a few": 3.0, "ein paar": 3.0, "quelques": 3.0, "unos": 3.0}
HALF = ("half a", "half an", "a half", "half of a", "eine halbe", "einen halben", "halben", "halbe", "un demi",
        "une demi", "demi", "medio", "media")  # fmt: skip
WORDS: dict[str, float] = {
    **{word: float(n) for n, row in enumerate(ONES.split("|"), 1) for word in row.split()},
    **{word: 10.0 * n for n, row in enumerate(TENS.split("|"), 2) for word in row.split()},
    **TEEN,
    **VAGUE,
    **dict.fromkeys(HALF, 0.5),
    "hundred": 100.0,
    "a hundred": 100.0,
}
HANZI = {c: float(n) for n, c in enumerate("一二三四五六七八九", 1)} | {"两": 2.0, "半": 0.5}

MILE_M, FOOT_M, YARD_M = 1609.344, 0.3048, 0.9144
"""Units of length (m), by the international definition of 1959."""
SPEEDS = (
    (r"km ?/ ?h|kmh|kph|k\.?p\.?h|kilomet(?:er|re)s? (?:an|per) hour|stundenkilometer|kilometer (?:pro|in der) stunde|"
     r"kilomètres?(?: à l'|[- /])heure|kilómetros? por hora|公里每小时", 1 / 3.6),
    (r"mph|miles? (?:an|per) hour", MILE_M / 3600.0),
    (r"m ?/ ?s|met(?:er|re)s? (?:a|per) second", 1.0),
)  # fmt: skip
DISTANCES = (
    (r"met(?:er|re)s?n?|mètres?|metros?|m|米", 1.0),
    (r"foot|feet|ft", FOOT_M),
    (r"yards?|yd", YARD_M),
    (r"centimet(?:er|re)s?|cm", 0.01),
)
TIMES = (
    (r"minuten?|minutes?|minutos?|mins?|分钟", 60.0),
    (r"seconds?|secs?|sekunden?|secondes?|segundos?|s|秒", 1.0),
)
KINDS = {"speed": SPEEDS, "distance": DISTANCES, "time": TIMES}
"""Kinds of quantities, each unit with its size in m/s, m or s. Speed comes first because of "meters per second"."""
LARGEST = {"speed": 40.0, "distance": 200.0, "time": 600.0}
"""Largest plausible quantity by kind (m/s, m, s). A larger one counts as a recognition error and is ignored. Ours."""

_UNITS = "|".join(f"(?P<{kind}{k}>{unit})" for kind, units in KINDS.items() for k, (unit, _) in enumerate(units))
_SPOKEN = "|".join(sorted(map(re.escape, WORDS), key=len, reverse=True))
_TENS = "|".join(word for row in TENS.split("|") for word in row.split()[:1])
_ONES = "|".join(row.split()[0] for row in ONES.split("|")[:9])
AMOUNT = re.compile(
    rf"(?P<number>\d+(?:[.,]\d+)?|(?<!\w)(?:{_TENS})[ -](?:{_ONES})(?!\w)|(?<!\w)(?:{_SPOKEN})(?!\w)|"
    r"[一二两三四五六七八九十百半]+)"
    rf"(?P<more>(?: and a half| einhalb| et demie?| y medi[oa])?)[ -]?(?:{_UNITS})(?![\w/])(?P<half>(?: and a half)?)",
    re.IGNORECASE,
)

CONDITION = re.compile(r"(?<!\w)(?:if|when|unless|until|till|wenn|falls|bis|si|quand|cuando|hasta)(?!\w)", re.I)
"""A sentence with a condition may give a speed or time of something other than the vehicle."""
FASTER = re.compile(
    r"(?:faster|quicker|more|over|above|exceed\w*|at least|min(?:imum)?|mindestens)\b[^,.;]{0,12}$", re.I
)
NOT = re.compile(r"(?:\b(?:not|no|never|nicht|pas|no|without)\b|n't)[^,.;]{0,25}$", re.I)
OTHERS = re.compile(
    r"(?:\b(?:is|are|was|does|doing|limit)\b|(?<!let)'s\b|'re\b|\b(?:he|she|it|they|who|which|that) (?:only |just )?"
    r"(?:\w+s|go|drive|do|move|crawl|ride)\b)[^,.;]{0,20}$",
    re.I,
)
"""The speed belongs to another road user, or to the road."""

_FILLER = (
    r"(?:\s|[-:]|\b(?:by|for|about|around|roughly|some|just|only|another|at|most|max|maximum|up|to|no|not|more|further|"
    r"farther|than|over|in|on|the|car|it|her|him|us|a|bit|off|even|forwards?|ahead|back|backwards?|left|right|closer|maybe|like|say|but|"
    r"please|und|um|etwa|noch|höchstens|maximal|mal|bitte|de|environ|encore|unos|otros|otro|"
    r"vor|zurück|links|rechts|nach)\b|\bd'|[,往左右前后移再])*"
)
DRIVES = re.compile(
    r"(?:\b(?:move|moving|go|back|reverse|retreat\w*|drive|roll|creep|edge|nudge|inch|shift|pull|scoot|advance|crawl|steer|swing|"
    r"forward|over|fahr\w*|rück\w*|roll\w*|zurück|recul\w*|avanc\w*|retrocede\w*|avanza\w*|muévete)\b"
    rf"|后退|倒车|前进|往前|往左|往右|开){_FILLER}$",
    re.I,
)
STARTS = re.compile(r"^\W*(?:about|just|another|only|even|at most|please|nur|noch|bitte)?\s*$", re.I)
THEN_DIRECTION = re.compile(
    r"^\s*(?:or so\s*|more\s*|further\s*)?(?:to the |nach )?(?:back|forwards?|ahead|left|right|more|further|zurück|vor|"
    r"links|rechts)\b",
    re.I,
)
A_PLACE = re.compile(
    r"^\s*(?:away|behind|from|off|wide|long|high|tall|deep|of|clear\w*|gap|space|room|between|breit|lang)\b", re.I
)
WAITS = re.compile(
    r"(?:\b(?:wait|hold on|hang on|hold|stay|stop|stand|pause|give (?:\w+ )?\w+|move|go|for|another|warte\w*|"
    r"bleib\w*|halte?|attends|attendez|patiente\w*|espera|espere|para)\b|等)"
    r"(?:\s|\b(?:for|here|there|still|about|around|just|another|at|least|most|please|noch|bitte|hier|pendant|encore|ici|"
    r"otros|unos|aquí|a|now|put)\b|[再个,])*$",
    re.I,
)
PAST = re.compile(r"\b(?:been|have|has|had|was|were|since|already|seit|schon|depuis|desde)\b|'ve", re.I)
IDLE = re.compile(r"^(?:ago|already|late)\b", re.I)

SLOW_MPS, WALKING_MPS = 2.8, 1.5
"""Speed limits for "slowly" and "at walking pace" (m/s): 10 and 5 km/h. Ours."""
WALKING = re.compile(
    r"(?:walking|snail'?s) (?:pace|speed)|a crawl\b|(?:dead|super|very|really|ever so|extra) slow(?:ly)?\b|"
    r"as slow(?:ly)? as (?:you can|possible)|schritt(?:tempo|geschwindigkeit)|ganz langsam|au pas\b|très lentement|"
    r"muy despacio|非常慢",
    re.I,
)
SLOWLY = re.compile(
    r"\b(?:slowly|nice and slow|take it slow|gently|langsam|lentement|despacio|lentamente)\b|慢慢|慢一?点",
    re.I,
)
NOT_SLOW = re.compile(
    r"(?:\b(?:so|too|not|never|this|that|how|less|why|is|are|was|goes|drives|moves|zu|so|trop|demasiado|going|driving|"
    r"moving|crawling|stop|he|they|she|them|it)\b|n't|'s|'re|太|别|不要?)\s*(?:\w+\s*)?$",
    re.I,
)

LEAD_IN = re.compile(
    r"[\s,;–-]*(?:\b(?:but|and|just|please|only|then|going|driving|aber|und|mais|et|pero|y)\b\s*)*"
    r"(?:(?:\b(?:do not|never|keep it|keep|stay)\b|\bdon't\b)\s*(?:go\b|drive\b|do\b)?\s*)?"
    r"(?:\b(?:not|no|any|at|most|max|maximum|of|a|the|speed|with|under|below|less|slower|faster|quicker|more|further|"
    r"farther|than|up to|to|about|around|roughly|by|for|in|unter|höchstens|maximal|mit|nicht|schneller|als|"
    r"pas|plus|vite|que|à|de|máximo|más)\b\.?\s*)*$",
    re.I,
)
LEAD_OUT = re.compile(r"^\s*(?:,?\s*(?:max(?:imum)?|at most|tops|or less|or slower|or so|or two|or three)\b)?", re.I)


@dataclass(frozen=True)
class Quantities:
    """Quantities in an utterance, and the utterance without its speed and distance.

    Attributes:
        limits: None if the utterance has no quantities.
        rest: Text for the network, which is less certain about a request with a number in it. It equals the utterance
            if there is no number.
    """

    limits: GuidanceLimits | None
    rest: str


def read_amounts(text: str) -> Quantities:
    """Return the quantities in a passenger's utterance.

    Args:
        text: The utterance, in English, German, French, Spanish or Chinese.
    """
    utterance = text.replace("\u2019", "'")
    found: dict[str, float] = {}
    cuts: list[tuple[int, int]] = []
    for kind, value, start, end in _amounts(utterance):
        found[kind] = min(found.get(kind, value), value)
        if kind != "time":
            cuts.append((_lead(utterance, start), end + len(LEAD_OUT.match(utterance[end:])[0])))  # type: ignore[index]
    slow = _slow_mps(utterance)
    if slow is not None:
        found.setdefault("speed", slow)
    if not found:
        return Quantities(None, text)
    limits = GuidanceLimits(
        distance_m=_rounded(found.get("distance")),
        speed_mps=_rounded(found.get("speed")),
        wait_s=_rounded(found.get("time")),
    )
    return Quantities(limits, _without(utterance, cuts) if cuts else text)


def _amounts(utterance: str) -> Iterator[tuple[str, float, int, int]]:
    """Yield each quantity that applies to the vehicle: its kind, its value (SI), and its start and end in the text."""
    for match in AMOUNT.finditer(utterance):
        before, after = _clause(utterance, match.start(), match.end())
        unit = next(name for name, text in match.groupdict().items() if name[-1].isdigit() and text is not None)
        kind, factor = unit[:-1], KINDS[unit[:-1]][int(unit[-1])][1]
        number = match["number"].lower()
        value = (_number(number) + 0.5 * (bool(match["more"]) + bool(match["half"]))) * factor
        meant = {"speed": _is_limit, "distance": _is_driven, "time": _is_waited}[kind]
        idiom = kind == "time" and number in ("a", "an", "one") and not match["half"] and not _at_length(before, value)
        if meant(before, after) and not idiom and 0.0 < value <= LARGEST[kind]:
            yield kind, value, match.start(), match.end()


def _clause(utterance: str, start: int, end: int) -> tuple[str, str]:
    """Return the text before and after a span, up to the borders of its sentence."""
    stops = [m.end() for m in re.finditer(r"[.!?;。！？](?!\d)", utterance) if m.end() <= start]
    return utterance[max(stops, default=0) : start], utterance[end:]


def _is_limit(before: str, after: str) -> bool:
    if CONDITION.search(before) or re.match(r"\s*(?:speed )?(?:limit|zone)", after, re.I):
        return False
    if FASTER.search(before) and not NOT.search(before):
        return False
    return OTHERS.search(before) is None


def _is_driven(before: str, after: str) -> bool:
    if CONDITION.search(before) or A_PLACE.match(after):
        return False
    clause = re.split(r"[,;:]", before)[-1]
    alone = STARTS.match(clause) is not None and THEN_DIRECTION.match(after) is not None
    return DRIVES.search(before) is not None or alone


def _is_waited(before: str, after: str) -> bool:
    return WAITS.search(before) is not None and not PAST.search(before) and not IDLE.match(after.strip())


def _at_length(before: str, value_s: float) -> bool:
    """True if "a minute" is a duration. "Wait a minute" and "for a second" only mean a short while."""
    return value_s >= 60.0 and re.search(r"\b(?:for|another)\s+(?:just |about )?$", before, re.I) is not None


def _slow_mps(utterance: str) -> float | None:
    for pattern, speed_mps in ((WALKING, WALKING_MPS), (SLOWLY, SLOW_MPS)):
        match = pattern.search(utterance)
        if (
            match is not None
            and NOT_SLOW.search(utterance[: match.start()]) is None
            and not CONDITION.search(utterance)
        ):
            return speed_mps
    return None


def _number(word: str) -> float:
    if word[0].isdigit():
        return float(word.replace(",", "."))
    if word in WORDS:
        return WORDS[word]
    if word[0] in "一二两三四五六七八九十百半":
        return _hanzi(word)
    tens, ones = re.split("[ -]", word)
    return WORDS[tens] + WORDS[ones]


def _hanzi(word: str) -> float:
    """Return a Chinese number up to some hundreds, such as 二十五."""
    total, digit = 0.0, 0.0
    for sign in word:
        size = {"十": 10.0, "百": 100.0}.get(sign)
        if size is None:
            digit = HANZI[sign]
        else:
            total, digit = total + (digit or 1.0) * size, 0.0
    return total + digit


def _lead(utterance: str, start: int) -> int:
    match = LEAD_IN.search(utterance[:start])
    return start if match is None else match.start()


def _without(utterance: str, cuts: list[tuple[int, int]]) -> str:
    pieces, at = [], 0
    for start, end in cuts:
        pieces.append(utterance[at:start])
        at = end
    return re.sub(r"\s+(?=[.,;!?])|(?<=\s)\s+", "", " ".join([*pieces, utterance[at:]])).strip(" ,")


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 2)
