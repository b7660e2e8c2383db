"""Splits an utterance into clauses, and detects negation, doubt and references to another time.

Negation counts within its clause: in "that's not a rock, it's only a bag" only the rock is denied. The languages are
those of the interpreter: English, German, French, Spanish and Chinese.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cached_property, lru_cache


def any_of(*words: str) -> str:
    """Return a pattern for one of these words, as whole words."""
    return rf"(?<!\w)(?:{'|'.join(words)})(?!\w)"


BREAKS = re.compile(
    r"[,;.:!?¡¿…，。！？；、\n]+|\s[-–—]+\s|[–—]|"
    + any_of("but", "and", "because", "so", "aber", "sondern", "und", "denn", "mais", "et", "pero", "sino", "y"),
    re.IGNORECASE,
)
IDIOMS = re.compile(
    any_of(
        r"(?:do ?n'?t|do not|never|no need to|not to|please) worry(?: about)?", "no worries", "never mind",
        "no problem",
        "no doubt", r"do ?n'?t be (?:afraid|scared|silly|stupid|ridiculous)", "no need to (?:worry|panic)",
        "nothing (?:else )?(?:but|than|more than)", "nothing else", r"is ?n'?t it", r"are ?n'?t (?:they|we)",
        "keine (?:angst|sorge|panik)", "nichts (?:weiter )?als", "kein problem",
        r"(?:ne )?t'inqui[eè]te pas", r"ne vous inqui[eé]tez pas", "pas de (?:panique|souci|problème)",
        "rien (?:d'autre )?que", "(?:n'est |est )?rien qu'une?",
        "no (?:te|se) preocupes?e?", "no pasa nada", "nada más que", "no es más que", "sin duda",
    ) + "|别担心|沒事|没事|不过是|不過是|只不过",
    re.IGNORECASE,
)  # fmt: skip
"""Idioms with a negation that denies nothing."""
NEGATION = re.compile(
    any_of(
        "not", r"\w+n['´]t", "cannot", "isnt", "arent", "wasnt", "dont", "doesnt", "didnt", "cant", "wont", "aint",
        "no",
        "never", "nobody", "no one", "noone", "none", "nothing", "neither", "nor", "without", "hardly", "barely",
        "anything but", "far from", "doubt(?:s|ed|ful)?", "den(?:y|ies)", "wrong", "false", "instead of", "rather than",
        "nicht", r"kein\w*", "nie", "niemals", "niemand(?:en)?", "nichts", "ohne", "weder", "kaum", "von wegen",
        "statt",
        "ne", r"n'\w+", "pas", r"aucun\w*", "jamais", "rien", "personne", "sans", "ni", "loin de",
        "nunca", "jamás", "nada", "nadie", r"ning[uú]n\w*", "sin", "tampoco",
    ) + "|(?<![就还過过])不(?!过|過|然|久)|没|沒|别|並非|并非|无",
    re.IGNORECASE,
)  # fmt: skip
DOUBTED = re.compile(
    any_of(
        "if", "unless", "maybe", "perhaps", "might", "could be", "may be", "hope(?:fully)?", "wonder", "unsure",
        "suppose",
        "(?:not|n't) (?:so |too |quite |really |entirely )?(?:sure|certain)", "whether", "who knows", "no idea",
        "looks? like", "seems?", "i guess", "pretend", "imagine", "let's say",
        "vielleicht", "ob", "wenn", "falls", "hoffentlich", "womöglich", "sieht aus wie",
        "peut-[eê]tre", "si", "j'espère", "on dirait", "quiz[aá]s?", "tal vez", "ojal[aá]", "a lo mejor", "parece",
    ) + "|也许|可能|如果|希望|是不是|[吗嗎]",
    re.IGNORECASE,
)  # fmt: skip
ASKS = re.compile(
    r"^\W*(?:is|are|was|were|isn't|aren't|does|do|did|can|could|would|should|what|who|how|ist|sind|est-ce|"
    r"es)(?!\w)[^.!]*\?",
    re.IGNORECASE,
)
OTHER_TIME = re.compile(
    any_of(
        "yesterday", "last (?:night|week|time|year|month|summer|winter)", r"\w+ (?:days?|weeks?|years?|months?) ago",
        "used to", "tomorrow", "next (?:week|year|month|time)", "once upon", "in the (?:film|movie|news)",
        "on the news",
        "gestern", "letzte\\w* (?:woche|nacht|mal|jahr)", "morgen", "damals", "hier soir", "la semaine dernière",
        "demain",
        "ayer", "anoche", "mañana", "la semana pasada",
    ) + "|昨天|明天|上次|以前",
    re.IGNORECASE,
)  # fmt: skip
"""References to another day: what happened then is no fact about the road now."""


@dataclass(frozen=True)
class Clause:
    """One clause of an utterance, in lower case."""

    text: str

    @cached_property
    def negated_at(self) -> int | None:
        """Index of the first negation in the text; None if there is none."""
        match = NEGATION.search(self.text)
        return None if match is None else match.start()

    def asserts(self, pattern: re.Pattern[str]) -> bool:
        """True if the clause contains the pattern and neither denies nor doubts it."""
        return pattern.search(self.text) is not None and self.negated_at is None and not DOUBTED.search(self.text)

    def mentions(self, pattern: re.Pattern[str]) -> bool:
        """True if the clause contains the pattern without a negation, perhaps in doubt."""
        return pattern.search(self.text) is not None and self.negated_at is None

    def denies(self, pattern: re.Pattern[str]) -> bool:
        """True if the clause contains the pattern after a negation, or at its own negation."""
        match = pattern.search(self.text)
        return match is not None and self.negated_at is not None and match.end() > self.negated_at

    def is_negated(self, pattern: re.Pattern[str]) -> bool:
        """True if the clause contains the pattern and a negation anywhere."""
        return pattern.search(self.text) is not None and self.negated_at is not None


def plain(text: str) -> str:
    """Return the text in lower case, with plain apostrophes and without idioms whose negation denies nothing."""
    lower = re.sub(r"\s+", " ", text.replace("\u2019", "'").strip().lower())
    return IDIOMS.sub(" , ", lower.replace("anything but", "not"))


@lru_cache(maxsize=64)
def clauses_of(text: str) -> tuple[Clause, ...]:
    """Return the clauses of an utterance in order."""
    parts = (part.strip() for part in BREAKS.split(plain(text)))
    return tuple(Clause(part) for part in parts if part)


def is_question(text: str) -> bool:
    """True if the utterance asks whether a statement is true. A why-question presupposes it."""
    return ASKS.search(text.replace("\u2019", "'").strip()) is not None


def is_of_another_time(text: str) -> bool:
    """True if the utterance is about another day."""
    return OTHER_TIME.search(plain(text)) is not None
