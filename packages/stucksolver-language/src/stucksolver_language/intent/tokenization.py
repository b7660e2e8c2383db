"""Encodes an utterance and its situation as word pieces, identically in training and in the vehicle."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tokenizers import Tokenizer

MAX_TOKENS = 128
"""Longest input of the network (tokens). Longer input is cut: first the situation, then the end of the utterance."""
FIRST = 101
"""Id of [CLS]."""
LAST = 102
"""Id of [SEP]."""
SITUATION_TOKENS = 44
"""Maximum number of tokens of the situation. Its end is used, because that contains the vehicle's question. Ours."""


def encoded(tokenizer: Tokenizer, situation: str, text: str) -> tuple[list[int], list[int]]:
    """Return the ids, and for each id 1 if it belongs to the utterance or 0 if it belongs to the situation.

    The order is [CLS] situation [SEP] utterance [SEP].
    """
    scene = tokenizer.encode(situation, add_special_tokens=False).ids[-SITUATION_TOKENS:]
    words = tokenizer.encode(text, add_special_tokens=False).ids[: MAX_TOKENS - 3 - len(scene)]
    ids = [FIRST, *scene, LAST, *words, LAST]
    return ids, [0] * (len(scene) + 2) + [1] * (len(words) + 1)
