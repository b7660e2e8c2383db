"""Changes a sentence as typing and speech recognition do."""

from __future__ import annotations

import re
from random import Random

FILLERS = ("um", "uh", "er", "erm", "like", "you know", "well", "so", "hmm")
MISRECOGNIZED = {
    "wait": "weight",
    "right": "write",
    "pass": "past",
    "past": "pass",
    "brake": "break",
    "way": "weigh",
    "their": "there",
    "there": "their",
    "van": "fan",
    "lane": "lain",
    "to": "too",
    "two": "to",
    "for": "four",
    "through": "threw",
    "by": "buy",
    "you're": "your",
    "its": "it's",
    "know": "no",
    "rode": "road",
    "road": "rode",
    "stay": "stey",
    "round": "rownd",
    "cyclists": "cyclist's",
    "overtake": "over take",
    "gonna": "going to",
    "around": "a round",
    "behind": "be hind",
    "can't": "cant",
    "don't": "dont",
    "isn't": "isnt",
    "won't": "wont",
    "please": "pls",
    "you": "u",
    "are": "r",
    "it's": "its",
}
"""Words that are typed or recognized for a word."""
NEVER = frozenset({"no", "not", "dont", "don't", "never", "stop"})
"""Words that are never changed: without them the meaning would be lost."""


def disturb(text: str, random: Random, strength: float = 1.0) -> str:
    """Return the sentence with some disturbances.

    They are lower case, no punctuation, typos, doubled or lost spaces, misrecognized words, and fillers.
    """
    words = text.split(" ")
    if random.random() < 0.20 * strength:
        words = [MISRECOGNIZED.get(word.lower(), word) if random.random() < 0.35 else word for word in words]
    if random.random() < 0.22 * strength:
        words = [_typo(word, random) if random.random() < 0.25 else word for word in words]
    if random.random() < 0.08 * strength:
        words.insert(random.randrange(len(words) + 1), random.choice(FILLERS))
    if random.random() < 0.04 * strength and len(words) > 1:
        at = random.randrange(len(words))
        words.insert(at, words[at])
    text = _joined(words, random, strength)
    if random.random() < 0.35:
        text = re.sub(r"[.,!?;:…—-]+(?=\s|$)", "", text)
    if random.random() < 0.10 * strength:
        text = text.replace("'", random.choice(("", "’")))
    pick = random.random()
    if pick < 0.35:
        text = text.lower()
    elif pick < 0.39:
        text = text.upper()
    elif pick < 0.75:
        text = text[:1].upper() + text[1:]
    if random.random() < 0.30 and text and text[-1].isalnum():
        text += random.choice((".", ".", "!", "!!", "...", "?"))
    return text.strip() or "..."


def _joined(words: list[str], random: Random, strength: float) -> str:
    double, lost = random.random() < 0.05 * strength, random.random() < 0.05 * strength
    out = words[0]
    for word in words[1:]:
        gap = " "
        if double and random.random() < 0.3:
            gap = "  "
        elif lost and random.random() < 0.2:
            gap = ""
        out += gap + word
    return out


def _typo(word: str, random: Random) -> str:
    if len(word) < 4 or word.lower().strip(".,!?") in NEVER or not word.isascii():
        return word
    at = random.randrange(1, len(word) - 1)
    kind = random.randrange(4)
    if kind == 0:
        return word[:at] + word[at + 1 :]
    if kind == 1:
        return word[:at] + word[at + 1] + word[at] + word[at + 2 :]
    if kind == 2:
        return word[:at] + word[at] + word[at:]
    return word[:at] + random.choice("abcdefghijklmnopqrstuvwxyz") + word[at + 1 :]
